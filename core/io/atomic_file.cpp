#include "core/io/atomic_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <system_error>
#include <vector>

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

void AtomicFile::check_cancelled() const {
  if (cancel_ != nullptr) cancel_->check();
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

void AtomicFile::write_records(std::size_t count, std::size_t record_bytes,
                               const std::function<void(std::size_t, std::size_t, char*)>& encode,
                               const BlockLoop& loop) try {
  if (count == 0 || record_bytes == 0) return;
  if (count <= kCapacity / record_bytes) {
    if (count * record_bytes > kCapacity - used_) flush();
    encode(0, count, buffer_.get() + used_);
    used_ += count * record_bytes;
    return;
  }
  flush();
  if (!temporary_.empty()) return write_blocks(count, record_bytes, encode, loop);
  const auto print = [&](std::size_t begin, std::size_t end, char* out) {
    encode(begin, end, out);
    return out + (end - begin) * record_bytes;
  };
  write_batches(count, record_bytes, print, loop);
} catch (...) {
  discard();
  throw;
}

// Pre: the target is a regular file; nothing is in the buffer.
void AtomicFile::write_blocks(std::size_t count, std::size_t record_bytes,
                              const std::function<void(std::size_t, std::size_t, char*)>& encode,
                              const BlockLoop& loop) {
  const std::size_t grain = std::max<std::size_t>(1, kBlockBytes / record_bytes);
  // Where ext4 has set blocks aside, it takes their pages in two thirds of the time. What fails is left to the writes,
  // which tell why.
  static_cast<void>(
      ::fallocate(descriptor_, 0, static_cast<off_t>(flushed_), static_cast<off_t>(count * record_bytes)));
  loop.for_blocks(count, grain, [&](std::size_t begin, std::size_t end) {
    check_cancelled();
    const std::size_t bytes = (end - begin) * record_bytes;
    const auto block = std::make_unique_for_overwrite<char[]>(bytes);
    encode(begin, end, block.get());
    write_at(flushed_ + begin * record_bytes, block.get(), bytes);
  });
  go_on_at(flushed_ + count * record_bytes);
}

void AtomicFile::write_lines(std::size_t count, std::size_t most_bytes,
                             const std::function<char*(std::size_t, std::size_t, char*)>& print,
                             const BlockLoop& loop) try {
  if (count <= kCapacity / most_bytes) {
    if (count * most_bytes > kCapacity - used_) flush();
    used_ = static_cast<std::size_t>(print(0, count, buffer_.get() + used_) - buffer_.get());
    return;
  }
  flush();
  write_batches(count, most_bytes, print, loop);
} catch (...) {
  discard();
  throw;
}

// Where blocks go is known once those before them have been printed, so a batch is written while the next is printed.
// Pre: nothing is in the buffer.
void AtomicFile::write_batches(std::size_t count, std::size_t most_bytes,
                               const std::function<char*(std::size_t, std::size_t, char*)>& print,
                               const BlockLoop& loop) {
  struct Block {
    std::unique_ptr<char[]> text;
    std::size_t bytes = 0;
    std::uint64_t offset = 0;
  };
  const bool in_order = temporary_.empty();
  const std::size_t grain = std::max<std::size_t>(1, kBlockBytes / most_bytes);
  std::vector<Block> printed, printing;
  std::size_t ready = 0;  // blocks of `printed` that are to be written
  std::uint64_t offset = flushed_;
  for (std::size_t begin = 0; begin < count || ready > 0; begin += kBatchBlocks * grain) {
    const std::size_t left = begin < count ? (count - begin + grain - 1) / grain : 0;
    const std::size_t blocks = std::min(left, kBatchBlocks);
    if (printing.size() < blocks) printing.resize(blocks);
    const auto work = [&](std::size_t i, std::size_t) {
      check_cancelled();
      if (i < ready) return write_at(printed[i].offset, printed[i].text.get(), printed[i].bytes);
      Block& block = printing[i - ready];
      const std::size_t first = begin + (i - ready) * grain;
      if (!block.text) block.text = std::make_unique_for_overwrite<char[]>(grain * most_bytes);
      char* const end = print(first, std::min(count, first + grain), block.text.get());
      block.bytes = static_cast<std::size_t>(end - block.text.get());
    };
    loop.for_blocks(ready + blocks, 1, work);
    for (std::size_t i = 0; i < blocks; ++i) {
      printing[i].offset = offset;
      offset += printing[i].bytes;
      if (in_order) write_out(printing[i].text.get(), printing[i].bytes);
    }
    printed.swap(printing);
    ready = in_order ? 0 : blocks;
  }
  if (!in_order) go_on_at(offset);
}

// Called by several threads at once, so it leaves the file as it is when it fails.
void AtomicFile::write_at(std::uint64_t offset, const char* data, std::size_t size) const {
  while (size > 0) {
    const ssize_t written = ::pwrite(descriptor_, data, size, static_cast<off_t>(offset));
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) throw error_of("write", errno);
    data += written;
    offset += static_cast<std::uint64_t>(written);
    size -= static_cast<std::size_t>(written);
  }
}

void AtomicFile::go_on_at(std::uint64_t offset) {
  if (::lseek(descriptor_, static_cast<off_t>(offset), SEEK_SET) < 0) throw error_of("write", errno);
  flushed_ = offset;
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
  throw error_of(what, error_number);
}

Error AtomicFile::error_of(const char* what, int error_number) const {
  return Error(ErrorCode::OutputFailed, std::string("cannot ") + what + " '" + target_.string() +
                                            "': " + std::generic_category().message(error_number));
}

}  // namespace tetloom
