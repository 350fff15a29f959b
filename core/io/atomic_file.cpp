#include "core/io/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <system_error>

namespace tetloom {
namespace {

/// Follows symbolic links, so that the file behind them is replaced and not the link.
std::filesystem::path resolve(const std::filesystem::path& target) {
  std::error_code error;
  if (!std::filesystem::is_symlink(target, error)) return target;
  const std::filesystem::path resolved = std::filesystem::canonical(target, error);
  return error ? target : resolved;
}

std::filesystem::path temporary_name(const std::filesystem::path& target) {
  // Counts the temporaries of this process; every value is used once, so no order is needed.
  static std::atomic<unsigned> counter{0};
  // Names may have 255 bytes; the start of a long one says enough.
  std::string name(".");
  name += target.filename().string().substr(0, 200);
  name += '.';
  name += std::to_string(::getpid());
  name += '-';
  name += std::to_string(counter.fetch_add(1, std::memory_order_relaxed));
  return target.parent_path() / (name += ".tmp");
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target, const CancelToken* cancel)
    : target_(resolve(target)), cancel_(cancel), buffer_(std::make_unique_for_overwrite<char[]>(kCapacity)) {
  open();
}

AtomicFile::~AtomicFile() { discard(); }

void AtomicFile::open() {
  if (!target_.has_filename()) fail("write", EISDIR);
  struct stat info {};
  const bool exists = ::stat(target_.c_str(), &info) == 0;
  if (exists && S_ISDIR(info.st_mode)) fail("write", EISDIR);
  if (exists && !S_ISREG(info.st_mode)) {
    descriptor_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor_ < 0) fail("write", errno);
    return;
  }
  if (exists && ::access(target_.c_str(), W_OK) != 0) fail("overwrite", errno);
  do {
    temporary_ = temporary_name(target_);
    descriptor_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  } while (descriptor_ < 0 && errno == EEXIST);
  if (descriptor_ < 0) {
    const int reason = errno;
    temporary_.clear();
    fail("write", reason);
  }
  // A file of somebody else in a shared folder cannot pass its permissions on; the usual ones are right then.
  if (exists) static_cast<void>(::fchmod(descriptor_, info.st_mode & 07777));
}

void AtomicFile::write(const void* data, std::size_t size) {
  if (size > kCapacity - used_) {
    flush();
    if (size >= kCapacity) {
      write_out(static_cast<const char*>(data), size);
      return;
    }
  }
  if (size > 0) std::memcpy(buffer_.get() + used_, data, size);
  used_ += size;
}

void AtomicFile::flush() {
  const std::size_t size = used_;
  used_ = 0;
  write_out(buffer_.get(), size);
}

void AtomicFile::write_out(const char* data, std::size_t size) {
  constexpr std::size_t kChunk = std::size_t{16} << 20;  // between two looks at the cancel flag
  while (size > 0) {
    if (cancel_ != nullptr && cancel_->cancelled()) {
      discard();
      cancel_->check();
    }
    const ssize_t written = ::write(descriptor_, data, size < kChunk ? size : kChunk);
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) fail("write", errno);
    data += written;
    size -= static_cast<std::size_t>(written);
    flushed_ += static_cast<std::uint64_t>(written);
  }
}

void AtomicFile::commit() {
  flush();
  if (cancel_ != nullptr && cancel_->cancelled()) {
    discard();
    cancel_->check();
  }
  const int descriptor = descriptor_;
  descriptor_ = -1;
  if (::close(descriptor) != 0 && errno != EINTR) fail("write", errno);
  if (temporary_.empty()) return;
  if (::rename(temporary_.c_str(), target_.c_str()) != 0) fail("replace", errno);
  temporary_.clear();
}

void AtomicFile::discard() noexcept {
  if (descriptor_ >= 0) ::close(descriptor_);
  descriptor_ = -1;
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
  temporary_.clear();
}

void AtomicFile::fail(const char* what, int error_number) {
  discard();
  throw Error(ErrorCode::OutputFailed, std::string("cannot ") + what + " '" + target_.string() +
                                           "': " + std::generic_category().message(error_number));
}

}  // namespace tetloom
