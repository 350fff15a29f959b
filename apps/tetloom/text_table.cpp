#include "apps/tetloom/text_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "apps/tetloom/quantities.hpp"

namespace tetloom::app {
namespace {

/// Columns that a text takes on a terminal, taking UTF-8 sequences as one each.
std::size_t columns(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xc0) != 0x80; }));
}

int srgb_byte(float linear) {
  const double value = std::clamp(static_cast<double>(linear), 0.0, 1.0);
  const double encoded = value <= 0.0031308 ? 12.92 * value : 1.055 * std::pow(value, 1 / 2.4) - 0.055;
  return static_cast<int>(std::lround(255 * encoded));
}

std::string render_row(const std::vector<std::string>& cells, const std::vector<std::size_t>& widths) {
  std::string line = "   ";
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (widths[i] > 0) line += " " + cells[i] + std::string(widths[i] - columns(cells[i]) + 1, ' ');
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

std::string render_table(const std::vector<std::string>& headings, const std::vector<std::vector<std::string>>& rows,
                         std::size_t most_rows) {
  const std::size_t shown = std::min(rows.size(), most_rows);
  std::vector<std::size_t> widths(headings.size(), 0);
  for (std::size_t r = 0; r < shown; ++r) {
    for (std::size_t i = 0; i < headings.size(); ++i) widths[i] = std::max(widths[i], columns(rows[r][i]));
  }
  for (std::size_t i = 0; i < headings.size(); ++i) {
    if (widths[i] > 0) widths[i] = std::max(widths[i], columns(headings[i]));
  }
  std::string text = render_row(headings, widths);
  for (std::size_t r = 0; r < shown; ++r) text += render_row(rows[r], widths);
  if (shown < rows.size()) text += "    … and " + format_count(rows.size() - shown) + " more\n";
  return text;
}

std::string format_color(const std::optional<Color>& color) {
  if (!color) return {};
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "#%02x%02x%02x", srgb_byte(color->red), srgb_byte(color->green),
                srgb_byte(color->blue));
  return text.data();
}

std::string format_box(const Box3& box) {
  if (box.empty()) return "empty";
  // What is zero but for rounding is shown as zero.
  const double noise = 1e-12 * box.diagonal();
  const auto number = [noise](double value) { return format_number(std::abs(value) < noise ? 0 : value); };
  const auto point = [&](const Vec3& p) { return "(" + number(p.x) + ", " + number(p.y) + ", " + number(p.z) + ")"; };
  return point(box.lo) + " to " + point(box.hi) + ", diagonal " + format_number(box.diagonal());
}

}  // namespace tetloom::app
