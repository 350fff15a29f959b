#include "core/tets/dihedral.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetloom::tets {

namespace {

// Cosines count as a little larger than they are computed to be.
constexpr double kRoundOff = 1e-12;

// Twice the face's area long.
Vec3 area_of(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face) {
  const auto& [i, j, k] = kFaceVerts[face];
  const Vec3& a = mesh.point_of(tet, i);
  return cross(mesh.point_of(tet, j) - a, mesh.point_of(tet, k) - a);
}

Vec3 face_normal(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face) {
  return normalized(area_of(mesh, tet, face));
}

}  // namespace

double dihedral_between(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face, std::uint32_t other) {
  return std::acos(std::clamp(-dot(face_normal(mesh, tet, face), face_normal(mesh, tet, other)), -1.0, 1.0));
}

Dihedral smallest_dihedral(const TetMesh& mesh, std::uint32_t tet) {
  std::array<Vec3, 4> normals;
  for (std::uint32_t i = 0; i < 4; ++i) normals[i] = face_normal(mesh, tet, i);
  Dihedral result;
  double largest_cosine = -2;
  for (std::uint32_t i = 0; i < 4; ++i) {
    for (std::uint32_t j = i + 1; j < 4; ++j) {
      const double cosine = -dot(normals[i], normals[j]);
      if (cosine > largest_cosine) largest_cosine = cosine, result = {0, i, j};
    }
  }
  result.angle = std::acos(std::clamp(largest_cosine, -1.0, 1.0));
  return result;
}

double cosine_of_smallest_dihedral(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 p = b - a, q = c - a, r = d - a;
  const std::array normals{normalized(cross(q - p, r - p)), normalized(cross(r, q)), normalized(cross(p, r)),
                           normalized(cross(q, p))};
  double largest = -1;
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = i + 1; j < 4; ++j) largest = std::max(largest, -dot(normals[i], normals[j]));
  return largest;
}

bool may_be_below(const TetMesh& mesh, std::uint32_t tet, double cosine) {
  std::array<Vec3, 4> areas;
  std::array<double, 4> lengths;
  for (std::uint32_t i = 0; i < 4; ++i) {
    areas[i] = area_of(mesh, tet, i);
    lengths[i] = norm(areas[i]);
  }
  bool may_be = false;
  for (std::uint32_t i = 0; i < 4; ++i)
    for (std::uint32_t j = i + 1; j < 4; ++j)
      may_be |= -dot(areas[i], areas[j]) > (cosine - kRoundOff) * lengths[i] * lengths[j];
  return may_be;
}

double largest_quality_with_dihedral(double angle) {
  const double sine = std::sin(angle);
  return 2 * sine * sine;
}

}  // namespace tetloom::tets
