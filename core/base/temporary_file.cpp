#include "core/base/temporary_file.hpp"

#include <fcntl.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "tetloom/error.hpp"

namespace tetloom {

TemporaryFile::TemporaryFile(const std::string& kind) {
  std::error_code none;
  std::string path = (std::filesystem::temp_directory_path(none) / ("tetloom-" + kind + "-XXXXXX")).string();
  if (none) throw Error(ErrorCode::OutputFailed, "the folder for temporary files: " + none.message());
  const int file = ::mkstemp(path.data());
  if (file < 0) throw Error(ErrorCode::OutputFailed, "'" + path + "': " + std::strerror(errno));
  ::close(file);
  path_ = path;
}

TemporaryFile::~TemporaryFile() {
  std::error_code ignored;
  std::filesystem::remove(path_, ignored);
}

std::shared_ptr<const std::byte> map_file(const std::filesystem::path& path, std::size_t bytes) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (file < 0) return nullptr;
  struct stat info {};
  void* pages = MAP_FAILED;
  if (::fstat(file, &info) == 0 && S_ISREG(info.st_mode) && static_cast<std::size_t>(info.st_size) == bytes)
    pages = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, file, 0);
  ::close(file);
  if (pages == MAP_FAILED) return nullptr;
  return {static_cast<const std::byte*>(pages),
          [bytes](const std::byte* mapped) { ::munmap(const_cast<std::byte*>(mapped), bytes); }};
}

}  // namespace tetloom
