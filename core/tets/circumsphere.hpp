#pragma once
// The sphere through the vertices of a tetrahedron, without a division.
#include "tetloom/vec.hpp"

namespace tetloom::tets {

/// Pre: positive volume. In rounded arithmetic: not for decisions on which validity depends.
struct Circumsphere {
  Vec3 corner;        ///< a vertex
  double volume;      ///< six times the tet's
  Vec3 twice_moment;  ///< twice the centre, measured from the corner, times `volume`

  Circumsphere(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) : corner(a) {
    const Vec3 p = b - a, q = c - a, r = d - a, qr = cross(q, r);
    volume = dot(p, qr);
    twice_moment = norm2(p) * qr + norm2(q) * cross(r, p) + norm2(r) * cross(p, q);
  }

  /// The centre, measured from the corner; not finite for some flat tets.
  Vec3 center_from_corner() const { return twice_moment / (2 * volume); }

  /// Whether `x` lies inside, by more than `margin` of its squared distance from the corner.
  bool holds(const Vec3& x, double margin) const {
    const Vec3 from = x - corner;
    return (1 + margin) * norm2(from) * volume < dot(from, twice_moment);
  }
};

}  // namespace tetloom::tets
