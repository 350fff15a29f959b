#include "mesher/features/small_features.hpp"

#include <algorithm>
#include <cmath>

#include "tetloom/tasks.hpp"

namespace tetloom {

double SmallFeatures::tolerance_at(const Vec3& x, double size, ModelEntity entity) const {
  constexpr double kMostOfSize = 0.4;
  const double wanted = options_.small_feature > 0 ? options_.small_feature : kSmallFeature * asked_.size_at(x);
  const double model = entity.valid() ? model_.attributes(entity).tolerance : 0;
  return std::min(std::max(wanted, model), kMostOfSize * size);
}

namespace {

// The volume that the triangles at each region bound, as they are turned; from the middle of the box, to keep digits.
std::vector<double> region_volumes(const Mesh& mesh, std::size_t regions) {
  std::vector<double> volumes(regions, 0);
  const Box3 box = box_of(mesh.points);
  const Vec3 middle = box.center();
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    const auto& [a, b, c] = mesh.tri_to_vert[t];
    const FaceSides& sides = mesh.face_to_sides[mesh.tri_to_entity[t]];
    const double six = dot(mesh.points[a] - middle, cross(mesh.points[b] - middle, mesh.points[c] - middle));
    if (sides.back.valid()) volumes[sides.back.value] += six / 6;
    if (sides.front.valid()) volumes[sides.front.value] -= six / 6;
  }
  return volumes;
}

}  // namespace

void SmallFeatures::spare_points(const Mesh& surface, std::vector<double>& tolerances) const {
  std::vector<double> shares(tolerances.size(), 1);
  for (std::size_t t = 0; t < surface.tri_to_vert.size(); ++t) {
    const std::uint32_t face = surface.tri_to_entity[t];
    double share = 1;
    for (const ModelRegionId region : {surface.face_to_sides[face].front, surface.face_to_sides[face].back})
      if (region.valid() && !region_limits_.empty()) share = std::min(share, region_limits_[region.value].share);
    for (const std::uint32_t v : surface.tri_to_vert[t]) {
      tolerances[v] = std::min(tolerances[v], face_limits_[face]);
      shares[v] = std::min(shares[v], share);
    }
  }
  for (std::size_t v = 0; v < tolerances.size(); ++v) tolerances[v] *= shares[v];
}

bool SmallFeatures::spare_regions(const Mesh& surface, const EliminationResult& eliminated) {
  constexpr double kMostError = 0.0075, kMostWorse = 0.001;  // of the model's volume
  // The next tolerance is the one that would do if the volume changed by as much as the tolerance does.
  constexpr double kSafety = 0.7, kLeastCut = 0.05, kMostCut = 0.5;
  constexpr int kMostCuts = 3;
  if (!eliminated.mesh) return false;
  const std::size_t regions = model_.topology().region_count();
  const std::vector<double> before = region_volumes(surface, regions);
  const std::vector<double> after = region_volumes(*eliminated.mesh, regions);
  region_limits_.resize(regions);
  bool any = false;
  for (std::size_t r = 0; r < regions; ++r) {
    const double volume = std::abs(model_.volume(ModelRegionId(r)));
    const double error = std::abs(after[r] - volume), worse = error - std::abs(before[r] - volume);
    if (error <= kMostError * volume || worse <= kMostWorse * volume || region_limits_[r].cuts > kMostCuts) continue;
    const double cut = std::clamp(kSafety * kMostError * volume / worse, kLeastCut, kMostCut);
    region_limits_[r].share *= ++region_limits_[r].cuts > kMostCuts ? 0 : cut;
    any = true;
  }
  return any;
}

EliminationResult SmallFeatures::eliminate(const Mesh& surface, const SizeField& sizes, const TaskRunner& runner) {
  std::vector<double> tolerances(surface.points.size()), wanted(surface.points.size());
  runner.for_blocks(tolerances.size(), std::size_t{1} << 13, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      wanted[v] = sizes.size_at(surface.points[v]);
      tolerances[v] = tolerance_at(surface.points[v], wanted[v], surface.point_to_entity[v]);
    }
  });
  spare_points(surface, tolerances);
  return eliminate_small_features(surface, {tolerances, wanted, kept_}, runner, &known_zones_);
}

bool SmallFeatures::keep_where_crossing(const Mesh& mesh, std::span<const std::uint32_t> changed,
                                        std::span<const TriangleIntersection> crossings) {
  const std::size_t before = kept_.size();
  for (const TriangleIntersection& crossing : crossings)
    for (const std::uint32_t t : {crossing.first, crossing.second})
      for (const std::uint32_t v : mesh.tri_to_vert[t]) {
        if (!std::ranges::binary_search(changed, v)) continue;
        double reach = 0;
        for (const std::uint32_t w : mesh.tri_to_vert[t])
          reach = std::max(reach, distance(mesh.points[v], mesh.points[w]));
        const bool is_kept = std::ranges::any_of(kept_, [&](const KeptPlace& place) {
          return place.radius >= 0.5 * reach && distance(place.center, mesh.points[v]) <= 0.5 * place.radius;
        });
        if (!is_kept) kept_.push_back({mesh.points[v], reach});
      }
  return kept_.size() > before;
}

}  // namespace tetloom
