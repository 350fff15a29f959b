#include "core/base/free_memory.hpp"

#include <cstdlib>
#include <mutex>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace tetloom {

void give_back_free_memory() noexcept {
#ifdef __GLIBC__
  // Where memory comes from elsewhere (a sanitizer, an allocator of the host), the first call sets up glibc's own,
  // which several threads must not do at once.
  static std::mutex mutex;
  const std::scoped_lock lock(mutex);
  ::malloc_trim(0);
#endif
}

void return_freed_memory() noexcept {
#ifdef __GLIBC__
  ::mallopt(M_MMAP_THRESHOLD, 8 << 20);
  ::mallopt(M_TRIM_THRESHOLD, 64 << 20);
  ::mallopt(M_TOP_PAD, 8 << 20);
#endif
}

}  // namespace tetloom
