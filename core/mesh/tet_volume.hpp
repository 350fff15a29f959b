#pragma once
// The signed volume of a tet.
#include "tetloom/vec.hpp"

namespace tetloom {

inline double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a) / 6;
}

}  // namespace tetloom
