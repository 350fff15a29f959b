#include "mesher/layers/side_shape.hpp"

#include <algorithm>
#include <cmath>

namespace tetloom::layers {
namespace {

constexpr double kOffFace = 0.05;  // of the longest piece of the rim

// The value that differs from `x` by whole periods and is nearest to `goal`.
double nearest_period(double goal, double x, double period) {
  return period > 0 ? x + period * std::round((goal - x) / period) : x;
}

struct HalfEdgeCorner {
  std::array<std::uint32_t, 2> verts;
  std::uint32_t triangle;
  std::uint8_t corner;
};

std::vector<HalfEdgeCorner> half_edges(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
  std::vector<HalfEdgeCorner> all;
  all.reserve(3 * triangles.size());
  for (const std::uint32_t t : triangles)
    for (std::uint8_t i = 0; i < 3; ++i)
      all.push_back({{mesh.tri_to_vert[t][i], mesh.tri_to_vert[t][(i + 1) % 3]}, t, i});
  std::ranges::sort(all, {}, &HalfEdgeCorner::verts);
  return all;
}

bool holds(std::span<const std::array<std::uint32_t, 2>> edges, const std::array<std::uint32_t, 2>& verts) {
  return std::ranges::binary_search(edges, std::array{std::min(verts[0], verts[1]), std::max(verts[0], verts[1])});
}

}  // namespace

SidePlacer::SidePlacer(const GeometricModel& model, const Mesh& mesh, const SideShape& shape, FaceGeometry& geometry)
    : mesh_(mesh), shape_(shape), geometry_(geometry), box_(geometry.parameter_box()) {
  if (shape.kind != SideKind::Parametric) return;
  period_ = geometry.period();
  find_poles(model);
}

void SidePlacer::find_poles(const GeometricModel& model) {
  for (const ModelLoop& loop : model.topology().face_to_loops[shape_.face.value])
    for (const EdgeUse& use : loop) {
      const ModelEdgeTopology& edge = model.topology().edges[use.edge.value];
      if (!edge.degenerate) continue;
      const ParameterRange range = geometry_.edge_range(use);
      for (const double t : {range.lo, range.hi})
        pole_to_places_[edge.vertices[0].value].push_back(geometry_.edge_parameters(use, t));
    }
}

const std::vector<Vec2>* SidePlacer::poles_of(std::uint32_t vert) const {
  const ModelEntity& entity = mesh_.point_to_entity[vert];
  if (entity.dim != 0) return nullptr;
  const auto found = pole_to_places_.find(entity.index);
  return found == pole_to_places_.end() ? nullptr : &found->second;
}

Vec2 SidePlacer::near(const Vec2& place, Vec2 uv) const {
  return {nearest_period(place.u, uv.u, period_.u), nearest_period(place.v, uv.v, period_.v)};
}

Vec2 SidePlacer::beside(const Vec2& place, const Vec3& x) {
  if (shape_.kind != SideKind::Parametric) return shape_.plane.to_plane(x);
  return near(place, geometry_.closest_point(x, place).uv);
}

std::array<Vec2, 3> SidePlacer::corners(std::uint32_t triangle) {
  const auto& verts = mesh_.tri_to_vert[triangle];
  std::array<Vec2, 3> places;
  if (shape_.kind != SideKind::Parametric) {
    for (std::size_t i = 0; i < 3; ++i) places[i] = shape_.plane.to_plane(mesh_.points[verts[i]]);
    return places;
  }
  const Vec3 middle = (mesh_.points[verts[0]] + mesh_.points[verts[1]] + mesh_.points[verts[2]]) / 3;
  const Vec2 center = near(0.5 * (box_.lo + box_.hi), geometry_.closest_point(middle, {}).uv);
  for (std::size_t i = 0; i < 3; ++i) {
    if (const std::vector<Vec2>* poles = poles_of(verts[i])) {
      places[i] = *std::ranges::min_element(*poles, {}, [&](const Vec2& place) { return norm(place - center); });
      continue;
    }
    const auto [found, is_new] = known_.try_emplace(verts[i]);
    if (is_new) {
      const SurfacePoint nearest = geometry_.closest_point(mesh_.points[verts[i]], center);
      found->second = nearest.uv;
      distance_ = std::max(distance_, nearest.distance);
    }
    places[i] = near(center, found->second);
  }
  return places;
}

std::vector<RimPiece> find_rim(const Mesh& mesh, std::span<const std::uint32_t> triangles,
                               std::span<const std::array<std::uint32_t, 2>> edges, SidePlacer& placer) {
  const std::vector<HalfEdgeCorner> all = half_edges(mesh, triangles);
  std::vector<RimPiece> rim;
  double longest = 0;
  const auto place_of = [&](const HalfEdgeCorner& at) {
    const std::array<Vec2, 3> places = placer.corners(at.triangle);
    const bool is_upright = cross(places[1] - places[0], places[2] - places[0]) > 0;
    return std::pair(is_upright, RimPiece{at.verts, {places[at.corner], places[(at.corner + 1) % 3]}});
  };
  for (const HalfEdgeCorner& here : all) {
    const auto twin =
        std::ranges::lower_bound(all, std::array{here.verts[1], here.verts[0]}, {}, &HalfEdgeCorner::verts);
    const bool is_inside = twin != all.end() && twin->verts == std::array{here.verts[1], here.verts[0]};
    if (is_inside && !holds(edges, here.verts)) continue;
    const auto [is_upright, piece] = place_of(here);
    if (!is_upright) return {};
    longest = std::max(longest, distance(mesh.points[here.verts[0]], mesh.points[here.verts[1]]));
    rim.push_back(piece);
    if (!is_inside) continue;
    const auto beside = place_of(*twin).second.places;
    // A seam has another place on its other side; at a pole there may be one for all.
    for (const std::size_t i : {0u, 1u})
      if (!placer.is_pole(here.verts[i]) && piece.places[i] == beside[1 - i]) return {};
  }
  if (placer.distance() > kOffFace * longest) return {};
  return rim;
}

}  // namespace tetloom::layers
