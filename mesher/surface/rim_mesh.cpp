#include "mesher/surface/rim_mesh.hpp"

#include <utility>

#include "mesher/surface/frontal_delaunay.hpp"
#include "mesher/surface/patch_optimizer.hpp"
#include "mesher/surface/rim_patch.hpp"

namespace tetloom {
namespace {

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
    mesh.tri_to_vert.push_back({ids[a], ids[b], ids[c]});
  }
  return mesh;
}

}  // namespace

FaceMesh mesh_in_rim(FaceRim rim, FaceGeometry& geometry, std::span<const Vec3> nodes, const SizeField& sizes,
                     const std::function<bool()>& keep_going) {
  RimPatch given = fill_rim_patch(std::move(rim), geometry, nodes, sizes);
  const PatchSurface surface(geometry, sizes, given.scale);
  FaceMesh failed;
  failed.verdict = FaceVerdict::RimNotClosed;
  if (given.polygon.verdict != PolygonVerdict::Ok) return failed;
  Patch patch{std::move(given.polygon.triangulation), std::move(given.vertices), given.rim.repeats_nodes};
  reserve_expected(patch);
  refine_frontal(patch, surface, keep_going);
  sort_spatially(patch);
  optimize_patch(patch, surface, {}, keep_going);
  FaceMesh mesh = extract(patch);
  return mesh.tri_to_vert.empty() ? failed : mesh;
}

}  // namespace tetloom
