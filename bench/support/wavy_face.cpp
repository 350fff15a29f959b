#include "bench/support/wavy_face.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/spatial/constrained_delaunay.hpp"

namespace tetloom::bench {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

[[noreturn]] void refuse() { throw Error(ErrorCode::Internal, "the face of the benches does not answer this"); }

}  // namespace

Vec3 WavyFace::evaluate(const Vec2& uv) {
  return {uv.u, uv.v, amplitude_ * std::sin(kTurn * uv.u) * std::cos(kTurn * uv.v)};
}

SurfaceDerivatives WavyFace::derivatives(const Vec2& uv) {
  const double su = std::sin(kTurn * uv.u), cu = std::cos(kTurn * uv.u);
  const double sv = std::sin(kTurn * uv.v), cv = std::cos(kTurn * uv.v);
  const double steep = kTurn * amplitude_;
  return {{uv.u, uv.v, amplitude_ * su * cv}, {1, 0, steep * cu * cv}, {0, 1, -steep * su * sv}};
}

Vec3 WavyFace::normal(const Vec2& uv) {
  const SurfaceDerivatives d = derivatives(uv);
  return normalized(cross(d.du, d.dv));
}

PrincipalCurvatures WavyFace::curvature(const Vec2&) { refuse(); }
SurfacePoint WavyFace::closest_point(const Vec3&, const std::optional<Vec2>&) { refuse(); }
Vec2 WavyFace::edge_parameters(const EdgeUse&, double) { refuse(); }
ParameterRange WavyFace::edge_range(const EdgeUse&) { refuse(); }
Tessellation WavyFace::tessellate(double, double) { refuse(); }

Patch make_square_patch(const PatchSurface& surface, double size) {
  const auto pieces = static_cast<std::uint32_t>(std::ceil(1 / size));
  const std::array<Vec2, 5> corners = {{{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}}};
  Patch patch;
  std::vector<Vec2> plane;
  std::vector<std::array<std::uint32_t, 2>> segments;
  for (std::size_t side = 0; side < 4; ++side) {
    for (std::uint32_t i = 0; i < pieces; ++i) {
      const double share = static_cast<double>(i) / pieces;
      const Vec2 point = corners[side] + share * (corners[side + 1] - corners[side]);
      const auto index = static_cast<std::uint32_t>(plane.size());
      segments.push_back({index, (index + 1) % (4 * pieces)});
      plane.push_back(point);
      const PatchPlace place = surface.at_plane(point);
      patch.vertices.push_back({place, surface.size_at(place.point), index});
    }
  }
  patch.topology = triangulate_polygon(plane, segments).triangulation;
  return patch;
}

}  // namespace tetloom::bench
