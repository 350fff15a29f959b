#pragma once
// The mesh between two rounds of adaptation, or what one rank has of it.
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "adapt/kernel/cavity_mesh.hpp"
#include "adapt/parts/mesh_slice.hpp"
#include "core/base/lists.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/storage.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// A triangle of the surface and the tets that have it; the second one is kNone where nothing lies on that side. After
/// a round, each of two parts that have a triangle has one for its own tet.
struct LinkedTriangle {
  SurfaceTriangle triangle;
  std::array<std::uint32_t, 2> tets{kNone, kNone};
};

/// A piece of a model edge.
struct ModelEdgePiece {
  std::array<std::uint32_t, 2> verts;  ///< ascending
  std::uint32_t edge = kNone;          ///< model edge
  friend auto operator<=>(const ModelEdgePiece&, const ModelEdgePiece&) = default;
};

/// Sorts them, and drops what is there twice.
inline void sort_pieces(std::vector<ModelEdgePiece>& pieces) { sort_unique(pieces); }

/// Struct of arrays. `edges` are sorted; all of them are sides of triangles. `to_neighbor` is as in tets::TetMesh, with
/// nothing behind triangles of the outer surface alone, and where other ranks have what is behind; it is there until
/// the first round: parts link their tets anew.
struct WholeMesh {
  GrowingArray<Vec3> points;
  GrowingArray<VertexMetric> to_metric;
  GrowingArray<PackedEntity> to_entity;
  GrowingArray<BackgroundTet> to_hint;
  GrowingArray<std::uint8_t> to_state;  ///< as in CavityMesh, for the next round
  GrowingArray<std::uint32_t> to_vert;  ///< 4 per tet
  GrowingArray<FaceCode> to_neighbor;   ///< 4 per tet
  GrowingArray<std::uint32_t> to_region;
  std::vector<LinkedTriangle> triangles;
  std::vector<ModelEdgePiece> edges;

  std::size_t size() const { return to_region.size(); }
  tets::FaceRange faces() const { return {0, size()}; }
  FaceCode behind(FaceCode face) const { return to_neighbor[face.index()]; }
  /// The vertex that the face's tet has and the face has not.
  std::uint32_t apex(FaceCode face) const { return to_vert[face.index()]; }
  /// Whether the vertex may be an end of a piece of a model edge.
  bool is_on_edge(std::uint32_t vert) const {
    const ModelEntity entity = to_entity[vert].unpack();
    return entity.valid() && entity.dim <= 1;
  }
};

/// Calls visit(piece) for every edge of the tet that is a piece of a model edge.
template <class Visit>
void for_each_piece(const WholeMesh& whole, std::uint32_t tet, const Visit& visit) {
  std::array<std::uint32_t, 4> verts;
  std::size_t count = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const std::uint32_t v = whole.to_vert[std::size_t{tet} * 4 + i];
    if (whole.is_on_edge(v)) verts[count++] = v;
  }
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const std::array<std::uint32_t, 2> ends{std::min(verts[i], verts[j]), std::max(verts[i], verts[j])};
      const auto at = std::lower_bound(whole.edges.begin(), whole.edges.end(), ModelEdgePiece{ends, 0});
      if (at != whole.edges.end() && at->verts == ends) visit(*at);
    }
  }
}

/// From the tets, triangles and edges of `mesh`. Where it names no entities, faces of the hull without a triangle get
/// one without an entity, and edges between triangles of different entities, or of other than two, become pieces of
/// model edges that are named after them. Metrics are left at zero.
/// Errors: InputUnsuitable with place and element: cells that are no tets, tets without volume, faces of three tets,
/// triangles that no tet has, tets of two regions that meet without a triangle.
WholeMesh make_whole_mesh(const Mesh& mesh, const TaskRunner& runner);

/// What make_whole_mesh says of a slice, but without metrics: right for what has a vertex of the slice's own; others
/// lie on nothing, and pieces of model edges between them are left out. In SharedWork::together. Errors: as those of
/// the whole, where they are in the slice; they may be worded otherwise.
WholeMesh make_slice_mesh(const MeshSlice& slice, const SharedWork& work);

/// The vertices of its tets.
std::vector<std::array<std::uint32_t, 4>> tets_of(const WholeMesh& whole, const TaskRunner& runner);

/// The mesh as it is now, with the names, sides and entities of `source`; without fields.
Mesh make_mesh_of(const WholeMesh& whole, const Mesh& source, const TaskRunner& runner);

}  // namespace tetloom::adapt
