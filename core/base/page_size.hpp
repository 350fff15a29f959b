#pragma once
// Fewer, larger pages for large arrays: the first touch of small ones costs more than what is then written there.
#include <cstddef>
#include <span>

namespace tetloom {

/// A wish: the system may do otherwise. What lies there stays as it is.
void want_huge_pages(std::span<std::byte> storage) noexcept;

template <class T>
void want_huge_pages(std::span<T> storage) noexcept {
  want_huge_pages(std::as_writable_bytes(storage));
}

}  // namespace tetloom
