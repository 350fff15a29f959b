#include "tetloom/storage.hpp"

#include <cstdlib>
#include <cstring>
#include <new>

// The thread sanitizer does not follow mremap, and takes what a thread wrote at an address before for a race.
#if defined(__linux__) && !defined(__SANITIZE_THREAD__)
#define TETLOOM_MAPS_PAGES 1
#include <sys/mman.h>
#endif

namespace tetloom::detail {
namespace {

#ifdef TETLOOM_MAPS_PAGES

constexpr std::size_t kMapped = std::size_t{1} << 18;  // bytes from which storage is a mapping of its own

constexpr std::size_t kHuge = std::size_t{1} << 22;  // bytes from which huge pages are asked for

bool is_mapped(std::size_t bytes) { return bytes >= kMapped; }

// Fewer, larger pages: the first touch of small ones costs more than most of what is then written there.
void* with_huge_pages(void* storage, std::size_t bytes) {
  if (bytes >= kHuge) ::madvise(storage, bytes, MADV_HUGEPAGE);  // a wish; may fail
  return storage;
}

void* map(std::size_t bytes) {
  void* storage = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (storage == MAP_FAILED) throw std::bad_alloc();
  return with_huge_pages(storage, bytes);
}

void* remap(void* storage, std::size_t old_bytes, std::size_t new_bytes) {
  void* moved = ::mremap(storage, old_bytes, new_bytes, MREMAP_MAYMOVE);
  if (moved == MAP_FAILED) throw std::bad_alloc();
  return with_huge_pages(moved, new_bytes);
}

void unmap(void* storage, std::size_t bytes) { ::munmap(storage, bytes); }

#else

bool is_mapped(std::size_t) { return false; }
void* map(std::size_t) { throw std::bad_alloc(); }
void* remap(void*, std::size_t, std::size_t) { throw std::bad_alloc(); }
void unmap(void*, std::size_t) {}

#endif

void* allocate(std::size_t bytes) {
  if (is_mapped(bytes)) return map(bytes);
  void* storage = std::malloc(bytes);
  if (storage == nullptr) throw std::bad_alloc();
  return storage;
}

void release(void* storage, std::size_t bytes) {
  if (storage != nullptr && is_mapped(bytes)) return unmap(storage, bytes);
  std::free(storage);
}

}  // namespace

void* resize_storage(void* storage, std::size_t old_bytes, std::size_t used, std::size_t new_bytes) {
  if (new_bytes == 0) {
    release(storage, old_bytes);
    return nullptr;
  }
  if (storage != nullptr && is_mapped(old_bytes) && is_mapped(new_bytes)) return remap(storage, old_bytes, new_bytes);
  void* moved = allocate(new_bytes);
  if (used > 0) std::memcpy(moved, storage, used);
  release(storage, old_bytes);
  return moved;
}

}  // namespace tetloom::detail
