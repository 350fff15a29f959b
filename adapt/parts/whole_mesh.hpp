#pragma once
// The mesh between two rounds of adaptation: dealt to parts anew for each round, and put together from them afterwards.
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "adapt/kernel/cavity_mesh.hpp"
#include "core/base/growing_array.hpp"
#include "core/mesh/mesh.hpp"
#include "threading/task_runner.hpp"

namespace tetloom::adapt {

/// A triangle of the surface and the tets that have it; the second one is kNone where nothing lies on that side.
struct LinkedTriangle {
  SurfaceTriangle triangle;
  std::array<std::uint32_t, 2> tets{kNone, kNone};
};

struct ModelEdgePiece {
  std::array<std::uint32_t, 2> verts;  ///< ascending
  std::uint32_t edge = kNone;          ///< model edge
  friend auto operator<=>(const ModelEdgePiece&, const ModelEdgePiece&) = default;
};

/// Struct of arrays. Invariant: `to_neighbor` as in tets::TetMesh; kNone behind triangles of the outer surface alone.
struct WholeMesh {
  GrowingArray<Vec3> points;
  GrowingArray<VertexMetric> to_metric;
  GrowingArray<PackedEntity> to_entity;
  GrowingArray<std::uint32_t> to_hint;
  GrowingArray<std::uint8_t> to_state;  ///< as in CavityMesh, for the next round
  GrowingArray<std::uint32_t> to_vert;  ///< 4 per tet
  GrowingArray<FaceCode> to_neighbor;   ///< 4 per tet
  GrowingArray<std::uint32_t> to_region;
  std::vector<LinkedTriangle> triangles;
  std::vector<ModelEdgePiece> edges;

  std::size_t size() const { return to_region.size(); }
};

/// From the tets, triangles and edges of `mesh`. Where it names no entities, faces of the hull without a triangle get
/// one without an entity, and edges between triangles of different entities, or of other than two, become pieces of
/// model edges that are named after them. Metrics are left at zero.
/// Errors: InputUnsuitable with place and element: cells that are no tets, tets without volume, faces of three tets,
/// triangles that no tet has, tets of two regions that meet without a triangle.
WholeMesh make_whole_mesh(const Mesh& mesh, const TaskRunner& runner);

/// The mesh as it is now, with the names, sides and entities of `source`; without fields.
Mesh make_mesh_of(const WholeMesh& whole, const Mesh& source);

/// The part of every tet, below `part_count`: equal shares of the work along a Hilbert curve. The curve differs from
/// round to round, and so do the sides of parts. `to_work`: positive, one per tet.
std::vector<std::uint32_t> deal_tets(const WholeMesh& whole, std::span<const float> to_work, std::size_t part_count,
                                     std::size_t round, const TaskRunner& runner);

/// One part of the mesh, to be changed but for what it shares with others.
struct PartOfWhole {
  CavityMesh mesh;
  std::uint32_t given = 0;              ///< its vertices before this one are those of `to_whole`
  std::vector<std::uint32_t> to_whole;  ///< vertex of the whole mesh
  double work = 0;
};

/// Cuts, calls `adapt` for every part, the one of most work first, and puts together what has become of them. The
/// result depends on the parts alone. Strong guarantee: when `adapt` throws, `whole` is as it was.
void adapt_in_parts(WholeMesh& whole, std::span<const std::uint32_t> to_part, std::span<const float> to_work,
                    std::size_t part_count, const std::function<void(std::size_t, CavityMesh&)>& adapt,
                    const TaskRunner& runner);

}  // namespace tetloom::adapt
