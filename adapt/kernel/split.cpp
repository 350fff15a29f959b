#include "adapt/kernel/passes.hpp"

#include <algorithm>
#include <cmath>

namespace tetloom::adapt {

namespace {

using tets::cube;
using tets::verts_of;

constexpr double kSplitLoss = 0.125, kLeastSplit = 0.03, kNoWorse = 0.99;

Tensor mean(const Tensor& a, const Tensor& b) { return 0.5 * (a + b); }

// Where on the way from a to b the length from a is `share` of the whole: sizes change geometrically on the way.
double place_of(double la, double lb, double share) {
  const double r = lb / la;
  if (!(std::abs(r - 1) > 1e-3)) return share;
  const double s = std::log1p(share * (r - 1)) / std::log(r);
  return std::isfinite(s) ? std::clamp(s, 0.1, 0.9) : share;
}

}  // namespace

PackedEntity Passes::entity_of_edge(std::uint32_t a, std::uint32_t b) const {
  if (cavity_.surface.empty()) return PackedEntity(ModelEntity(3, mesh_.mesh.to_region[cavity_.tets[0]]));
  const std::uint32_t edge = mesh_.surface.find_edge(a, b);
  if (edge != kNone) return PackedEntity(ModelEntity(1, edge));
  return PackedEntity(ModelEntity(2, mesh_.surface.find(verts_of(mesh_.mesh, cavity_.surface[0]))->face));
}

Verdict Passes::split(std::uint32_t a, std::uint32_t b, std::uint32_t tet) {
  const std::array<std::uint32_t, 2> core{a, b};
  if (!mesh_.collect(core, tet, cavity_)) return Verdict::TooLarge;
  if (is_frozen(cavity_)) return Verdict::Frozen;
  const Vec3 e = mesh_.point(b) - mesh_.point(a);
  const double la = std::sqrt(dot(mesh_.to_metric[a].tensor, e)), lb = std::sqrt(dot(mesh_.to_metric[b].tensor, e));
  const double pieces = std::max(2.0, std::round(mesh_.length_of(a, b)));
  const double share = std::floor(pieces / 2) / pieces;
  const PackedEntity entity = entity_of_edge(a, b);
  const bool on_surface = !cavity_.surface.empty();
  // Tets far from the metric become worse before they become better, but not without an end.
  const double floor = std::max(std::min(cube(options_.floor), kSplitLoss * cavity_.least),
                                std::min(cube(kLeastSplit), kNoWorse * cavity_.least));
  const Vec3 on_edge = mesh_.point(a) + place_of(la, lb, share) * e;
  std::array<Vec3, 2> places{on_edge, on_edge};
  int first = 1;
  if (on_surface && project_) {
    const auto spot = project_(entity.unpack(), on_edge);
    if (spot && norm2(spot->point - on_edge) < 0.25 * norm2(e)) places[0] = spot->point, first = 0;
  }
  for (int i = first; i < 2; ++i) {
    std::uint32_t hint = mesh_.to_hint[a];
    const Tensor metric = source_.at(places[i], hint);
    const std::uint32_t p =
        mesh_.add_vertex(places[i], mean(mesh_.to_metric[a].tensor, mesh_.to_metric[b].tensor), entity, hint);
    const double least = mesh_.evaluate_all(cavity_, p, floor, made_);
    if (least > floor) {
      mesh_.set_metric(p, metric);
      mesh_.evaluate_all(cavity_, p, -1, made_);
      mesh_.reconnect(cavity_, p, made_);
      return Verdict::Done;
    }
    mesh_.drop_last_vertex();
  }
  return Verdict::Quality;
}

}  // namespace tetloom::adapt
