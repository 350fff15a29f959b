#include "core/cad/detail/step_check.hpp"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <vector>

namespace tetloom::cad {
namespace {

constexpr std::string_view kBlank = " \t\r\n";

/// The end of the string or comment that starts at `at`; `at` where none starts there.
std::size_t skip_opaque(std::string_view text, std::size_t at) {
  std::size_t end = at;
  if (text[at] == '\'') {
    end = text.find('\'', at + 1) + 1;
  } else if (text.substr(at, 2) == "/*") {
    end = text.find("*/", at + 2) + 2;
  } else {
    return at;
  }
  return end <= at ? text.size() : end;
}

/// The end of the statement that starts at `at`, behind its semicolon.
std::size_t skip_statement(std::string_view text, std::size_t at) {
  while (at < text.size() && text[at] != ';') {
    at = text.find_first_of(";'/", at);
    if (at >= text.size() || text[at] == ';') break;
    const std::size_t end = skip_opaque(text, at);
    at = end == at ? at + 1 : end;
  }
  return at >= text.size() ? text.size() : at + 1;
}

/// The names that instances are given, in the order of the file.
std::vector<std::uint64_t> instance_names(std::string_view text) {
  std::vector<std::uint64_t> names;
  for (std::size_t at = 0; at < text.size();) {
    at = text.find_first_not_of(kBlank, at);
    if (at >= text.size()) break;
    if (const std::size_t end = skip_opaque(text, at); end != at) {
      at = end;
      continue;
    }
    std::uint64_t name = 0;
    if (text[at] == '#' && std::from_chars(text.data() + at + 1, text.data() + text.size(), name).ec == std::errc{})
      names.push_back(name);
    at = skip_statement(text, at);
  }
  return names;
}

}  // namespace

std::string find_step_damage(std::string_view text) {
  std::vector<std::uint64_t> names = instance_names(text);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  return twice == names.end() ? std::string() : "two entities are #" + std::to_string(*twice);
}

}  // namespace tetloom::cad
