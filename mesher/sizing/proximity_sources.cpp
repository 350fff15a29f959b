// Gaps and walls, measured by rays along the facets' normals.
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/lists.hpp"
#include "mesher/sizing/facet_refiner.hpp"
#include "mesher/sizing/model_sources.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

/// The model vertices of every face, ascending.
std::vector<std::vector<std::uint32_t>> face_to_vertices(const ModelTopology& topology) {
  std::vector<std::vector<std::uint32_t>> table(topology.face_count());
  for (std::size_t f = 0; f < table.size(); ++f) {
    for (const ModelLoop& loop : topology.face_to_loops[f])
      for (const EdgeUse& use : loop)
        for (const ModelVertexId v : topology.edges[use.edge.value].vertices) table[f].push_back(v.value);
    sort_unique(table[f]);
  }
  return table;
}

bool share_value(const std::vector<std::uint32_t>& a, const std::vector<std::uint32_t>& b) {
  for (std::size_t i = 0, j = 0; i < a.size() && j < b.size();) {
    if (a[i] == b[j]) return true;
    a[i] < b[j] ? ++i : ++j;
  }
  return false;
}

/// Measures gaps and walls from the facets of one face.
class GapProbe {
 public:
  GapProbe(const GeometricModel& model, const SizeTargets& targets, const FacetTree& tree)
      : topology_(model.topology()),
        targets_(targets),
        tree_(tree),
        contact_(1e-6 * model.bounding_box().diagonal()),
        vertices_(face_to_vertices(topology_)) {}

  std::vector<SizeSource> run(std::uint32_t face, const Tessellation& facets, const TaskRunner& runner) const {
    std::vector<SizeSource> out;
    const FacetRules rules{.global = targets_.global, .longest = targets_.global, .spread = 1.4, .finest = 2};
    const auto middle = [](const FacetCorner& a, const FacetCorner& b) {
      return FacetCorner{{}, 0.5 * (a.point + b.point)};
    };
    for (const auto& tri : facets.tri_to_vert) {
      runner.check_cancelled();
      const Vec3 &a = facets.points[tri[0]], &b = facets.points[tri[1]], &c = facets.points[tri[2]];
      const Vec3 normal = normalized(cross(b - a, c - a));
      if (norm2(normal) == 0) continue;
      const auto sample = [&](const FacetPiece& piece, const std::array<double, 3>& w) {
        return size_at(face, w[0] * piece[0].point + w[1] * piece[1].point + w[2] * piece[2].point, normal);
      };
      refine_facet({FacetCorner{{}, a}, FacetCorner{{}, b}, FacetCorner{{}, c}}, rules, sample, middle, out);
    }
    // The size holds as far as the middle of the gap, so that it holds across the gap from both sides.
    for (SizeSource& source : out) source.hold = 0.5 * targets_.proximity * source.size;
    return out;
  }

 private:
  double size_at(std::uint32_t face, const Vec3& x, const Vec3& normal) const {
    const FaceSides& sides = topology_.face_to_sides[face];
    const double gap = std::min(gap_along(face, x, normal, sides.front), gap_along(face, x, -normal, sides.back));
    return std::max(gap / targets_.proximity, targets_.floor);
  }

  /// The width of the gap that the ray crosses inside `region` (or outside of all regions), or infinity.
  double gap_along(std::uint32_t face, const Vec3& x, const Vec3& direction, ModelRegionId region) const {
    constexpr double kCosOpposite = 0.7, kCosOppositeNeighbour = 0.94;
    const double reach = targets_.proximity * targets_.global;
    const std::optional<FacetHit> hit = tree_.first_hit(x, direction, contact_, reach);
    if (!hit || hit->near_region != region) return HUGE_VAL;
    const double facing = std::abs(dot(hit->normal, direction));
    if (facing < kCosOpposite) return HUGE_VAL;
    const bool neighbours = hit->face != face && share_value(vertices_[face], vertices_[hit->face]);
    return neighbours && facing < kCosOppositeNeighbour ? HUGE_VAL : hit->distance;
  }

  const ModelTopology& topology_;
  const SizeTargets& targets_;
  const FacetTree& tree_;
  double contact_;
  std::vector<std::vector<std::uint32_t>> vertices_;
};

}  // namespace

std::vector<SizeSource> proximity_sources(const GeometricModel& model, const SizeTargets& targets,
                                          const std::vector<Tessellation>& facets, const FacetTree& tree,
                                          const SharedWork& work) {
  const GapProbe probe(model, targets, tree);
  return joined(work.make_lists<SizeSource>(facet_counts(facets), [&](std::size_t f) {
    return probe.run(static_cast<std::uint32_t>(f), facets[f], work.runner());
  }));
}

}  // namespace tetloom
