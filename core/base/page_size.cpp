#include "core/base/page_size.hpp"

#include <cstdint>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace tetloom {

// Whole huge pages only: what lies beside the storage is not its own.
void want_huge_pages(std::span<std::byte> storage) noexcept {
#if defined(__linux__)
  constexpr std::uintptr_t kHugePage = std::uintptr_t{1} << 21;
  const auto address = reinterpret_cast<std::uintptr_t>(storage.data());
  const std::uintptr_t first = (address + kHugePage - 1) / kHugePage * kHugePage;
  const std::uintptr_t end = (address + storage.size()) / kHugePage * kHugePage;
  if (first < end) ::madvise(storage.data() + (first - address), end - first, MADV_HUGEPAGE);
#else
  static_cast<void>(storage);
#endif
}

void touch_pages(std::span<std::byte> raw_storage, const BlockLoop& loop) {
  constexpr std::size_t kPage = 1 << 12, kBlock = 1 << 22;
  loop.for_blocks(raw_storage.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t at = begin; at < end; at += kPage) raw_storage[at] = std::byte{0};
  });
}

}  // namespace tetloom
