#include "mesher/surface/rim_mesh.hpp"

#include <utility>

#include "mesher/surface/frontal_delaunay.hpp"
#include "mesher/surface/patch_optimizer.hpp"
#include "mesher/surface/rim_patch.hpp"

namespace tetloom {
namespace {

// At a pole, triangles in the plane may have two corners in one node.
FaceMesh extract(const Patch& patch) {
  FaceMesh mesh;
  std::vector<std::uint32_t> ids(patch.vertices.size());
  for (std::size_t v = 0; v < ids.size(); ++v) {
    ids[v] = patch.vertices[v].node;
    if (ids[v] != Triangulation::kNone) continue;
    ids[v] = FaceMesh::kInner | static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.push_back(patch.vertices[v].place.point);
  }
  for (std::uint32_t t = 0; t < patch.topology.slots(); ++t) {
    if (!patch.topology.alive(t)) continue;
    const auto [a, b, c] = patch.topology.triangle(t);
    if (ids[a] == ids[b] || ids[b] == ids[c] || ids[c] == ids[a]) continue;
    mesh.tri_to_vert.push_back({ids[a], ids[b], ids[c]});
    if (signed_quality(patch.vertices[a].place, patch.vertices[b].place, patch.vertices[c].place) <= 0) ++mesh.inverted;
  }
  if (mesh.tri_to_vert.empty()) mesh.verdict = FaceVerdict::RimNotClosed;
  if (mesh.inverted > 0) mesh.verdict = FaceVerdict::NotTriangulated;
  return mesh;
}

RimMesh explain(const RimPatch& given) {
  RimMesh result;
  const auto add = [&](std::uint32_t vertex) { result.crossing.push_back(given.rim.vertices[vertex].node); };
  const auto add_ends = [&](std::uint32_t segment) {
    for (const std::uint32_t vertex : given.rim.segments[segment]) add(vertex);
  };
  const auto& [verdict, first, second, triangulation] = given.polygon;
  result.mesh.verdict = FaceVerdict::RimCrosses;
  switch (verdict) {
    case PolygonVerdict::SegmentsCross: add_ends(first), add_ends(second); break;
    case PolygonVerdict::PointOnSegment: add_ends(first), add(second); break;
    case PolygonVerdict::DuplicatePoint: add(first), add(second); break;
    case PolygonVerdict::NotClosed:
    case PolygonVerdict::Ok: result.mesh.verdict = FaceVerdict::RimNotClosed;
  }
  return result;
}

}  // namespace

RimMesh mesh_in_rim(FaceRim rim, FaceGeometry& geometry, std::span<const Vec3> nodes, const SizeField& sizes,
                    const std::function<bool()>& keep_going) {
  RimPatch given = fill_rim_patch(std::move(rim), geometry, nodes, sizes);
  const PatchSurface surface(geometry, sizes, given.scale);
  if (given.polygon.verdict != PolygonVerdict::Ok) return explain(given);
  Patch patch{std::move(given.polygon.triangulation), std::move(given.vertices), given.rim.repeats_nodes};
  reserve_expected(patch);
  refine_frontal(patch, surface, keep_going);
  sort_spatially(patch);
  optimize_patch(patch, surface, {}, keep_going);
  return {extract(patch), {}};
}

}  // namespace tetloom
