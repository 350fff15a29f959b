#include "apps/tetloom/solid_copies.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/base/lists.hpp"
#include "core/geometry/bad_geometry.hpp"

namespace tetloom::app {
namespace {

// What solids of one shape have alike.
struct SolidMeasures {
  std::size_t faces = 0;
  double volume = 0, area = 0;

  SolidMeasures(const GeometricModel& model, ModelRegionId region)
      : faces(model.topology().region_to_faces[region.value].size()), volume(model.volume(region)) {
    for (const ModelFaceId face : model.topology().region_to_faces[region.value]) area += model.area(face);
  }
  bool is_like(const SolidMeasures& other) const {
    constexpr double kAlike = 1e-6;
    const auto alike = [](double a, double b) {
      return std::abs(a - b) <= kAlike * std::max(std::abs(a), std::abs(b));
    };
    return faces == other.faces && alike(volume, other.volume) && alike(area, other.area);
  }
};

}  // namespace

std::vector<ModelRegionId> with_copies(const std::vector<ModelRegionId>& solids, const GeometricModel& model) {
  std::vector<ModelRegionId> all = solids;
  tolerate_bad_geometry([&] {
    std::vector<SolidMeasures> wanted;
    for (const ModelRegionId solid : solids) wanted.emplace_back(model, solid);
    for (std::uint32_t r = 0; r < model.topology().region_count(); ++r) {
      const SolidMeasures measures(model, ModelRegionId(r));
      if (std::ranges::any_of(wanted, [&](const SolidMeasures& other) { return measures.is_like(other); }))
        all.push_back(ModelRegionId(r));
    }
  });
  sort_unique(all);
  return all;
}

}  // namespace tetloom::app
