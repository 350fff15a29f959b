#include "mesher/tets/dihedral.hpp"

#include <algorithm>
#include <cmath>

namespace tetloom::tets {

namespace {

constexpr double kRegularAngle = 1.2309594173407747;  // arccos(1/3)
constexpr double kPoorTriangle = 0.5;
constexpr double kShortEdge = 1.0 / 3;

Vec3 face_normal(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face) {
  const auto& [i, j, k] = kFaceVerts[face];
  const Vec3& a = mesh.point_of(tet, i);
  return normalized(cross(mesh.point_of(tet, j) - a, mesh.point_of(tet, k) - a));
}

// 1 for an equilateral triangle, 0 for a degenerate one.
double triangle_quality(const TetMesh& mesh, std::uint32_t tet, std::uint32_t face) {
  const auto& [i, j, k] = kFaceVerts[face];
  const Vec3 p = mesh.point_of(tet, j) - mesh.point_of(tet, i), q = mesh.point_of(tet, k) - mesh.point_of(tet, i);
  const double squares = norm2(p) + norm2(q) + norm2(q - p);
  return squares > 0 ? 2 * std::sqrt(3.0) * norm(cross(p, q)) / squares : 0;
}

bool has_short_surface_edge(const WorkingMesh& mesh, std::uint32_t tet) {
  const auto verts = mesh.verts(tet);
  double shortest = HUGE_VAL, longest = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t j = i + 1; j < 4; ++j) {
      const double length = distance(mesh.point(verts[i]), mesh.point(verts[j]));
      longest = std::max(longest, length);
      if (mesh.is_fixed_point(verts[i]) && mesh.is_fixed_point(verts[j])) shortest = std::min(shortest, length);
    }
  }
  return shortest < kShortEdge * longest;
}

}  // namespace

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

bool is_forced(const WorkingMesh& mesh, std::uint32_t tet, const Dihedral& dihedral) {
  const TetMesh& m = mesh.mesh();
  if (m.is_fixed(tet * 4 + dihedral.face) && m.is_fixed(tet * 4 + dihedral.other)) return true;
  for (std::uint32_t face = 0; face < 4; ++face) {
    if (m.is_fixed(tet * 4 + face) && triangle_quality(m, tet, face) < kPoorTriangle) return true;
  }
  return has_short_surface_edge(mesh, tet);
}

DihedralSummary summarize_dihedrals(WorkingMesh& mesh, double least_wanted) {
  DihedralSummary summary{kRegularAngle, 0, 0};
  const auto bound_of = [&] { return largest_quality_with_dihedral(std::max(summary.least, least_wanted)) * kGain; };
  double bound = bound_of();
  for (std::uint32_t tet = 0; tet < mesh.qualities().size(); ++tet) {
    if (mesh.quality(tet) > bound || mesh.mesh().is_dead(tet)) continue;
    const Dihedral dihedral = smallest_dihedral(mesh.mesh(), tet);
    if (dihedral.angle < summary.least) summary.least = dihedral.angle, bound = bound_of();
    if (dihedral.angle >= least_wanted) continue;
    ++summary.below;
    summary.forced += is_forced(mesh, tet, dihedral);
  }
  return summary;
}

}  // namespace tetloom::tets
