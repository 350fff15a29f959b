#pragma once
// Finds the tetrahedron that holds a point.
#include <cstdint>

#include "core/predicates/predicates.hpp"
#include "core/tets/tet_mesh.hpp"

namespace tetloom::tets {

/// A walk through the tets of a mesh towards points, from where the last one ended (Devillers, Pion & Teillaud 2002,
/// "Walking in a triangulation": the visibility walk, whose faces are looked at from another one on after each step).
///
/// Pre: the mesh is Delaunay, which the walk needs to end, and its hull holds all points asked for. Complexity: of the
/// tets between two points; about 5 for neighbours along a space-filling curve. Thread safety: one walk per task.
class Walk {
 public:
  explicit Walk(std::uint32_t start = 0) : last_(start) {}

  /// Starts at `tet` the next time.
  void restart(std::uint32_t tet) { last_ = tet; }

  /// A tet that holds `x`, on its boundary or inside.
  std::uint32_t locate(const TetMesh& mesh, const Vec3& x) {
    const Vec3* points = mesh.points.data();
    std::uint32_t tet = last_, came_through = 4;
    for (;;) {
      const std::uint32_t* v = mesh.to_vert.data() + std::size_t{tet} * 4;
      std::uint32_t leave = 4;
      for (std::uint32_t k = 0; k < 4 && leave == 4; ++k) {
        const std::uint32_t i = (k + turn_) & 3;
        if (i == came_through) continue;
        const auto& f = kFaceVerts[i];
        if (orient3d(points[v[f[0]]], points[v[f[1]]], points[v[f[2]]], x) > 0) leave = i;
      }
      if (leave == 4) return last_ = tet;
      ++turn_;
      const FaceCode next = mesh.behind({tet, leave});
      tet = next.tet(), came_through = next.side();
    }
  }

 private:
  std::uint32_t last_, turn_ = 0;
};

}  // namespace tetloom::tets
