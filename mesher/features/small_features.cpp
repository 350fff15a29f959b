#include "mesher/features/small_features.hpp"

#include <algorithm>

namespace tetloom {

double SmallFeatures::tolerance_at(const Vec3& x, double size, ModelEntity entity) const {
  constexpr double kMostOfSize = 0.4;
  const double wanted = options_.small_feature > 0 ? options_.small_feature : kSmallFeature * asked_.size_at(x);
  const double model = entity.valid() ? model_.attributes(entity).tolerance : 0;
  return std::min(std::max(wanted, model), kMostOfSize * size);
}

EliminationResult SmallFeatures::eliminate(const Mesh& surface, const SizeField& sizes,
                                           const TaskRunner& runner) const {
  std::vector<double> tolerances(surface.points.size()), wanted(surface.points.size());
  runner.for_blocks(tolerances.size(), std::size_t{1} << 13, [&](std::size_t begin, std::size_t end) {
    for (std::size_t v = begin; v < end; ++v) {
      wanted[v] = sizes.size_at(surface.points[v]);
      tolerances[v] = tolerance_at(surface.points[v], wanted[v], surface.point_to_entity[v]);
    }
  });
  return eliminate_small_features(surface, {tolerances, wanted, kept_}, runner);
}

bool SmallFeatures::keep_where_crossing(const EliminationResult& eliminated,
                                        std::span<const TriangleIntersection> crossings) {
  if (!eliminated.mesh) return false;
  const Mesh& mesh = *eliminated.mesh;
  const std::size_t before = kept_.size();
  for (const TriangleIntersection& crossing : crossings)
    for (const std::uint32_t t : {crossing.first, crossing.second})
      for (const std::uint32_t v : mesh.tri_to_vert[t]) {
        if (!std::ranges::binary_search(eliminated.changed, v)) continue;
        double reach = 0;
        for (const std::uint32_t w : mesh.tri_to_vert[t])
          reach = std::max(reach, distance(mesh.points[v], mesh.points[w]));
        kept_.push_back({mesh.points[v], reach});
      }
  return kept_.size() > before;
}

}  // namespace tetloom
