#include "mesher/sizing/build_size_field.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/free_memory.hpp"
#include "core/base/lists.hpp"
#include "mesher/sizing/corner_values.hpp"
#include "mesher/sizing/model_facets.hpp"
#include "mesher/sizing/model_sources.hpp"
#include "mesher/sizing/octree_builder.hpp"
#include "mesher/sizing/refinement_budget.hpp"
#include "mesher/sizing/size_targets.hpp"
#include "mesher/sizing/source_tree.hpp"
#include "mesher/sizing/target_field.hpp"
#include "mesher/sizing/wire_faces.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/copy_of_machine.hpp"

namespace tetloom {
namespace {

void check_refinements(std::span<const SizeRefinement> refinements) {
  for (std::size_t i = 0; i < refinements.size(); ++i)
    if (!std::ranges::all_of(refinements[i].corners, is_finite) ||
        !(std::isfinite(refinements[i].size) && refinements[i].size > 0))
      throw Error(ErrorCode::InvalidArgument,
                  "refinements[" + std::to_string(i) + "] must have finite corners and a positive size");
}

void append_points(std::span<const PointSize> points, double global, std::vector<SizeSource>& sources) {
  for (const PointSize& wish : points)
    if (wish.size < global) sources.push_back({wish.point, wish.point, wish.point, wish.size});
}

/// The triangles that the sources alone call for, those beside segments included: refuses before a tree is built for
/// them. Sources of different origin may overlap, so a triangle is counted as a fifth of what it needs.
void check_sources(std::span<const SizeSource> sources, std::span<const SizeSource> refined, std::uint64_t max_memory) {
  double triangles = 0;
  for (const std::span<const SizeSource> list : {sources, refined})
    for (const SizeSource& source : list) {
      const double area = 0.5 * norm(cross(source.b - source.a, source.c - source.a));
      triangles += area * kTrianglesPerSquare / (source.size * source.size);
      if (source.b == source.c) triangles += 2 * distance(source.a, source.b) / source.size;
    }
  check_memory({.triangles = triangles, .tets = 0, .bytes = triangles * 500}, max_memory);
}

/// What a tree may take: a cell costs about 200 bytes while it is built.
std::size_t cell_limit(std::uint64_t max_memory) {
  constexpr std::uint64_t kBytesPerCell = 200, kMost = std::uint64_t{1} << 30;
  const std::uint64_t bytes = max_memory > 0 ? max_memory : available_memory();
  return static_cast<std::size_t>(bytes == 0 ? kMost : std::min(kMost, bytes / kBytesPerCell));
}

/// Whether anything at all is asked for beside the global size.
bool asks_for_more(const SizeTargets& targets, const SizeOptions& options,
                   std::span<const SizeRefinement> refinements) {
  const auto any_below = [&](const std::vector<double>& sizes) {
    return std::ranges::any_of(sizes, [&](double size) { return size < targets.global; });
  };
  return targets.curvature > 0 || !targets.wires.empty() || targets.proximity > 0 || options.callback ||
         !options.point_sizes.empty() || !refinements.empty() || any_below(targets.vertex) || any_below(targets.edge) ||
         any_below(targets.face);
}

/// A model with its facets, on the way to a size field.
struct Workpiece {
  const GeometricModel& model;
  const SizeOptions& options;
  const SizeTargets& targets;
  const std::vector<Tessellation>& facets;
  const FacetTree& tree;
};

std::vector<SizeSource> collect_sources(const Workpiece& piece, const SharedWork& work) {
  std::vector<std::vector<SizeSource>> lists(4);
  append_points(piece.options.point_sizes, piece.targets.global, lists[0]);
  lists[1] = edge_sources(piece.model, piece.targets, work);
  lists[2] = face_sources(piece.model, piece.targets, piece.facets, work);
  if (piece.targets.proximity > 0)
    lists[3] = proximity_sources(piece.model, piece.targets, piece.facets, piece.tree, work);
  return joined(lists);
}

/// What a build leaves to the next one, which has more refinements.
struct GrownTree {
  std::vector<SizeRefinement> refinements;
  OctreeFrame frame;
  OctreeLevels levels;
  CornerSizes corners;
};

/// The last trees that others may continue.
class GrownTrees {
 public:
  /// The one with the most of the first refinements, all of which it must have in this order; null where there is none.
  const GrownTree* find(std::span<const SizeRefinement> refinements) const {
    const GrownTree* best = nullptr;
    for (const GrownTree& tree : trees_) {
      if (tree.refinements.size() > refinements.size() ||
          !std::equal(tree.refinements.begin(), tree.refinements.end(), refinements.begin()))
        continue;
      if (best == nullptr || tree.refinements.size() > best->refinements.size()) best = &tree;
    }
    return best;
  }

  /// Keeps `tree`, and the one that it continues: with other refinements that one may be continued again.
  void add(GrownTree tree, const GrownTree* continued) {
    if (continued != nullptr && continued != &trees_.front()) std::swap(trees_.front(), trees_.back());
    trees_.resize(continued != nullptr ? 1 : 0);
    trees_.push_back(std::move(tree));
  }

