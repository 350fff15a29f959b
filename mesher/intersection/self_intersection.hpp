#pragma once
// Does a triangulated surface cross, touch or fold over itself? Exact, parallel, and told in terms of model faces.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "tetloom/error.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// How two triangles meet that should not.
enum class IntersectionKind : std::uint8_t {
  Crossing,    ///< the triangles meet in points that are not on a vertex or edge that both have
  Overlap,     ///< the same, within one plane; also two triangles with the same three vertices
  Degenerate,  ///< not a pair: the triangle has no area, and `second` is `first`
  Skin         ///< they are apart, but nearer than the model's tolerance with a region between them (skins.hpp)
};

/// Two triangles (first < second) that meet beyond the vertex or edge that they share.
struct TriangleIntersection {
  std::uint32_t first = 0, second = 0;
  IntersectionKind kind = IntersectionKind::Crossing;
  Vec3 point;  ///< at or near a place where they meet, within rounding
};

/// Of both triangles.
double longest_edge(const Mesh& surface, const TriangleIntersection& crossing);

/// The triangles that are compared, and how many of the results are wanted.
struct IntersectionSearch {
  std::span<const Vec3> points;
  std::span<const std::array<std::uint32_t, 3>> tri_to_vert;
  /// Only triangles of one group are compared; empty: all are of one group.
  std::span<const std::uint32_t> tri_to_group = {};
  /// At most this many are returned.
  std::size_t most = 1000;
  /// Whether triangles are counted as done of the runner's present stage.
  bool tells_progress = false;
  /// Only pairs with one such triangle at least are compared, where the others are known to be embedded; empty: all.
  std::span<const std::uint8_t> tri_is_new = {};
};

/// All pairs of triangles of the same group that meet beyond what they share by vertex id: those that cross, those that
/// lie in one plane and overlap, a vertex of one that touches the other, and neighbours folded onto each other. Points
/// of equal coordinates and different ids count as touching. Sorted by (first, second), each pair once.
/// Guaranteed: the decision for each pair is exact. When there are more than `most`, which ones are kept depends on the
/// input alone. Not guaranteed: that the reported point is exactly in both triangles. The empty result is a proof that
/// each group is an embedded surface complex.
/// Pre: indices valid, coordinates finite. Errors: Cancelled. Complexity: O(n log n) for n triangles of similar size.
std::vector<TriangleIntersection> find_self_intersections(const IntersectionSearch& search, const TaskRunner& runner);
/// The same with a tree of the same points and triangles that is there already; ranks share it by blocks of triangles.
std::vector<TriangleIntersection> find_self_intersections(const IntersectionSearch& search,
                                                          const intersection::TriangleTree& tree,
                                                          const SharedWork& work);

/// Where the triangles of a search came from.
struct TriangleOrigin {
  std::span<const std::uint32_t> tri_to_face;  ///< model face index per triangle
  const GeometricModel* model = nullptr;       ///< for names; may be null
};

/// One diagnostic per pair of model faces (or single face) with an intersection, most intersections first: the faces by
/// name, how often, one point, and the triangles (at most 100 of them).
std::vector<Diagnostic> describe_intersections(std::span<const TriangleIntersection> intersections,
                                               const TriangleOrigin& origin);

}  // namespace tetloom
