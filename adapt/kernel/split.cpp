#include <algorithm>
#include <cmath>

#include "adapt/kernel/edge_split.hpp"
#include "adapt/kernel/passes.hpp"

namespace tetloom::adapt {

namespace {

using tets::cube;
using tets::verts_of;

constexpr double kSplitLoss = 0.125, kLeastSplit = 0.03, kNoWorseSplit = 0.99;

Tensor mean(const Tensor& a, const Tensor& b) { return 0.5 * (a + b); }

}  // namespace

Vec3 place_of_split(const CavityMesh& mesh, std::uint32_t a, std::uint32_t b) {
  const Vec3 e = mesh.point(b) - mesh.point(a);
  const double la = std::sqrt(dot(mesh.to_metric[a].tensor, e)), lb = std::sqrt(dot(mesh.to_metric[b].tensor, e));
  const double pieces = std::max(2.0, std::round(mesh.length_of(a, b)));
  return mesh.point(a) + place_on_edge(la, lb, std::floor(pieces / 2) / pieces) * e;
}

// Tets far from the metric become worse before they become better, but not without an end.
double floor_of_split(double floor, double least) {
  return std::max(std::min(cube(floor), kSplitLoss * least), std::min(cube(kLeastSplit), kNoWorseSplit * least));
}

PackedEntity entity_of_edge(const CavityMesh& mesh, const Cavity& cavity) {
  if (!cavity.surface.empty()) {
    const std::uint32_t edge = mesh.surface.find_edge(cavity.core[0], cavity.core[1]);
    if (edge != kNone) return PackedEntity(ModelEntity(1, edge));
  }
  for (const FaceCode face : cavity.surface)
    if (const SurfaceTriangle* triangle = mesh.surface.find(verts_of(mesh.mesh, face)))
      return PackedEntity(ModelEntity(2, triangle->face));
  return PackedEntity(ModelEntity(3, mesh.mesh.to_region[cavity.tets[0]]));
}

Verdict Passes::split(std::uint32_t a, std::uint32_t b, std::uint32_t tet) {
  const std::array<std::uint32_t, 2> core{a, b};
  if (!mesh_.collect(core, tet, cavity_)) return Verdict::TooLarge;
  if (is_frozen(cavity_)) return Verdict::Frozen;
  const Vec3 e = mesh_.point(b) - mesh_.point(a);
  const PackedEntity entity = entity_of_edge(mesh_, cavity_);
  const bool on_surface = !cavity_.surface.empty();
  const double floor = floor_of_split(options_.floor, cavity_.least);
  const Vec3 on_edge = place_of_split(mesh_, a, b);
  std::array<Vec3, 2> places{on_edge, on_edge};
  int first = 1;
  if (on_surface && project_) {
    const auto spot = project_(entity.unpack(), on_edge);
    if (spot && norm2(spot->point - on_edge) < 0.25 * norm2(e)) places[0] = spot->point, first = 0;
  }
  for (int i = first; i < 2; ++i) {
    BackgroundTet hint = mesh_.to_hint[a];
    const Tensor metric = source_.at(places[i], hint);
    const std::uint32_t p = mesh_.add_vertex(places[i], metric, entity, hint);
    bool good = mesh_.evaluate_all(cavity_, p, floor, made_) > floor;
    if (!good) {
      // Where the metric changes much from a to b, their tets are worth little whatever is done.
      mesh_.set_metric(p, mean(mesh_.to_metric[a].tensor, mesh_.to_metric[b].tensor));
      good = mesh_.evaluate_all(cavity_, p, floor, made_) > floor;
      mesh_.set_metric(p, metric);
      if (good) mesh_.evaluate_all(cavity_, p, -1, made_);
    }
    if (good) {
      mesh_.reconnect(cavity_, p, made_);
      return Verdict::Done;
    }
    mesh_.drop_last_vertex();
  }
  return Verdict::Quality;
}

}  // namespace tetloom::adapt
