#pragma once
// The tets at a vertex, as functions of where the vertex lies.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>

#include "mesher/tets/working_mesh.hpp"

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

/// The tets at one vertex, without allocation.
struct VertexStar {
  std::uint32_t vertex = kNone;
  std::size_t count = 0;
  std::array<FaceCode, WorkingMesh::kMostTets + 3> codes;  ///< tet * 4 + the vertex's corner in it

  std::span<const FaceCode> tets() const { return {codes.data(), count}; }
};

enum class StarVerdict {
  Found,
  OnSurface,  ///< the vertex is one of the given surface, or on a face that has to stay
  TooLarge    ///< more than WorkingMesh::kMostTets tets
};

/// Collects the tets at corner `corner` of `tet`, in an order that depends on the mesh alone.
StarVerdict find_star(const WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, VertexStar& star);

}  // namespace tetloom::tets
