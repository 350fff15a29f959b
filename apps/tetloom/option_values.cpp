#include "apps/tetloom/option_values.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

#include "apps/tetloom/quantities.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::app {

void require(bool condition, const std::string& message) {
  if (!condition) throw UsageError(message);
}

double positive(const char* option, std::optional<double> value, double otherwise) {
  if (!value) return otherwise;
  require(std::isfinite(*value) && *value > 0,
          std::string(option) + " must be a positive number, not " + format_number(*value));
  return *value;
}

double not_negative(const char* option, std::optional<double> value, double otherwise) {
  if (!value) return otherwise;
  require(std::isfinite(*value) && *value >= 0,
          std::string(option) + " must be 0 (off) or a positive number, not " + format_number(*value));
  return *value;
}

int count_between(const char* option, std::optional<int> value, int most) {
  if (!value) return 0;
  require(*value >= 1 && *value <= most, std::string(option) + " must lie between 1 and " + std::to_string(most) +
                                             ", not be " + std::to_string(*value));
  return *value;
}

std::vector<std::string> items_of(const std::string& list) {
  std::vector<std::string> items;
  for (std::size_t begin = 0; begin <= list.size();) {
    const std::size_t end = std::min(list.find(',', begin), list.size());
    items.push_back(list.substr(begin, end - begin));
    begin = end + 1;
  }
  return items;
}

std::optional<std::uint32_t> tag_of(std::string_view text) {
  std::uint32_t tag = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), tag);
  const bool is_tag = error == std::errc() && end == text.data() + text.size() && tag > 0 && tag < kNone;
  return is_tag ? std::optional(tag) : std::nullopt;
}

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

bool same_file(const std::filesystem::path& a, const std::filesystem::path& b) {
  if (a.empty() || b.empty()) return false;
  std::error_code error;
  if (std::filesystem::equivalent(a, b, error)) return true;
  return std::filesystem::absolute(a).lexically_normal() == std::filesystem::absolute(b).lexically_normal();
}

bool would_replace(const std::filesystem::path& output, const std::filesystem::path& path) {
  if (same_file(output, path)) return true;
  return !path.empty() && is_piece_list(output) && same_file(path.parent_path(), output.parent_path() / output.stem());
}

bool is_in_parts(const std::filesystem::path& output, std::optional<int> parts) {
  if (!parts && !is_piece_list(output)) return false;
  require(is_writable_parts_format(output),
          "--parts goes with .pvtu, .msh and .foam, which hold parts, not with '" + output.string() + "'");
  return true;
}

}  // namespace tetloom::app
