#pragma once
// Files that are either written completely or not at all.
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "core/base/progress.hpp"

namespace tetloom {

/// Writes to a temporary file beside the target, which takes the target's place in `commit`. Without a commit, the
/// destructor removes the temporary and the target is as it was before.
///
/// A target that is a symbolic link is followed; one that is no regular file (a pipe, a device such as /dev/stdout) is
/// written to directly. An existing target passes on its permissions. The library ignores no signals: a host that
/// limits the size of files has to ignore SIGXFSZ, and SIGPIPE for pipes, to see them as errors.
///
/// Errors: Error(OutputFailed) with the system's reason from any member; the temporary is removed at once then, and the
/// file must not be used any more. Error(Cancelled) from the writing members once `cancel` is raised.
/// Thread safety: one thread at a time.
class AtomicFile {
 public:
  /// Creates the temporary, so that a folder that cannot be written to is found before the work of filling it.
  /// `cancel` may be null and must outlive the file.
  explicit AtomicFile(const std::filesystem::path& target, const CancelToken* cancel = nullptr);
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  void write(const void* data, std::size_t size);
  void write(std::string_view text) { write(text.data(), text.size()); }

  /// Appends the bytes of a number as they lie in memory.
  template <class Number>
  void put(Number value) {
    if (kCapacity - used_ < sizeof(Number)) flush();
    std::memcpy(buffer_.get() + used_, &value, sizeof(Number));
    used_ += sizeof(Number);
  }
  /// Appends a number in the shortest decimal form that reads back as the same number.
  template <class Number>
  void print(Number value) {
    if (kCapacity - used_ < kLongestNumber) flush();
    used_ = static_cast<std::size_t>(std::to_chars(buffer_.get() + used_, buffer_.get() + kCapacity, value).ptr -
                                     buffer_.get());
  }
  void print(char character) { put(character); }

  /// How many bytes have been written so far.
  std::uint64_t position() const { return flushed_ + used_; }

  /// Finishes the file and gives it its name. Nothing may be written afterwards.
  void commit();

 private:
  static constexpr std::size_t kCapacity = std::size_t{1} << 20;
  static constexpr std::size_t kLongestNumber = 64;

  void open();
  void flush();
  void write_out(const char* data, std::size_t size);
  void discard() noexcept;
  [[noreturn]] void fail(const char* what, int error_number);

  std::filesystem::path target_;
  std::filesystem::path temporary_;  ///< empty when the target is written to directly
  const CancelToken* cancel_;
  int descriptor_ = -1;
  std::unique_ptr<char[]> buffer_;
  std::size_t used_ = 0;
  std::uint64_t flushed_ = 0;
};

}  // namespace tetloom
