#pragma once
// One model face, from its discretised edges to triangles.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "mesher/surface/edge_mesher.hpp"
#include "mesher/surface/kept_facets.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom {

/// The meshed edges of a model with their nodes numbered: model vertices first, then the inner nodes edge by edge.
class RimNodes {
 public:
  RimNodes(const GeometricModel& model, const std::vector<EdgeMesh>& edges);
  /// The number of nodes on vertices and edges.
  std::uint32_t count() const { return static_cast<std::uint32_t>(points_.size()); }
  const Vec3& point(std::uint32_t node) const { return points_[node]; }
  const std::vector<Vec3>& points() const { return points_; }
  /// The model vertex or edge that a node lies on.
  ModelEntity classification(std::uint32_t node) const { return classification_[node]; }
  /// The node at position `i` of the edge's mesh.
  std::uint32_t node(ModelEdgeId edge, std::size_t i) const;
  /// For every node, its number in `other`, a numbering of the same model; none on edges meshed differently there.
  std::vector<std::uint32_t> renumbered(const RimNodes& other) const;
  const EdgeMesh& mesh(ModelEdgeId edge) const { return edges_[edge.value]; }

 private:
  const ModelTopology& topology_;
  const std::vector<EdgeMesh>& edges_;
  std::vector<std::uint32_t> edge_first_;  // first inner node of each edge
  std::vector<Vec3> points_;
  std::vector<ModelEntity> classification_;
};

/// Why a face could not be meshed.
enum class FaceVerdict {
  Ok,
  RimCrosses,      ///< pieces of edges cross in the face's parameter plane: the edges are too coarse
  RimNotClosed,    ///< the loops do not bound an area
  NotTriangulated  ///< neither the parameter plane nor the facets gave a valid triangulation
};

/// The triangles of one face over the nodes of its rim.
struct FaceMesh {
  /// Marks vertices of `tri_to_vert` that are nodes inside the face: the other bits index `points`.
  static constexpr std::uint32_t kInner = 0x80000000u;

  FaceVerdict verdict = FaceVerdict::Ok;
  std::string message;                                    ///< more about a failure, where there is more
  std::vector<Vec3> points;                               ///< nodes inside the face
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;  ///< rim nodes, or kInner | index into `points`
  std::vector<ModelEdgeId> crossing_edges;                ///< with RimCrosses
  Vec3 point;                                             ///< where it failed
  std::size_t inverted = 0;                               ///< triangles that face away from the surface
};

/// What a face needs to know of the rest of the surface.
struct FaceSurroundings {
  const RimNodes& rim;
  const SizeField& sizes;
  /// Pairs of rim nodes (smaller first), sorted: edges between them inside this face get a node in the middle, because
  /// another face has an edge between the same nodes.
  std::span<const std::array<std::uint32_t, 2>> taken_chords;
  /// Remesh the facets also of a face whose rim crosses itself in the plane; else the caller makes its edges finer.
  bool last_attempt = false;
  /// Where faces without a plane keep their facets; null: nowhere.
  const KeptFacets* kept_facets = nullptr;
};

/// Meshes one face: in its parameter plane where it has one, and by remeshing its facets in space where it has none or
/// where that failed. Serial; different faces may be meshed at once.
/// Deterministic. `keep_going` is asked now and then; when it returns false the result is unusable and the caller must
/// be cancelling.
FaceMesh mesh_face(const GeometricModel& model, ModelFaceId face, const FaceSurroundings& surroundings,
                   const std::function<bool()>& keep_going);

}  // namespace tetloom
