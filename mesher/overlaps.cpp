#include "mesher/overlaps.hpp"

#include <algorithm>
#include <map>
#include <optional>

#include "mesher/intersection/triangle_tree.hpp"

namespace tetloom {
namespace {

struct Overlap {
  ModelRegionId inner, outer;
  std::uint32_t face;
  Vec3 point;
};

class OverlapFinder {
 public:
  OverlapFinder(const GeometricModel& model, const Mesh& mesh, const TaskRunner& runner)
      : model_(model), mesh_(mesh), runner_(runner), tree_(mesh.points, mesh.tri_to_vert, runner) {}

  std::vector<Diagnostic> run() {
    const std::vector<std::uint32_t> samples = choose_samples();
    std::vector<std::optional<Overlap>> found(samples.size());
    runner_.for_each(samples.size(), [&](std::size_t i) { found[i] = examine(samples[i]); });
    std::map<std::array<std::uint32_t, 2>, Overlap> pairs;  // the first of every two regions
    for (const auto& overlap : found) {
      if (!overlap) continue;
      const auto [low, high] = std::minmax(overlap->inner.value, overlap->outer.value);
      pairs.try_emplace({low, high}, *overlap);
    }
    return describe(pairs);
  }

 private:
  std::vector<std::uint32_t> choose_samples() const {
    constexpr std::size_t kPerFace = 16;
    std::vector<std::size_t> counts(model_.topology().face_count(), 0), seen(counts.size(), 0);
    for (const std::uint32_t face : mesh_.tri_to_entity) ++counts[face];
    std::vector<std::uint32_t> samples;
    for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t) {
      const std::uint32_t face = mesh_.tri_to_entity[t];
      const std::size_t step = std::max<std::size_t>(1, counts[face] / kPerFace);
      if (seen[face]++ % step == 0) samples.push_back(t);
    }
    return samples;
  }

  std::optional<Overlap> examine(std::uint32_t triangle) const {
    constexpr double kDepth = 0.25;
    const FaceSides& sides = model_.topology().face_to_sides[mesh_.tri_to_entity[triangle]];
    const auto [a, b, c] = tree_.corners_of(triangle);
    const Vec3 normal = normalized(cross(b - a, c - a));
    const double depth = kDepth * std::max({distance(a, b), distance(b, c), distance(c, a)});
    const ModelRegionId own = sides.back.valid() ? sides.back : sides.front;
    if (!own.valid()) return {};
    const Vec3 inside = (a + b + c) / 3 + (sides.back.valid() ? -depth : depth) * normal;
    const std::vector<std::uint32_t> around = regions_around(inside);
    if (!std::binary_search(around.begin(), around.end(), own.value)) return {};  // a wall thinner than that
    for (const std::uint32_t other : around)
      if (other != own.value) return Overlap{own, ModelRegionId(other), mesh_.tri_to_entity[triangle], inside};
    return {};
  }

  // Upwards, a ray leaves every region that it began in once more often than it enters it.
  std::vector<std::uint32_t> regions_around(const Vec3& x) const {
    std::vector<std::uint32_t> left, entered, around;
    tree_.for_each_above(x, [&](std::uint32_t triangle, bool up) {
      const FaceSides& sides = model_.topology().face_to_sides[mesh_.tri_to_entity[triangle]];
      const ModelRegionId below = up ? sides.back : sides.front, above = up ? sides.front : sides.back;
      if (below.valid()) left.push_back(below.value);
      if (above.valid()) entered.push_back(above.value);
    });
    std::sort(left.begin(), left.end());
    std::sort(entered.begin(), entered.end());
    std::set_difference(left.begin(), left.end(), entered.begin(), entered.end(), std::back_inserter(around));
    around.erase(std::unique(around.begin(), around.end()), around.end());
    return around;
  }

  std::vector<Diagnostic> describe(const std::map<std::array<std::uint32_t, 2>, Overlap>& pairs) const {
    constexpr std::size_t kMost = 50;
    std::vector<Diagnostic> warnings;
    for (const auto& [regions, overlap] : pairs) {
      if (warnings.size() == kMost) break;
      warnings.push_back(
          {ErrorCode::InputUnsuitable,
           "two solids overlap; each is meshed on its own (imprinting would divide them)",
           {model_.named(overlap.inner), model_.named(overlap.outer), model_.named(ModelFaceId(overlap.face))},
           overlap.point,
           {}});
    }
    return warnings;
  }

  const GeometricModel& model_;
  const Mesh& mesh_;
  const TaskRunner& runner_;
  const intersection::TriangleTree tree_;
};

}  // namespace

std::vector<Diagnostic> find_overlapping_regions(const GeometricModel& model, const Mesh& surface,
                                                 const TaskRunner& runner) {
  if (model.topology().region_count() < 2 || surface.tri_to_vert.empty()) return {};
  return OverlapFinder(model, surface, runner).run();
}

}  // namespace tetloom
