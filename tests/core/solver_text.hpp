#pragma once
// What tests of solvers' files share: a mesh with names, and numbers out of text.
#include <sstream>
#include <string>
#include <vector>

#include "tests/core/mesh_fixtures.hpp"
#include "tests/core/mesh_io_support.hpp"

namespace tetloom::test {

/// A box of two regions, with names.
inline Mesh named_box() {
  Mesh mesh = make_box(4, 3, 2, true);
  decorate(mesh);
  return mesh;
}

/// The numbers in a text, whatever stands between them.
inline std::vector<double> numbers_in(std::string text) {
  for (char& c : text)
    if (c == ',' || c == '(' || c == ')' || c == '\n') c = ' ';
  std::istringstream stream(text);
  std::vector<double> numbers;
  for (double number = 0; stream >> number;) numbers.push_back(number);
  return numbers;
}

/// Of the pyramid from `origin` over a polygon.
inline double signed_volume(const std::vector<Vec3>& polygon, const Vec3& origin) {
  double six = 0;
  for (std::size_t i = 2; i < polygon.size(); ++i)
    six += dot(polygon[0] - origin, cross(polygon[i - 1] - origin, polygon[i] - origin));
  return six / 6;
}

}  // namespace tetloom::test
