#pragma once
// Private to core/io: a file in memory, and bounded readers over it that turn everything unexpected into an Error with
// the place in the file.
#include <bit>
#include <charconv>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include "tetloom/host.hpp"

namespace tetloom::detail {

static_assert(std::endian::native == std::endian::little, "the writers assume a little-endian machine");

/// How an InputFile has its bytes.
enum class FileAccess {
  InMemory,  ///< all of them, whatever becomes of the file
  Mapped,    ///< as they are asked for; the file must not become shorter meanwhile
};

/// The bytes of a regular, non-empty file.
class InputFile {
 public:
  InputFile(const std::filesystem::path& path, const CancelToken* cancel, FileAccess access = FileAccess::InMemory);
  ~InputFile();
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::string_view bytes() const { return {begin_, size_}; }
  /// Of a mapped file, what has been looked at takes no memory until it is looked at again. Cheap enough to be called
  /// after every few megabytes.
  void let_go() const;
  void check_cancelled() const {
    if (cancel_ != nullptr) cancel_->check();
  }
  /// Throws InputUnreadable: "'part.vtu': what, at byte 17".
  [[noreturn]] void fail(const std::string& what, const char* where) const;
  /// The same with a line number.
  [[noreturn]] void fail_at_line(const std::string& what, const char* where) const;
  /// Throws without a place.
  [[noreturn]] void fail(ErrorCode code, const std::string& what) const;

 private:
  std::string name_;
  const CancelToken* cancel_;
  std::unique_ptr<char[]> data_;  // null where it is mapped
  const char* begin_ = nullptr;
  std::size_t size_ = 0;
};

template <class Number>
Number byte_swapped(Number value) {
  char bytes[sizeof(Number)], reversed[sizeof(Number)];
  std::memcpy(bytes, &value, sizeof(Number));
  for (std::size_t i = 0; i < sizeof(Number); ++i) reversed[i] = bytes[sizeof(Number) - 1 - i];
  std::memcpy(&value, reversed, sizeof(Number));
  return value;
}

/// Reads numbers, one after the other, from `text`, which lies inside the bytes of `file`.
class Cursor {
 public:
  Cursor(const InputFile& file, std::string_view text)
      : file_(&file), at_(text.data()), end_(text.data() + text.size()) {}

  const InputFile& file() const { return *file_; }
  const char* at() const { return at_; }
  std::size_t left() const { return static_cast<std::size_t>(end_ - at_); }
  std::string_view rest() const { return {at_, left()}; }
  /// Pre: `place` lies between at() and the end.
  void jump(const char* place) { at_ = place; }

  // Binary.
  template <class Number>
  Number read(bool swap = false) {
    if (left() < sizeof(Number)) file_->fail("the file ends too early", at_);
    Number value;
    std::memcpy(&value, at_, sizeof(Number));
    at_ += sizeof(Number);
    return swap ? byte_swapped(value) : value;
  }
  /// Throws unless `count` items of at least `bytes_each` bytes can follow.
  void expect(std::uint64_t count, std::size_t bytes_each) const {
    if (count > left() / bytes_each) file_->fail("a count of " + std::to_string(count) + " exceeds the file", at_);
  }

  // Text.
  static bool is_space(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }
  void skip_space() {
    while (at_ < end_ && is_space(*at_)) ++at_;
  }
  /// The next run of characters that are not white space; empty at the end.
  std::string_view token() {
    skip_space();
    const char* const begin = at_;
    while (at_ < end_ && !is_space(*at_)) ++at_;
    return {begin, static_cast<std::size_t>(at_ - begin)};
  }
  /// The rest of the line, without its end, which is passed over.
  std::string_view line();
  /// The next token as a number, which must fill it.
  template <class Number>
  Number parse() {
    skip_space();
    const char* const begin = at_ < end_ && *at_ == '+' ? at_ + 1 : at_;
    Number value{};
    const std::from_chars_result result = std::from_chars(begin, end_, value);
    if constexpr (std::is_floating_point_v<Number>) {
      // Beyond the range of doubles: from_chars leaves the value, and strtod gives the nearest one.
      if (result.ec == std::errc::result_out_of_range) value = nearest(begin, result.ptr);
    }
    const bool fine =
        result.ec == std::errc() || (std::is_floating_point_v<Number> && result.ec == std::errc::result_out_of_range);
    if (!fine || (result.ptr < end_ && !is_space(*result.ptr))) fail_parse();
    at_ = result.ptr;
    return value;
  }

 private:
  static double nearest(const char* begin, const char* end);
  [[noreturn]] void fail_parse() const;

  const InputFile* file_;
  const char* at_;
  const char* end_;
};

}  // namespace tetloom::detail
