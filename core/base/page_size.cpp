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

}  // namespace tetloom
