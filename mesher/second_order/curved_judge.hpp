#pragma once
// Tets that a mesh of second order does not have yet: would they be valid?
#include <array>
#include <cstdint>
#include <span>

#include "core/mesh/curved_tet.hpp"
#include "core/tets/tet_mesh.hpp"

namespace tetloom::second_order {

/// Judges tets between the points of a patch of a mesh. Edges on the surface have the mid nodes of the mesh, all others
/// are straight. What it is made of outlives the object; `tets` may change.
class CurvedJudge {
 public:
  using Verts = std::array<std::uint32_t, 4>;

  /// Points of `tets` below to_vert.size() are the vertices `to_vert` of `mesh`, the others are new. Tets are good
  /// where their Jacobian is proven to be at least `least` times that of the straight tet.
  CurvedJudge(const Mesh& mesh, const MidNodes& mids, double least, std::span<const std::uint32_t> to_vert,
              const tets::TetMesh& tets)
      : mesh_(mesh), mids_(mids), first_mid_(vertex_count(mesh)), least_(least), to_vert_(to_vert), tets_(tets) {}

  TetNodes nodes_of(const Verts& verts) const {
    TetNodes nodes;
    for (std::size_t i = 0; i < 4; ++i) nodes[i] = tets_.points[verts[i]];
    const CellShape& shape = shape_of(CellKind::Tet);
    for (std::size_t e = 0; e < 6; ++e) nodes[4 + e] = mid_node(verts[shape.edge[e][0]], verts[shape.edge[e][1]]);
    return nodes;
  }

  bool is_good(const Verts& verts) const { return least_jacobian(tet_jacobian(nodes_of(verts)), least_) >= least_; }

 private:
  Vec3 mid_node(std::uint32_t a, std::uint32_t b) const {
    if (std::max(a, b) < to_vert_.size()) {
      const std::uint32_t mid = mids_.find(to_vert_[a], to_vert_[b]);
      if (mid != kNone && mesh_.point_to_entity[first_mid_ + mid].dim < 3) return mesh_.points[first_mid_ + mid];
    }
    return 0.5 * (tets_.points[a] + tets_.points[b]);
  }

  const Mesh& mesh_;
  const MidNodes& mids_;
  std::size_t first_mid_;
  double least_;
  std::span<const std::uint32_t> to_vert_;
  const tets::TetMesh& tets_;
};

}  // namespace tetloom::second_order
