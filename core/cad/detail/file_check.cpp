#include "core/cad/detail/file_check.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

namespace tetloom::cad {
namespace {

constexpr std::size_t kHeadBytes = 4096, kTailBytes = 4096;

[[noreturn]] void unreadable(const std::filesystem::path& path, const std::string& why) {
  throw Error(ErrorCode::InputUnreadable, "'" + path.string() + "' " + why);
}

std::uintmax_t checked_size(const std::filesystem::path& path) {
  std::error_code failure;
  const std::filesystem::file_status status = std::filesystem::status(path, failure);
  if (!std::filesystem::exists(status)) unreadable(path, "does not exist");
  if (std::filesystem::is_directory(status)) unreadable(path, "is a directory");
  const std::uintmax_t size = std::filesystem::file_size(path, failure);
  if (failure) unreadable(path, "cannot be read: " + failure.message());
  if (size == 0) unreadable(path, "is empty");
  return size;
}

std::string read_range(const std::filesystem::path& path, std::uintmax_t from, std::size_t count) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) unreadable(path, "cannot be opened");
  stream.seekg(static_cast<std::streamoff>(from));
  std::string text(count, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(count));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, stream.gcount())));
  return text;
}

void check_step(const std::filesystem::path& path, const std::string& head, const std::string& tail) {
  if (head.find("ISO-10303-21") == std::string::npos) unreadable(path, "is not a STEP file");
  if (tail.find("END-ISO-10303-21") == std::string::npos) unreadable(path, "is cut off: its end is missing");
}

// Lines of 80 columns; column 73 names the section: Start, Global, Directory, Parameters, Terminate.
void check_iges(const std::filesystem::path& path, const std::string& head, const std::string& tail) {
  const std::size_t line = head.find_first_of("\r\n");
  if (line == std::string::npos || line < 73 || line > 82 ||
      std::string_view("SFCB").find(head[72]) == std::string_view::npos)
    unreadable(path, "is not an IGES file");
  const std::size_t end = tail.find_last_not_of(" \r\n\t");
  const std::size_t start = end == std::string::npos ? 0 : tail.find_last_of("\r\n", end) + 1;
  if (end == std::string::npos || end < start + 72 || tail[start + 72] != 'T')
    unreadable(path, "is cut off: its end is missing");
}

/// The words of a text, one by one.
class Words {
 public:
  explicit Words(std::string_view text) : text_(text) {}
  bool next(std::string_view& word) {
    const std::size_t begin = text_.find_first_not_of(" \t\r\n", at_);
    if (begin == std::string_view::npos) return false;
    at_ = std::min(text_.find_first_of(" \t\r\n", begin), text_.size());
    word = text_.substr(begin, at_ - begin);
    return true;
  }

 private:
  std::string_view text_;
  std::size_t at_ = 0;
};

// The reader indexes tables with what stands in the file, unchecked. So the list of shapes must be whole: as many
// records as announced, each ended by a star, then the reference to the model's own shape.
void check_brep(const std::filesystem::path& path, const std::string& text) {
  if (text.find("CASCADE Topology V") > kHeadBytes) unreadable(path, "is not a BREP file");
  const std::size_t begin = text.rfind("TShapes ");
  if (begin == std::string::npos) unreadable(path, "is cut off: its list of shapes is missing");
  Words words(std::string_view(text).substr(begin));
  std::string_view word;
  words.next(word);
  if (!words.next(word)) unreadable(path, "is cut off");
  const unsigned long long announced = std::strtoull(std::string(word).c_str(), nullptr, 10);
  unsigned long long records = 0;
  int after_last = 0;
  while (words.next(word)) {
    ++after_last;
    if (word == "*") ++records, after_last = 0;
  }
  if (announced == 0) throw Error(ErrorCode::InputUnsuitable, "'" + path.string() + "' holds no shape");
  if (records != announced || after_last < 2) unreadable(path, "is cut off: its list of shapes is not whole");
}

}  // namespace

void check_content(const std::filesystem::path& path, CadFormat format) {
  const std::uintmax_t size = checked_size(path);
  if (format == CadFormat::Brep) {
    check_brep(path, read_range(path, 0, static_cast<std::size_t>(size)));
    return;
  }
  const std::string head = read_range(path, 0, kHeadBytes);
  const std::string tail = read_range(path, size > kTailBytes ? size - kTailBytes : 0, kTailBytes);
  if (format == CadFormat::Step)
    check_step(path, head, tail);
  else
    check_iges(path, head, tail);
}

}  // namespace tetloom::cad
