#pragma once
// The steps of make_facet_patch. Private to mesher/surface; see facet_patch.hpp.
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <set>
#include <span>
#include <utility>
#include <vector>

#include "core/spatial/triangulation.hpp"
#include "mesher/surface/facet_patch.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// Ends the work with a verdict; caught by make_facet_patch.
struct PatchFailure {
  FacetPatchVerdict verdict;
  Vec3 point;
};

/// What the vertices of the triangulation carry, indexed as there.
struct PatchVertices {
  std::vector<Vec3> points, normals;
  std::vector<Vec2> uv;
  std::vector<ModelEntity> entity;
  std::vector<double> t;
  std::vector<std::uint32_t> node;
  std::vector<bool> sharp;  ///< a facet at the point turns far from the normal: a tip, or the end of a crease

  std::uint32_t size() const { return static_cast<std::uint32_t>(points.size()); }
  void add_copy(std::uint32_t of, const Vec3& point, const Vec3& normal) {
    points.push_back(point), normals.push_back(normal), uv.push_back(uv[of]);
    entity.push_back(entity[of]), t.push_back(t[of]), node.push_back(FacetPatch::kNoNode);
    sharp.push_back(false);
  }
};

/// Fills an empty triangulation with the facets. What a parametrisation takes apart at poles is joined, and every fan
/// of facets gets a vertex of its own, so that the rim passes each vertex once. Throws PatchFailure.
void join_facets(const Tessellation& tessellation, Triangulation& mesh, PatchVertices& vertices);

/// The rim from one model vertex to the next, face on the left.
struct RimRun {
  std::vector<std::uint32_t> verts;
  const BoundaryChain* chain = nullptr;
};

/// Cuts the rim into runs and gives each its chain. Throws PatchFailure.
std::vector<RimRun> match_runs(const Triangulation& mesh, const PatchVertices& vertices,
                               std::span<const BoundaryChain> chains);

/// Puts the nodes of its chain into a run. The run then holds its old points and the nodes in order.
void insert_nodes(Triangulation& mesh, PatchVertices& vertices, RimRun& run);

/// Puts a point in the middle of an edge inside.
std::uint32_t halve_edge(Triangulation& mesh, PatchVertices& vertices, std::uint32_t half);

/// What make_facet_patch asks its caller; either may be empty.
struct PatchCallbacks {
  const std::function<bool()>& keep_going;
  const std::function<double(const Vec3&)>& size_at;
};

/// Halves edges inside of the triangles at `centers` that are longer than the size at their ends, longest first. That
/// moves no surface, and ends because halves are shorter. Pre: size_at. Throws PatchFailure (Cancelled).
void halve_long_edges(Triangulation& mesh, PatchVertices& vertices, std::span<const std::uint32_t> centers,
                      const PatchCallbacks& callbacks);

/// Halves edges inside between two copies of one node, and all but one of those between the same two nodes.
void halve_repeated_edges(Triangulation& mesh, PatchVertices& vertices);

/// A set of triangles without vertices of their own inside, but for one that is to go, and what is around it. Where
/// that vertex lies on the rim, the ring begins after it on the rim and ends before it.
///
///        r2 ─── r1          outer[i] is the half-edge on the far side of r(i) → r(i+1), kNone on a rim.
///       /  \   /  \         The hole is filled from the base edge: from the last of the ring to the first.
///     r3 ─── v ─── r0
struct PatchCavity {
  std::vector<std::uint32_t> ring, outer, tris;
  bool closed = false;
};

/// How far a cavity may grow: by so many layers of triangles.
enum class Reach { Ball = 0, Near = 2, Far = 5 };

/// Takes vertices out of the triangulation, keeping it one.
class PatchVertexRemover {
 public:
  PatchVertexRemover(Triangulation& mesh, PatchVertices& vertices);

  /// The triangles around v.
  const PatchCavity& collect_ball(std::uint32_t v);

  /// Removes v if what was around it can be triangulated with no triangle turned by more than acos(level) against the
  /// surface; else leaves everything as it is. Where that fails for the triangles around v alone, more are taken in.
  bool remove(std::uint32_t v, double level, Reach reach);

  /// Removes v whatever way its surroundings then face; edges further away that stand in the way are halved. False only
  /// where no triangulation is left without v.
  bool force(std::uint32_t v);

  /// Triangulates the surroundings of a triangle anew, in the same way.
  bool reshape(std::uint32_t tri, double level, Reach reach);

  /// Flips the edge of a half-edge if that makes the worse of its two triangles better, with neither turned by more
  /// than acos(level), and the new edge passes within `tolerance` of the old one.
  bool improve(std::uint32_t half, double level, double tolerance);

  /// The triangle's quality 4√3·A/Σl², or -1 where it is no triangle or turned by more than acos(level).
  double score(std::uint32_t a, std::uint32_t b, std::uint32_t c, double level) const;

  bool connected(std::uint32_t a, std::uint32_t b) const;

 private:
  /// Adds the triangles on the far side of the ring, where that takes in no vertex. False when there was none.
  bool grow();
  /// Fills the cavity, grown as far as needed.
  bool refill(double level, Reach reach);
  bool fill_once(double level);
  /// Whether a new inner edge may join two vertices: they are not joined outside of the cavity, and neither are other
  /// copies of their nodes.
  bool may_join(std::uint32_t a, std::uint32_t b) const;
  bool connected_outside(std::uint32_t a, std::uint32_t b) const;
  bool copies_may_join(std::uint32_t a, std::uint32_t b) const;
  /// Whether the edge has a triangle that is not in the cavity; false for kNone.
  bool is_outside(std::uint32_t half) const;
  void note_edges_of_ring();
  /// may_join() of two places of the ring, whose edges have been noted.
  bool may_join_in_ring(std::size_t i, std::size_t j) const;
  double& best(std::size_t i, std::size_t j) { return best_[i * cavity_.ring.size() + j]; }
  enum class Facing { Surface, Any };
  /// Edges outside of the cavity, from and to, that join the ends of edges planned in it.
  std::vector<std::array<std::uint32_t, 2>> find_obstacles() const;
  void list_planned(std::size_t i, std::size_t j, std::vector<std::array<std::size_t, 2>>& edges) const;
  void apply_plan();
  /// Quality times the cosine against the surface, made positive.
  double score_any(std::uint32_t a, std::uint32_t b, std::uint32_t c) const;
  /// Finds the triangulation of the ring whose worst triangle is best: best(i, j) is for the part from i to j, whose
  /// triangle at the edge j → i has its tip at split_.
  bool plan(double level, Facing facing = Facing::Surface);
  /// Makes the triangles of the part from i to j; returns the half-edge j → i.
  std::uint32_t fill(std::size_t i, std::size_t j);

  Triangulation& mesh_;
  PatchVertices& vertices_;
  std::map<std::uint32_t, std::vector<std::uint32_t>> node_to_copies_;
  PatchCavity cavity_;
  std::uint32_t removed_ = Triangulation::kNone;                 // the vertex inside of the cavity
  std::set<std::pair<std::uint32_t, std::uint32_t>> forbidden_;  // pairs that force() may not join
  std::vector<double> best_;
  std::vector<std::size_t> split_;
  std::vector<std::uint32_t> edge_to_;  // per pair of places in the ring: the half-edge from the first, or kNone
};

}  // namespace tetloom::detail
