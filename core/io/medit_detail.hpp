#pragma once
// Private to core/io: what MEDIT files have in common, whatever keywords they hold: words of text files, and the chain
// of keywords of binary files as libMeshb makes them, versions 1 to 4, either byte order.
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string_view>

#include "core/io/input_detail.hpp"

namespace tetloom::detail {

constexpr std::size_t kRecordsBetweenLooks = std::size_t{1} << 18;  // at the cancel flag

/// Codes of keywords that other files than meshes know as well.
constexpr std::int32_t kMeditDimension = 3, kMeditEnd = 54;
/// And those of files of solutions.
constexpr std::int32_t kSolAtVertices = 62, kSolAtTetrahedra = 66;

/// A MEDIT file as text: a cursor that finds keywords.
class MeditWords : public Cursor {
 public:
  /// Errors: InputUnreadable where the file starts with something else than its version or a comment.
  explicit MeditWords(const InputFile& file);

  /// The next keyword, or an error at the end of the file: behind the keyword End nothing may be asked for. Skips
  /// everything up to a word: the numbers of keywords that are of no interest, and comments.
  std::string_view next_keyword();
  /// A count of records of at least `bytes_each` bytes.
  std::uint64_t read_count(std::size_t bytes_each);
  /// The number behind the keyword Dimension.
  int read_dimension();
};

/// A binary MEDIT file, read keyword by keyword.
class MeditSections {
 public:
  /// Errors: InputUnreadable by the first bytes.
  explicit MeditSections(const InputFile& file);

  /// Moves on to the next keyword and returns its code; kMeditEnd at the end. What is left of the one before is
  /// skipped.
  std::int32_t next_section();
  /// Where the records of the current keyword are read; ends with them.
  const Cursor& cursor() const { return cursor_; }

  std::int32_t read_word() { return cursor_.read<std::int32_t>(swap_); }
  std::int64_t read_integer() { return version_ == 4 ? cursor_.read<std::int64_t>(swap_) : read_word(); }
  double read_real() { return version_ == 1 ? cursor_.read<float>(swap_) : cursor_.read<double>(swap_); }
  /// A count, before its records of so many integers and reals each are reached.
  std::uint64_t read_count() { return static_cast<std::uint64_t>(read_integer()); }
  /// Throws unless `count` records can follow.
  void expect(std::uint64_t count, std::size_t integers, std::size_t reals) const {
    cursor_.expect(count, integers * (version_ == 4 ? 8 : 4) + reals * (version_ == 1 ? 4 : 8));
  }
  int read_dimension();

 private:
  const InputFile& file_;
  Cursor cursor_, after_;
  bool swap_ = false;
  int version_ = 0;
};

/// Whether `path` ends in .solb, not in .sol. Errors: InvalidArgument for any other extension.
bool is_binary_solution(const std::filesystem::path& path);

/// The version of a binary file of `bytes` bytes and numbers up to `largest`, on which the widths of its integers
/// depend.
int medit_version(std::uint64_t bytes, std::uint64_t largest);

}  // namespace tetloom::detail