 private:
  std::vector<GrownTree> trees_;  // two at most
};

std::vector<SizeSource> refinement_sources(std::span<const SizeRefinement> refinements, double global) {
  std::vector<SizeSource> sources;
  for (const auto& [corners, size] : refinements)
    if (size < global) sources.push_back({corners[0], corners[1], corners[2], size});
  return sources;
}

/// Sources of a model, as they are and in their tree.
struct ModelSources {
  std::vector<SizeSource> list;
  SourceTree tree;
};

OctreeFrame choose_frame(const Workpiece& piece, const ModelSources& sources, std::vector<SizeSource> refined,
                         double width_at_source) {
  refined.insert(refined.end(), sources.list.begin(), sources.list.end());
  return fit_frame(piece.model.bounding_box(), refined, width_at_source);
}

SizeField grow_tree(const Workpiece& piece, const ModelSources& sources, std::span<const SizeRefinement> refinements,
                    std::uint64_t max_memory, const SharedWork& work, GrownTrees& grown) {
  const double global = piece.targets.global, gradation = piece.targets.gradation;
  const std::vector<SizeSource> refined = refinement_sources(refinements, global);
  if (sources.list.empty() && refined.empty() && !piece.options.callback) return SizeField::uniform(global);
  check_sources(sources.list, refined, max_memory);
  const GrownTree none, *const continued = grown.find(refinements), &before = continued ? *continued : none;
  const SourceTree all_refined(refined, gradation, work.runner());
  const SourceTree latest(refinement_sources(refinements.subspan(before.refinements.size()), global), gradation,
                          work.runner());
  const TargetField field(piece.targets, {sources.tree, all_refined, latest}, piece.tree, piece.options.callback);
  GrownTree tree{{refinements.begin(), refinements.end()}, before.frame, {}, {}};
  if (!continued) tree.frame = choose_frame(piece, sources, refined, field.width_at_source());
  OctreeBuilder builder(field, tree.frame, piece.model.bounding_box(), cell_limit(max_memory), work);
  std::vector<OctreeBlock> blocks;
  SizeOctree octree = builder.build(before.levels, tree.levels, blocks);
  tree.corners = fill_corner_ratios(octree, blocks, field, before.corners, work);
  grown.add(std::move(tree), continued);
  return SizeField::from_octree(std::move(octree));
}

}  // namespace

/// What does not depend on refinements.
struct SizeFieldBuilder::State {
  State(const GeometricModel& given_model, const SizeOptions& given_options, const SharedWork& given_work,
        std::uint64_t given_memory, SmallWidth small, double given_refinement)
      : model(given_model),
        options(given_options),
        work(given_work),
        max_memory(given_memory),
        most_refinement(given_refinement),
        targets(resolve_sizes(model, options)) {
    targets.small = small;
    seeks_wires = most_refinement > 1 && targets.curvature <= 0 && targets.floor_is_default;
  }

  void facet_model() {
    if (tree) return;
    facets = facet_faces(model, source_tolerances(model, targets), work);
    tree.emplace(model, facets, work.runner());
    std::vector<SizeSource> found = collect_sources({model, options, targets, facets, *tree}, work);
    SourceTree source_tree(found, targets.gradation, work.runner());
    sources.emplace(std::move(found), std::move(source_tree));
  }

  // That wires may have, with the tets around them.
  double affordable_triangles() const {
    constexpr double kTetsPerTriangle = 2;
    const double elements = count_elements(estimate_least_mesh(model, options));
    return std::max(kFewElements, (most_elements(elements, most_refinement) - elements) / kTetsPerTriangle);
  }

  SizedModel build(std::span<const SizeRefinement> refinements) {
    check_refinements(refinements);
    // The model keeps them, and they are dear for splines. Where one fails, whoever asks first will say so.
    work.runner().for_each(model.topology().face_count(),
                           [&](std::size_t f) { tolerate_bad_geometry([&] { model.area(ModelFaceId(f)); }); });
    check_memory(surface_part(estimate_least_mesh(model, options)), max_memory);
    if (std::exchange(seeks_wires, false)) targets.wires = find_wires(model, targets, affordable_triangles(), work);
    if (!asks_for_more(targets, options, refinements)) {
      const SizeField uniform = SizeField::uniform(targets.global);
      return {uniform, estimate_mesh(model, uniform, work)};
    }
    facet_model();
    const SizeField sizes =
        grow_tree({model, options, targets, facets, *tree}, *sources, refinements, max_memory, work, grown)
            .kept_by(copy_of_machine(work.ranks()));
    SizedModel sized{sizes, estimate_mesh(model, sizes, facets, *tree, work)};
    if (work.rank_count() > 1) forget_facets();
    return sized;
  }

  // They are made again where they are asked for: with a surface beside them they would be most of what a rank has.
  void forget_facets() {
    facets = {};
    tree.reset();
    sources.reset();
    give_back_free_memory();
  }

  const GeometricModel& model;
  const SizeOptions& options;
  SharedWork work;
  std::uint64_t max_memory;
  double most_refinement;
  SizeTargets targets;
  bool seeks_wires;
  std::vector<Tessellation> facets;
  std::optional<FacetTree> tree;
  std::optional<ModelSources> sources;
  GrownTrees grown;
};

SizeFieldBuilder::SizeFieldBuilder(const GeometricModel& model, const SizeOptions& options, const SharedWork& work,
                                   std::uint64_t max_memory, SmallWidth small, double most_refinement)
    : state_(std::make_unique<State>(model, options, work, max_memory, small, most_refinement)) {}

SizeFieldBuilder::~SizeFieldBuilder() = default;

SizedModel SizeFieldBuilder::build(std::span<const SizeRefinement> refinements) { return state_->build(refinements); }

SizeField build_size_field(const GeometricModel& model, const SizeOptions& options,
                           std::span<const SizeRefinement> refinements, const TaskRunner& runner,
                           std::uint64_t max_memory) {
  return SizeFieldBuilder(model, options, runner, max_memory).build(refinements).sizes;
}

}  // namespace tetloom
