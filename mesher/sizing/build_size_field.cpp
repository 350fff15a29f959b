#include "mesher/sizing/build_size_field.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mesher/sizing/corner_values.hpp"
#include "mesher/sizing/model_facets.hpp"
#include "mesher/sizing/model_sources.hpp"
#include "mesher/sizing/octree_builder.hpp"
#include "mesher/sizing/size_targets.hpp"
#include "mesher/sizing/source_tree.hpp"
#include "mesher/sizing/target_field.hpp"

namespace tetloom {
namespace {

void check_refinements(std::span<const PointSize> refinements) {
  for (std::size_t i = 0; i < refinements.size(); ++i)
    if (!is_finite(refinements[i].point) || !(std::isfinite(refinements[i].size) && refinements[i].size > 0))
      throw Error(ErrorCode::InvalidArgument,
                  "refinements[" + std::to_string(i) + "] must have a finite point and a positive size");
}

void append_points(std::span<const PointSize> points, double global, std::vector<SizeSource>& sources) {
  for (const PointSize& wish : points)
    if (wish.size < global) sources.push_back({wish.point, wish.point, wish.point, wish.size});
}

void append(const std::vector<SizeSource>& list, std::vector<SizeSource>& sources) {
  sources.insert(sources.end(), list.begin(), list.end());
}

/// The triangles that the sources alone call for: refuses before a tree is built for them.
void check_sources(const std::vector<SizeSource>& sources, std::uint64_t max_memory) {
  double triangles = 0;
  for (const SizeSource& source : sources)
    triangles +=
        0.5 * norm(cross(source.b - source.a, source.c - source.a)) * kTrianglesPerSquare / (source.size * source.size);
  check_memory({.triangles = triangles, .tets = 0, .bytes = triangles * 500}, max_memory);
}

/// What a tree may take: a cell costs about 150 bytes while it is built.
std::size_t cell_limit(std::uint64_t max_memory) {
  constexpr std::uint64_t kBytesPerCell = 150, kMost = std::uint64_t{1} << 30;
  const std::uint64_t bytes = max_memory > 0 ? max_memory : available_memory();
  return static_cast<std::size_t>(bytes == 0 ? kMost : std::min(kMost, bytes / kBytesPerCell));
}

}  // namespace

SizeField build_size_field(const GeometricModel& model, const SizeOptions& options,
                           std::span<const PointSize> refinements, const TaskRunner& runner, std::uint64_t max_memory) {
  const SizeTargets targets = resolve_sizes(model, options);
  check_refinements(refinements);
  check_memory(surface_part(estimate_least_mesh(model, options)), max_memory);

  const bool region_sizes = targets.smallest_region < targets.global;
  const bool every_face = region_sizes || targets.proximity > 0;
  const std::vector<Tessellation> facets = facet_faces(model, source_tolerances(model, targets, every_face), runner);
  std::optional<FacetTree> facet_tree;
  if (every_face) facet_tree.emplace(model, facets, runner);

  std::vector<SizeSource> sources;
  append_points(options.point_sizes, targets.global, sources);
  append_points(refinements, targets.global, sources);
  append(edge_sources(model, targets, runner), sources);
  append(face_sources(model, targets, facets, runner), sources);
  if (targets.proximity > 0) append(proximity_sources(model, targets, facets, *facet_tree, runner), sources);
  if (sources.empty() && !options.callback) return SizeField::uniform(targets.global);
  check_sources(sources, max_memory);

  const SourceTree source_tree(std::move(sources), targets.gradation, runner);
  const TargetField field(targets, source_tree, region_sizes ? &*facet_tree : nullptr, options.callback);
  OctreeBuilder builder(field, model.bounding_box(), cell_limit(max_memory), runner);
  std::vector<OctreeLeaf> leaves;
  SizeOctree tree = builder.build(leaves);
  fill_corner_ratios(tree, leaves, field, runner);
  return SizeField::from_octree(std::move(tree));
}

}  // namespace tetloom
