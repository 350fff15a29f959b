#pragma once
// Fewer, larger pages for large arrays: the first touch of small ones costs more than what is then written there.
#include <cstddef>
#include <span>
#include <vector>

#include "tetloom/host.hpp"

namespace tetloom {

/// A wish: the system may do otherwise. What lies there stays as it is.
void want_huge_pages(std::span<std::byte> storage) noexcept;

template <class T>
void want_huge_pages(std::span<T> storage) noexcept {
  want_huge_pages(std::as_writable_bytes(storage));
}

/// Touches storage that nothing lies in yet, in large blocks side by side: the system hands pages out at the first
/// touch.
void touch_pages(std::span<std::byte> raw_storage, const BlockLoop& loop);

/// Room for `count` items in all, on large pages touched by the threads of the loop.
template <class T>
void reserve_touched(std::vector<T>& items, std::size_t count, const BlockLoop& loop) {
  if (items.capacity() >= count) return;
  items.reserve(count);
  const std::size_t used = items.size() * sizeof(T), whole = items.capacity() * sizeof(T);
  const std::span<std::byte> raw(reinterpret_cast<std::byte*>(items.data()) + used, whole - used);
  want_huge_pages(raw);
  touch_pages(raw, loop);
}

/// How many blocks touch_pages cuts so many bytes into.
constexpr std::size_t touched_blocks(std::size_t bytes) { return (bytes >> 22) + 1; }

}  // namespace tetloom
