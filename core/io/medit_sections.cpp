#include <cctype>
#include <limits>
#include <string>

#include "core/io/medit_detail.hpp"

namespace tetloom::detail {

MeditWords::MeditWords(const InputFile& file) : Cursor(file, file.bytes()) {
  const std::string_view first = Cursor(*this).token();
  if (first != "MeshVersionFormatted" && !first.starts_with('#'))
    file.fail(ErrorCode::InputUnreadable, "no MEDIT file: it does not start with MeshVersionFormatted");
}

std::string_view MeditWords::next_keyword() {
  for (;;) {
    const std::string_view word = token();
    if (word.empty()) file().fail_at_line("the file ends without the keyword End", at());
    if (word.front() == '#') {
      if (at() > word.data()) jump(word.data());
      line();
      continue;
    }
    const bool is_number = word.starts_with("nan") || word.starts_with("inf");
    if (std::isalpha(static_cast<unsigned char>(word.front())) != 0 && !is_number) return word;
  }
}

std::uint64_t MeditWords::read_count(std::size_t bytes_each) {
  const auto count = parse<std::uint64_t>();
  // The last number may end at the end of the file, without a separator.
  if (count > left() / bytes_each + 1)
    file().fail_at_line("a count of " + std::to_string(count) + " exceeds the file", at());
  return count;
}

int MeditWords::read_dimension() {
  const int dimension = parse<int>();
  if (dimension != 2 && dimension != 3) file().fail_at_line("the dimension must be 2 or 3", at());
  return dimension;
}

MeditSections::MeditSections(const InputFile& file) : file_(file), cursor_(file, file.bytes()), after_(cursor_) {
  const auto code = cursor_.read<std::uint32_t>();
  swap_ = code == 0x01000000;
  if (code != 1 && !swap_) file_.fail(ErrorCode::InputUnreadable, "no binary MEDIT file by its first bytes");
  version_ = read_word();
  if (version_ < 1 || version_ > 4) file_.fail("version " + std::to_string(version_) + " is unknown", cursor_.at());
  after_ = cursor_;
}

std::int32_t MeditSections::next_section() {
  cursor_ = after_;
  const std::int32_t code = read_word();
  if (code == kMeditEnd) return code;
  const std::uint64_t next = version_ >= 3 ? cursor_.read<std::uint64_t>(swap_) : cursor_.read<std::uint32_t>(swap_);
  const auto here = static_cast<std::uint64_t>(cursor_.at() - file_.bytes().data());
  if (next <= here || next > file_.bytes().size())
    file_.fail("the place of the next keyword is outside of the file", cursor_.at());
  after_ = Cursor(file_, file_.bytes().substr(next));
  cursor_ = Cursor(file_, file_.bytes().substr(here, next - here));
  return code;
}

int MeditSections::read_dimension() {
  const std::int32_t dimension = read_word();
  if (dimension != 2 && dimension != 3) file_.fail("the dimension must be 2 or 3", cursor_.at());
  return dimension;
}

int medit_version(std::uint64_t bytes, std::uint64_t largest) {
  constexpr std::uint64_t kLargest32 = std::numeric_limits<std::int32_t>::max();
  return largest > kLargest32 ? 4 : bytes > kLargest32 ? 3 : 2;
}

}  // namespace tetloom::detail
