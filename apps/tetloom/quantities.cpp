#include "apps/tetloom/quantities.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace tetloom::app {
namespace {

template <class... Values>
std::string printed(const char* format, Values... values) {
  std::array<char, 64> text{};
  const int length = std::snprintf(text.data(), text.size(), format, values...);
  return {text.data(), std::min<std::size_t>(text.size() - 1, static_cast<std::size_t>(std::max(0, length)))};
}

/// The factor of a suffix such as "", "k", "MB" or "GiB".
std::optional<double> byte_factor(std::string_view suffix) {
  if (suffix.empty() || suffix == "B" || suffix == "b") return 1.0;
  static constexpr std::string_view letters = "KMGT";
  const std::size_t power = letters.find(static_cast<char>(std::toupper(static_cast<unsigned char>(suffix[0]))));
  if (power == std::string_view::npos) return std::nullopt;
  const std::string_view rest = suffix.substr(1);
  if (!rest.empty() && rest != "B" && rest != "b" && rest != "iB") return std::nullopt;
  return std::ldexp(1.0, 10 * static_cast<int>(power + 1));
}

}  // namespace

std::optional<std::uint64_t> parse_bytes(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value) || value <= 0) return std::nullopt;
  std::string_view suffix(end, static_cast<std::size_t>(text.data() + text.size() - end));
  if (!suffix.empty() && suffix[0] == ' ') suffix.remove_prefix(1);
  const std::optional<double> factor = byte_factor(suffix);
  if (!factor || value * *factor < 1 || value * *factor >= 18446744073709551616.0) return std::nullopt;
  return static_cast<std::uint64_t>(value * *factor);
}

std::string format_bytes(double bytes) {
  static constexpr std::array<const char*, 5> units{"B", "KiB", "MiB", "GiB", "TiB"};
  std::size_t unit = 0;
  while (bytes >= 1000 && unit + 1 < units.size()) bytes /= 1024, ++unit;
  return printed(bytes < 10 && unit > 0 ? "%.1f %s" : "%.0f %s", bytes, units[unit]);
}

std::string format_count(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t place = digits.size(); place > 3; place -= 3) digits.insert(place - 3, ",");
  return digits;
}

std::string format_short(double value) {
  static constexpr std::array<const char*, 5> units{"", "k", "M", "G", "T"};
  std::size_t unit = 0;
  while (value >= 999.5 && unit + 1 < units.size()) value /= 1000, ++unit;
  if (unit == 0 && value == std::floor(value)) return printed("%.0f", value);
  return printed(value < 9.995 ? "%.2f%s" : value < 99.95 ? "%.1f%s" : "%.0f%s", value, units[unit]);
}

std::string format_seconds(double seconds) {
  if (seconds < 9.995) return printed("%.2f s", seconds);
  if (seconds < 59.95) return printed("%.1f s", seconds);
  const auto whole = static_cast<long>(std::min(seconds, 1e9) + 0.5);
  if (whole < 3600) return printed("%ld min %ld s", whole / 60, whole % 60);
  return printed("%ld h %ld min", whole / 3600, whole % 3600 / 60);
}

std::string format_number(double value) { return printed("%.6g", value); }

std::string format_share(double share) {
  const double percent = 100 * share;
  const double to_end = std::min(percent, 100 - percent);
  if (to_end == 0 || to_end >= 0.05) return printed("%.1f %%", percent);
  return printed(to_end >= 0.0005 ? "%.3f %%" : "%.6f %%", percent);
}

}  // namespace tetloom::app
