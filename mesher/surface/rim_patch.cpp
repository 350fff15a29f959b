#include "mesher/surface/rim_patch.hpp"

#include <algorithm>
#include <cmath>
#include <span>

namespace tetloom {
namespace {

// Root mean square of |dX/du| and |dX/dv| along the rim.
Vec2 plane_scale(const FaceRim& rim, FaceGeometry& geometry) {
  double uu = 0, vv = 0;
  for (const FaceRim::Vertex& vertex : rim.vertices) {
    const SurfaceDerivatives d = geometry.derivatives(vertex.uv);
    uu += norm2(d.du);
    vv += norm2(d.dv);
  }
  const double n = std::max<double>(1, static_cast<double>(rim.vertices.size()));
  return {uu > 0 ? std::sqrt(uu / n) : 1, vv > 0 ? std::sqrt(vv / n) : 1};
}

// Rim vertices lie where their node lies, which the surface meets within the model's tolerance.
PatchVertex rim_vertex(const PatchSurface& surface, const FaceRim::Vertex& vertex, Vec2 scale, const Vec3& point) {
  PatchVertex result;
  result.place = surface.at_plane({vertex.uv.u * scale.u, vertex.uv.v * scale.v});
  result.place.point = point;
  result.size = surface.size_at(result.place.point);
  result.node = vertex.node;
  return result;
}

}  // namespace

RimPatch make_rim_patch(const ModelTopology& topology, ModelFaceId face, FaceGeometry& geometry, const RimNodes& rim,
                        const SizeField& sizes) {
  return fill_rim_patch(trace_rim(topology, face, geometry, rim), geometry, rim.points(), sizes);
}

RimPatch fill_rim_patch(FaceRim rim, FaceGeometry& geometry, std::span<const Vec3> nodes, const SizeField& sizes) {
  RimPatch patch;
  patch.rim = std::move(rim);
  patch.scale = plane_scale(patch.rim, geometry);
  const PatchSurface surface(geometry, sizes, patch.scale);
  std::vector<Vec2> plane;
  for (const FaceRim::Vertex& vertex : patch.rim.vertices) {
    patch.vertices.push_back(rim_vertex(surface, vertex, patch.scale, nodes[vertex.node]));
    plane.push_back(patch.vertices.back().place.plane);
  }
  patch.polygon = triangulate_polygon(plane, patch.rim.segments);
  return patch;
}

void reserve_expected(Patch& patch) {
  double expected = 0;
  for (std::uint32_t tri = 0; tri < patch.topology.slots(); ++tri) {
    const auto [a, b, c] = patch.topology.triangle(tri);
    const PatchVertex &va = patch.vertices[a], &vb = patch.vertices[b], &vc = patch.vertices[c];
    const double size = (va.size + vb.size + vc.size) / 3;
    expected += 0.5 * cross(vb.place.plane - va.place.plane, vc.place.plane - va.place.plane) / (size * size);
  }
  constexpr double kVerticesPerSquare = 1.1547005383792515, kMargin = 1.1, kMost = 5e6;
  const auto vertices =
      patch.vertices.size() + static_cast<std::size_t>(std::min(kMost, kMargin * kVerticesPerSquare * expected));
  patch.vertices.reserve(vertices);
  patch.topology.reserve(vertices);
}

}  // namespace tetloom
