#include "core/cad/detail/iges_check.hpp"

#include <algorithm>
#include <charconv>
#include <string_view>
#include <vector>

namespace tetloom::cad {
namespace {

constexpr std::size_t kSectionColumn = 72, kDataColumns = 64;  // 0-based; of lines of 80 columns
constexpr long kHighestDegree = 25, kMostPoles = 100000000;

/// The fields of one record, up to its end.
std::vector<std::string_view> split(std::string_view record) {
  std::vector<std::string_view> fields;
  while (!record.empty()) {
    const std::size_t end = record.find_first_of(",;");
    fields.push_back(record.substr(0, end));
    if (end == std::string_view::npos || record[end] == ';') break;
    record.remove_prefix(end + 1);
  }
  return fields;
}

/// A whole number, 0 for an empty field, -1 for anything else.
long number(std::string_view field) {
  while (!field.empty() && field.front() == ' ') field.remove_prefix(1);
  while (!field.empty() && field.back() == ' ') field.remove_suffix(1);
  if (field.empty()) return 0;
  if (field.front() == '+') field.remove_prefix(1);
  long value = 0;
  const auto [end, failure] = std::from_chars(field.data(), field.data() + field.size(), value);
  return failure == std::errc() && end == field.data() + field.size() ? value : -1;
}

bool is_direction_sound(long last_pole, long degree) {
  return degree >= 1 && degree <= kHighestDegree && last_pole >= degree && last_pole <= kMostPoles;
}

bool is_curve_sound(const std::vector<std::string_view>& fields) {
  if (fields.size() < 7) return false;
  const long last = number(fields[1]), degree = number(fields[2]);
  if (!is_direction_sound(last, degree)) return false;
  return static_cast<long>(fields.size()) >= 7 + (last + degree + 2) + 4 * (last + 1) + 2;
}

bool is_surface_sound(const std::vector<std::string_view>& fields) {
  if (fields.size() < 10) return false;
  const long u_last = number(fields[1]), v_last = number(fields[2]);
  const long u_degree = number(fields[3]), v_degree = number(fields[4]);
  if (!is_direction_sound(u_last, u_degree) || !is_direction_sound(v_last, v_degree)) return false;
  if ((u_last + 1) > kMostPoles / (v_last + 1)) return false;
  const long knots = (u_last + u_degree + 2) + (v_last + v_degree + 2), poles = (u_last + 1) * (v_last + 1);
  return static_cast<long>(fields.size()) >= 10 + knots + 4 * poles + 4;
}

bool is_record_sound(const std::string& record) {
  const std::vector<std::string_view> fields = split(record);
  if (fields.empty()) return true;
  const long type = number(fields[0]);
  return type == 126 ? is_curve_sound(fields) : type == 128 ? is_surface_sound(fields) : true;
}

/// Do fields end with commas and records with semicolons? Other signs are allowed, and rare.
bool has_usual_signs(std::string_view global) { return global.starts_with(",,") || global.starts_with("1H,,1H;"); }

}  // namespace

std::string find_iges_damage(const std::string& text) {
  std::string record, owner;
  bool first_global = true;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    const std::string_view line = std::string_view(text).substr(at, end - at);
    at = end + 1;
    if (line.size() <= kSectionColumn) continue;
    const char section = line[kSectionColumn];
    if (section == 'G' && first_global) {
      first_global = false;
      if (!has_usual_signs(line)) return "";
    }
    if (section != 'P') continue;
    const std::string_view pointer = line.substr(kDataColumns, kSectionColumn - kDataColumns);
    if (pointer != owner) {
      if (!is_record_sound(record)) return "the spline of directory entry" + owner + " is not whole";
      record.clear();
      owner = pointer;
    }
    record += line.substr(0, kDataColumns);
  }
  return is_record_sound(record) ? "" : "the spline of directory entry" + owner + " is not whole";
}

}  // namespace tetloom::cad
