#pragma once
// A tet at a vertex, as a function of where the vertex lies.
#include <algorithm>

#include "core/tets/tet_quality.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// One tet at a vertex that is at `d`, measured from where it was. With the face opposite to it, (a, b, c) measured
/// from there too, six times its volume is volume + dot(normal, d), its sum of squared edges squares - 2 dot(middle, d)
/// + 3 |d|^2.
struct StarTet {
  Vec3 normal, middle;
  double volume, squares;

  double volume_at(const Vec3& d) const { return volume + dot(normal, d); }
  double squares_at(const Vec3& d) const { return squares - 2 * dot(middle, d) + 3 * norm2(d); }
  /// Whether orient3d > 0 is certain at `d`; see tet_quality.hpp.
  bool is_surely_positive_at(const Vec3& d) const {
    const double v = volume_at(d), s = std::max(squares, squares_at(d));
    return v > 0 && 432 * v * v > kSurelyPositive * cube(s);
  }
};

/// a, b, c: counter-clockwise seen from the vertex, measured from it.
inline StarTet star_tet(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = b - a, q = c - a;
  StarTet tet;
  tet.normal = cross(p, q);
  tet.middle = a + b + c;
  tet.volume = -dot(tet.normal, a);
  tet.squares = norm2(p) + norm2(q) + norm2(c - b) + norm2(a) + norm2(b) + norm2(c);
  return tet;
}

}  // namespace tetloom::tets
