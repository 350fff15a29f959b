#include "mesher/tets/dihedral.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetloom::tets {

namespace {

Vec3 face_normal(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face) {
  const auto& [i, j, k] = kFaceVerts[face];
  const Vec3& a = mesh.point_of(tet, i);
  return normalized(cross(mesh.point_of(tet, j) - a, mesh.point_of(tet, k) - a));
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

double largest_quality_with_dihedral(double angle) {
  const double sine = std::sin(angle);
  return 2 * sine * sine;
}

}  // namespace tetloom::tets
