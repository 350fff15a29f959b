#pragma once
// The triangulation from which a face without a usable parametrisation is remeshed in space: the face's tessellation
// with its rim replaced by the nodes of the meshed edges.
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom {

/// A node of a meshed edge, at its place on the edge.
struct BoundaryNode {
  std::uint32_t node = 0;  ///< the mesh node's number; copies of a node in the result have it too
  double t = 0;
  Vec3 point;
};

/// The nodes of one edge use of a face, from the start to the end of the edge's range whatever `use.forward` says; the
/// model vertices at the ends are included, so a closed edge begins and ends with the same node. A seam gives two
/// chains over the same nodes, one per use. Degenerate edges may be left out or have nodes that all coincide.
struct BoundaryChain {
  EdgeUse use;
  std::array<ModelVertexId, 2> vertices;  ///< at the start and the end of the edge
  std::vector<BoundaryNode> nodes;        ///< t ascending
};

/// Why the rim of a tessellation cannot be replaced.
enum class FacetPatchVerdict {
  Ok,
  NotManifold,     ///< facets meet three to an edge, disagree in orientation, or have a rim that is on no model edge
  ChainsDisagree,  ///< the rim of the facets and the chains do not run through the same edges and vertices
  Stuck,           ///< the nodes bound no triangulation: a loop of fewer than three
  Cancelled
};

/// The tessellation of a face with the nodes of its edges as its rim.
struct FacetPatch {
  static constexpr std::uint32_t kNoNode = 0xffffffffu;

  FacetPatchVerdict verdict = FacetPatchVerdict::Ok;
  Vec3 trouble;              ///< where it failed, or where a triangle faces away
  std::size_t inverted = 0;  ///< triangles that face away from the surface
  std::vector<Vec3> points;
  std::vector<Vec2> uv;  ///< of the face at or near the point, fit as guess for closest_point
  /// Of the facets at the point, at a rim of those on this side of it; zero where they turn too far to have one.
  std::vector<Vec3> normals;
  std::vector<std::uint32_t> node;  ///< kNoNode inside of the face
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;
};

/// Replaces the rim of a face's tessellation by the nodes of its edges: nodes are inserted where they belong by their
/// t, then every rim point that is no node is removed by triangulating what was around it anew.
///
/// Post, when Ok: an oriented manifold of the tessellation's Euler characteristic, with the copies of a pole joined;
/// each piece between consecutive nodes of a chain is an edge of exactly one triangle, and there are no other such
/// edges; two nodes share at most one edge, the two sides of a seam counted as one. `inverted` triangles face away from
/// the mean of the tessellation's normals at their corners; there are none unless the nodes are so coarse that no
/// triangulation of the points around avoids it. Points inside of the face are points of the tessellation, of which
/// some near the rim are gone, and points in the middle of its edges. Otherwise the arrays are empty.
///
/// A face's facets may be as long as the face. With `size_at`, edges near a rim point that cannot be removed are halved
/// until they are as short as the size: what is then removed around it is small, so that the rest keeps to the surface.
///
/// Triangles turn by at most 60° against the mean of the tessellation's normals at their corners where that can be
/// had, by up to 90° or else by any angle where there is no other way. The hole around a removed point is filled
/// optimally (the worst triangle is the best possible, by dynamic programming), in place of the edge collapses usual in
/// remeshing (Botsch & Kobbelt 2004); a point inside that lies beyond the new rim is removed in the same way.
///
/// Faces without chains come back as they are. `keep_going` is asked now and then; false ends the call as Cancelled.
/// Deterministic; serial; different calls may run at once.
FacetPatch make_facet_patch(const Tessellation& tessellation, std::span<const BoundaryChain> chains,
                            const std::function<bool()>& keep_going = {},
                            const std::function<double(const Vec3&)>& size_at = {});

}  // namespace tetloom
