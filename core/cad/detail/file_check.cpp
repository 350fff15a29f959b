#include "core/cad/detail/file_check.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/cad/detail/brep_check.hpp"
#include "core/cad/detail/iges_check.hpp"
#include "core/cad/detail/step_check.hpp"

namespace tetloom::cad {
namespace {

constexpr std::size_t kHeadBytes = 4096, kTailBytes = 4096;

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

void check_step_names(const std::filesystem::path& path, const std::string& text) {
  if (const std::string damage = find_step_damage(text); !damage.empty()) unreadable(path, "is damaged: " + damage);
}

void check_iges_splines(const std::filesystem::path& path, const std::string& text) {
  if (const std::string damage = find_iges_damage(text); !damage.empty()) unreadable(path, "is damaged: " + damage);
}

void check_brep(const std::filesystem::path& path, const std::string& text) {
  if (text.find("CASCADE Topology V") > kHeadBytes) unreadable(path, "is not a BREP file");
  std::size_t shape_count = 0;
  if (const std::string damage = find_brep_damage(text, shape_count); !damage.empty())
    unreadable(path, "is damaged or cut off: " + damage);
  if (shape_count == 0) throw Error(ErrorCode::InputUnsuitable, "'" + path.string() + "' holds no shape");
}

}  // namespace

void unreadable(const std::filesystem::path& path, const std::string& why) {
  throw Error(ErrorCode::InputUnreadable, "'" + path.string() + "' " + why);
}

void check_content(const std::filesystem::path& path, CadFormat format) {
  const std::uintmax_t size = checked_size(path);
  if (format == CadFormat::Brep) {
    check_brep(path, read_range(path, 0, static_cast<std::size_t>(size)));
    return;
  }
  const std::string head = read_range(path, 0, kHeadBytes);
  const std::string tail = read_range(path, size > kTailBytes ? size - kTailBytes : 0, kTailBytes);
  if (format == CadFormat::Step) {
    check_step(path, head, tail);
    check_step_names(path, read_range(path, 0, static_cast<std::size_t>(size)));
  } else {
    check_iges(path, head, tail);
    check_iges_splines(path, read_range(path, 0, static_cast<std::size_t>(size)));
  }
}

}  // namespace tetloom::cad
