#pragma once
// Files that are either written completely or not at all.
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include "tetloom/host.hpp"

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
/// Thread safety: one thread at a time. Members that take a BlockLoop use its threads themselves; the bytes do not
/// depend on it.
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

  /// Appends `count` records of `record_bytes` bytes each. `encode(begin, end, out)` puts those of [begin, end) at
  /// `out`; it is called for blocks of them, in any order, several at once where `loop` does so.
  void write_records(std::size_t count, std::size_t record_bytes,
                     const std::function<void(std::size_t, std::size_t, char*)>& encode, const BlockLoop& loop);
  /// Appends the bytes of value(i) for 0 <= i < count, as they lie in memory; `value` is called like `encode`.
  template <class ValueOf>
  void put_each(std::size_t count, const ValueOf& value, const BlockLoop& loop) {
    using Value = decltype(value(std::size_t{0}));
    static_assert(std::is_trivially_copyable_v<Value>);
    const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t i = begin; i < end; ++i, out += sizeof(Value)) {
        const Value bytes = value(i);
        std::memcpy(out, &bytes, sizeof(Value));
      }
    };
    write_records(count, sizeof(Value), encode, loop);
  }
  /// Appends `count` items whose lengths are not known before, at most `most_bytes` each. `print(begin, end, out)` puts
  /// those of [begin, end) at `out` and returns their end; it is called like `encode`.
  void write_lines(std::size_t count, std::size_t most_bytes,
                   const std::function<char*(std::size_t, std::size_t, char*)>& print, const BlockLoop& loop);

  /// How many bytes have been written so far.
  std::uint64_t position() const { return flushed_ + used_; }

  /// Finishes the file and gives it its name. Nothing may be written afterwards.
  void commit();

 private:
  static constexpr std::size_t kCapacity = std::size_t{1} << 20;
  static constexpr std::size_t kLongestNumber = 64;
  static constexpr std::size_t kBlockBytes = std::size_t{256} << 10;  ///< of what one call encodes
  static constexpr std::size_t kBatchBlocks = 64;  ///< printed at once, while as many others are written

  void open();
  void flush();
  void write_out(const char* data, std::size_t size);
  void check_cancelled() const;
  void write_at(std::uint64_t offset, const char* data, std::size_t size) const;
  void write_blocks(std::size_t count, std::size_t record_bytes,
                    const std::function<void(std::size_t, std::size_t, char*)>& encode, const BlockLoop& loop);
  void write_batches(std::size_t count, std::size_t most_bytes,
                     const std::function<char*(std::size_t, std::size_t, char*)>& print, const BlockLoop& loop);
  void go_on_at(std::uint64_t offset);
  void discard() noexcept;
  [[noreturn]] void fail(const char* what, int error_number);
  Error error_of(const char* what, int error_number) const;

  std::filesystem::path target_;
  std::filesystem::path temporary_;  ///< empty when the target is written to directly
  const CancelToken* cancel_;
  int descriptor_ = -1;
  std::unique_ptr<char[]> buffer_;
  std::size_t used_ = 0;
  std::uint64_t flushed_ = 0;
};

}  // namespace tetloom
