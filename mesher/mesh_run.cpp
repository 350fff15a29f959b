#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <numeric>
#include <optional>
#include <sstream>

#include "core/base/stage_clock.hpp"
#include "core/base/stopwatch.hpp"
#include "mesher/check_solids.hpp"
#include "mesher/complexes.hpp"
#include "mesher/failed_complexes.hpp"
#include "mesher/features/small_features.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/mesh_run_detail.hpp"
#include "mesher/sizing/build_size_field.hpp"
#include "mesher/sizing/misfits.hpp"
#include "mesher/sizing/model_facets.hpp"
#include "mesher/sizing/refinement_budget.hpp"
#include "mesher/surface/drop_faces.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "mesher/tets/quality_goals.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"
#include "threading/shared_work.hpp"

namespace tetloom {
namespace {

class MeshRun {
 public:
  MeshRun(const GeometricModel& model, const MeshOptions& options, const Host& host, const FillVolume& fill,
          Communicator* ranks)
      : model_(model),
        options_(options),
        work_(options.threads, host, ranks),
        runner_(work_.runner()),
        fill_(fill),
        on_several_ranks_(ranks && ranks->rank_count() > 1) {}

  MeshResult run() {
    try {
      run_stages();
    } catch (const Error& error) {
      if (error.code() == ErrorCode::InvalidArgument) throw;
      fail(error.diagnostic());
    } catch (const std::bad_alloc&) {
      fail({ErrorCode::OutOfMemory, "the memory is exhausted", {}, {}, {}});
    }
    return std::move(result_);
  }

 private:
  void fail(const Diagnostic& diagnostic) {
    result_.status = diagnostic.code == ErrorCode::Cancelled ? MeshStatus::Cancelled : MeshStatus::Failed;
    result_.errors.push_back(diagnostic);
  }

  void run_stages() {
    bool fits = false;
    const bool fills = !options_.surface_only && model_.topology().region_count() > 0;
    work_.together([&] {
      measure_model();
      fits = mesh_fitting_surface();
      if (fits && fills) check_solids();
    });
    if (!fits || (fills && !mesh_volume())) return;
    result_.status = MeshStatus::Ok;
    if (!failed_.empty()) finish_partial();
  }

  void finish_partial() {
    result_.status = MeshStatus::Failed;
    result_.is_partial = true;
    append(failed_.errors(), {});
    const std::vector<bool> missing = failed_.faces();
    const auto& region_to_faces = model_.topology().region_to_faces;
    for (std::size_t r = 0; r < region_to_faces.size(); ++r)
      if (!region_to_faces[r].empty() && missing[region_to_faces[r].front().value])
        result_.model_volume -= model_.volume(ModelRegionId(r));
  }

  // The model keeps what it has measured, and sizes ask for areas first. Solids of spline faces are dearest.
  void measure_model() {
    Stopwatch watch;
    runner_.begin_stage(Stage::SizeField, 0);
    const ModelTopology& topology = model_.topology();
    const std::size_t regions = topology.region_count();
    std::vector<double>& volumes = model_volumes_;
    volumes.resize(regions);
    runner_.for_each(regions + topology.face_count(), [&](std::size_t i) {
      if (i < regions) {
        volumes[i] = model_.volume(ModelRegionId(i));
      } else {
        tolerate_bad_geometry([&] { model_.area(ModelFaceId(i - regions)); });
      }
    });
    result_.model_volume = std::accumulate(volumes.begin(), volumes.end(), 0.0);
    result_.seconds.size_field += watch.lap();
  }

  enum class Refined { Done, TooLarge };

  struct Candidate {
    SizeField sizes = SizeField::uniform(1);
    double elements = 0;  ///< estimated: tets, or triangles where nothing is filled
    SurfaceMeshResult surface;
    std::vector<AbsorbedEntity> absorbed;
  };

  // Where the sizes do not fit they become smaller, and the surface is made anew: twice as small where triangles cross
  // because they are too coarse for the shape, and as small as it takes and the budget allows where it is narrow. What
  // still crosses after a few rounds crosses in the model. After the first round a few misfits are not worth another.
  bool mesh_fitting_surface() {
    const std::vector<std::uint32_t> complexes = find_complexes(model_.topology());
    const SmallWidth small = options_.keep_small_features
                                 ? SmallWidth{}
                                 : SmallWidth{options_.small_feature, kSmallFeature, small_face_limits(model_)};
    SizeFieldBuilder sizing(model_, options_.sizes, work_, options_.max_memory, small);
    if (!options_.keep_small_features) features_.emplace(model_, options_, build_asked_sizes());
    std::vector<SizeRefinement> refinements;
    SizedModel sized = build_sizes(sizing, refinements);
    first_sizes_ = sized.sizes;
    first_elements_ = count_elements(sized.estimate);
    std::optional<Candidate> good;
    constexpr int kMostRounds = 6, kMostFittingRounds = 3;
    for (int round = 0;; ++round) {
      Candidate candidate;
      work_.together([&] { candidate = make_surface(sized); });
      set_aside(candidate.surface);
      Stopwatch watch;
      const std::vector<TriangleIntersection> all_hits = settle_features(candidate, complexes);
      const std::vector<TriangleIntersection> hits = those_of_solids(all_hits, candidate.surface.mesh);
      const bool fits = !options_.refine_surface || round >= kMostFittingRounds || !candidate.surface.errors.empty();
      std::vector<Misfit> misfits = fits ? std::vector<Misfit>{} : find_misfits(candidate);
      if (round > 0 && hits.empty() && are_few(misfits, candidate.surface.mesh)) misfits.clear();
      result_.seconds.surface += watch.lap();
      if (!candidate.surface.errors.empty()) return reject(std::move(candidate));
      const bool done = hits.empty() && misfits.empty();
      if (done && all_hits.empty()) return accept(std::move(candidate), Refined::Done);
      if (done || !options_.refine_surface || round == kMostRounds)
        return judge_crossings(std::move(candidate), all_hits);
      try {
        work_.together([&] { sized = refine(candidate, hits, misfits, sizing, refinements); });
      } catch (const Error& error) {
        if (error.code() == ErrorCode::OutOfMemory) note_wishes(misfits, candidate.surface.mesh, round + 1);
        if (hits.empty()) good = std::move(candidate);
        if (error.code() != ErrorCode::OutOfMemory || !good) throw;
        return accept(std::move(*good), Refined::TooLarge);
      }
      if (hits.empty() && !refined_) return accept(std::move(candidate), Refined::Done);
      result_.refinement.rounds = round + 1;
      if (hits.empty()) good = std::move(candidate);
    }
  }

  static bool are_few(const std::vector<Misfit>& misfits, const Mesh& mesh) {
    constexpr double kFew = 1e-3;  // of the triangles
    return static_cast<double>(misfits.size()) < kFew * static_cast<double>(mesh.tri_to_vert.size());
  }

  bool bounds_region(std::uint32_t face) const {
    const FaceSides& sides = model_.topology().face_to_sides[face];
    return sides.front.valid() || sides.back.valid();
  }

  // Crossings of a face of a solid; sheets may cross.
  std::vector<TriangleIntersection> those_of_solids(std::vector<TriangleIntersection> hits, const Mesh& mesh) const {
    std::erase_if(hits, [&](const TriangleIntersection& hit) {
      return !bounds_region(mesh.tri_to_entity[hit.first]) && !bounds_region(mesh.tri_to_entity[hit.second]);
    });
    return hits;
  }

  // The complexes that failed go out of the surface, as far as the host wants the others.
  void set_aside(SurfaceMeshResult& surface) {
    if (options_.keep_going && !surface.errors.empty() && failed_.take(surface.errors)) surface.errors.clear();
    if (!failed_.empty()) drop_faces(failed_.faces(), surface.mesh);
  }

  // What was wanted of a round for which there is too little memory.
  void note_wishes(const std::vector<Misfit>& misfits, const Mesh& mesh, int rounds) {
    for (const Misfit& misfit : misfits) note(misfit, mesh);
    result_.refinement.narrow_places += misfits.size();
    result_.refinement.rounds = rounds;
  }

  // Sizes with what the surface calls for: all crossings, and narrow places as far as the budget goes. What narrow
  // places cost is estimated, and known when the sizes are there: they are chosen again where it was too much.
  SizedModel refine(const Candidate& candidate, const std::vector<TriangleIntersection>& hits,
                    const std::vector<Misfit>& misfits, SizeFieldBuilder& sizing,
                    std::vector<SizeRefinement>& refinements) {
    const Mesh& mesh = candidate.surface.mesh;
    for (const TriangleIntersection& hit : hits) refine_at(hit, mesh, refinements);
    result_.refinement.crossings += hits.size();
    const double allowed = std::max(0.0, options_.most_refinement * first_elements_ - candidate.elements);
    double budget = allowed;
    constexpr int kMostTries = 6;
    constexpr double kOver = 1.1, kUnder = 0.9;
    for (int tries = 1;; ++tries) {
      const bool give_up = tries == kMostTries;
      const AffordableMisfits chosen = choose_affordable(misfits, mesh, candidate.sizes, give_up ? 0 : budget);
      std::vector<SizeRefinement> more = refinements;
      for (const Misfit& misfit : chosen.refined) add_refinement(misfit, mesh, more);
      refined_ = !chosen.refined.empty() || !hits.empty();
      if (!refined_) return {};
      SizedModel sized = build_sizes(sizing, more);
      const double added = count_elements(sized.estimate) - candidate.elements;
      if (added > kOver * allowed && !chosen.refined.empty()) {
        budget = kUnder * chosen.cost * allowed / added;
        continue;
      }
      for (const Misfit& misfit : chosen.refined) note(misfit, mesh);
      result_.refinement.narrow_places += chosen.refined.size();
      result_.refinement.left = chosen.left;
      refinements = std::move(more);
      return sized;
    }
  }

  // Without those from curvature and proximity.
  SizeField build_asked_sizes() const {
    SizeOptions asked = options_.sizes;
    asked.curvature = asked.proximity = 0;
    return SizeFieldBuilder(model_, asked, work_, options_.max_memory).build({}).sizes;
  }

  // Eliminates small features from the surface, and returns where it crosses itself afterwards. Where it does so at a
  // place where something was eliminated, or where a region would lose too much of its volume, that is undone.
  std::vector<TriangleIntersection> settle_features(Candidate& candidate, const std::vector<std::uint32_t>& complexes) {
    if (!features_ || !candidate.surface.errors.empty()) return find_intersections(candidate.surface.mesh, complexes);
    const Mesh given = std::move(candidate.surface.mesh);
    constexpr int kMostTries = 6;
    for (int tries = 1;; ++tries) {
      EliminationResult eliminated = features_->eliminate(given, candidate.sizes, runner_);
      if (tries < kMostTries && features_->spare_regions(given, eliminated)) continue;
      const Mesh& mesh = eliminated.mesh ? *eliminated.mesh : given;
      std::vector<TriangleIntersection> hits = find_intersections(mesh, complexes);
      if (tries < kMostTries && features_->keep_where_crossing(eliminated, hits)) continue;
      candidate.surface.mesh = eliminated.mesh ? std::move(*eliminated.mesh) : given;
      candidate.absorbed = std::move(eliminated.absorbed);
      return hits;
    }
  }

  SizedModel build_sizes(SizeFieldBuilder& sizing, const std::vector<SizeRefinement>& refinements) {
    Stopwatch watch;
    runner_.begin_stage(Stage::SizeField, 0);
    SizedModel sized = sizing.build(refinements);
    check_memory(options_.surface_only ? surface_part(sized.estimate) : sized.estimate, options_.max_memory);
    result_.seconds.size_field += watch.lap();
    return sized;
  }

  Candidate make_surface(const SizedModel& sized) {
    Stopwatch watch;
    Candidate candidate{sized.sizes, count_elements(sized.estimate), mesh_surface(model_, sized.sizes, work_), {}};
    result_.seconds.surface += watch.lap();
    return candidate;
  }

  // Tets, or triangles where nothing is filled. A wall thinner than the size has one and a half tets per triangle.
  double count_elements(const MeshEstimate& estimate) const {
    const bool fills = !options_.surface_only && model_.topology().region_count() > 0;
    constexpr double kTetsPerTriangleOfWalls = 1.5;
    return fills ? std::max(estimate.tets, kTetsPerTriangleOfWalls * estimate.triangles) : estimate.triangles;
  }

  std::vector<Misfit> find_misfits(const Candidate& candidate) const {
    const Mesh& mesh = candidate.surface.mesh;
    const intersection::TriangleTree tree(mesh.points, mesh.tri_to_vert, runner_);
    // By default no smaller than what fits a feature that is just not eliminated.
    const auto floor = [&](const Vec3& x) {
      if (options_.sizes.min_size > 0) return options_.sizes.min_size;
      constexpr double kLeastShare = 0.1;
      const double first = first_sizes_.size_at(x), least = kLeastShare * first;
      return features_ ? std::max(least, features_->tolerance_at(x, first, {}) / kLeastWidth) : least;
    };
    return tetloom::find_misfits(mesh, model_.topology(), candidate.sizes, floor, tree, work_);
  }

  std::vector<TriangleIntersection> find_intersections(const Mesh& mesh,
                                                       const std::vector<std::uint32_t>& complexes) const {
    runner_.begin_stage(Stage::Intersections, mesh.tri_to_vert.size());
    const intersection::TriangleTree tree(mesh.points, mesh.tri_to_vert, runner_);
    std::vector<std::uint32_t> groups(mesh.tri_to_vert.size());
    runner_.for_blocks(groups.size(), std::size_t{1} << 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t t = begin; t < end; ++t) groups[t] = complexes[mesh.tri_to_entity[t]];
    });
    IntersectionSearch search{mesh.points, mesh.tri_to_vert, groups};
    search.tells_progress = true;
    return find_self_intersections(search, tree, work_);
  }

  static double longest_edge(const Mesh& mesh, std::uint32_t tri) {
    const auto& [a, b, c] = mesh.tri_to_vert[tri];
    return std::max({distance(mesh.points[a], mesh.points[b]), distance(mesh.points[b], mesh.points[c]),
                     distance(mesh.points[c], mesh.points[a])});
  }

  void refine_at(const TriangleIntersection& hit, const Mesh& mesh, std::vector<SizeRefinement>& refinements) {
    const double length = std::max(longest_edge(mesh, hit.first), longest_edge(mesh, hit.second));
    if (!(length > 0)) return;  // a triangle of one point: no size makes it better
    refinements.push_back({{hit.point, hit.point, hit.point}, 0.5 * length});
    note(refinements.back(), {hit.first, hit.second}, mesh);
  }

  static void add_refinement(const Misfit& misfit, const Mesh& mesh, std::vector<SizeRefinement>& refinements) {
    const auto& [a, b, c] = mesh.tri_to_vert[misfit.triangle];
    refinements.push_back({{mesh.points[a], mesh.points[b], mesh.points[c]}, misfit.size});
  }

  void note(const Misfit& misfit, const Mesh& mesh) {
    std::vector<SizeRefinement> refinement;
    add_refinement(misfit, mesh, refinement);
    note(refinement.back(), {misfit.triangle}, mesh);
  }

  void note(const SizeRefinement& refinement, std::initializer_list<std::uint32_t> triangles, const Mesh& mesh) {
    for (const std::uint32_t triangle : triangles) ++refined_faces_[mesh.tri_to_entity[triangle]];
    double& smallest = result_.refinement.smallest_size;
    if (smallest > 0 && smallest <= refinement.size) return;
    smallest = refinement.size;
    const auto& [a, b, c] = refinement.corners;
    smallest_place_ = (1.0 / 3) * (a + b + c);
  }

  Diagnostic describe_refinement(Refined refined) const {
    std::ostringstream message;
    message << "the size asked for does not fit everywhere (" << result_.refinement.narrow_places
            << " triangles at walls, faces or edges narrower than 0.4 of it, " << result_.refinement.crossings
            << " crossings): ";
    if (refined == Refined::Done)
      message << "it was made smaller there, down to " << result_.refinement.smallest_size;
    else
      message << "there is too little memory for sizes that do";
    std::vector<std::pair<std::size_t, std::uint32_t>> most;
    for (const auto& [face, count] : refined_faces_) most.push_back({count, face});
    std::ranges::sort(most, [](const auto& s, const auto& t) {
      return s.first != t.first ? s.first > t.first : s.second < t.second;
    });
    Diagnostic diagnostic{ErrorCode::SizeReduced, message.str(), {}, smallest_place_, {}};
    for (const auto& [count, face] : most)
      diagnostic.entities.push_back({{2, face}, model_.attributes({2, face}).name});
    return diagnostic;
  }

  bool reject(Candidate&& candidate) {
    append(candidate.surface.errors, candidate.surface.warnings);
    take(std::move(candidate));
    result_.status = MeshStatus::Failed;
    return false;
  }

  bool accept(Candidate&& candidate, Refined refined) {
    append({}, candidate.surface.warnings);
    if (result_.refinement.rounds > 0) result_.warnings.push_back(describe_refinement(refined));
    take(std::move(candidate));
    return true;
  }

  void take(Candidate&& candidate) {
    result_.mesh = std::move(candidate.surface.mesh);
    result_.sizes = candidate.sizes;
    result_.absorbed = std::move(candidate.absorbed);
  }

  // Crossings spoil a solid and no sheet.
  bool judge_crossings(Candidate&& candidate, const std::vector<TriangleIntersection>& hits) {
    const std::vector<Diagnostic> found = describe_intersections(hits, {candidate.surface.mesh.tri_to_entity, &model_});
    const auto spoils = [&](const NamedEntity& entity) {
      return entity.entity.dim == 2 && bounds_region(entity.entity.index);
    };
    std::vector<Diagnostic> errors, warnings = candidate.surface.warnings;
    for (const Diagnostic& diagnostic : found) {
      const bool fatal = std::any_of(diagnostic.entities.begin(), diagnostic.entities.end(), spoils);
      (fatal && !options_.surface_only ? errors : warnings).push_back(diagnostic);
    }
    if (options_.keep_going && !errors.empty() && failed_.take(errors)) {
      errors.clear();
      set_aside(candidate.surface);
    }
    append(errors, warnings);
    take(std::move(candidate));
    if (!errors.empty()) result_.status = MeshStatus::Failed;
    return errors.empty();
  }

  void append(const std::vector<Diagnostic>& errors, const std::vector<Diagnostic>& warnings) {
    result_.errors.insert(result_.errors.end(), errors.begin(), errors.end());
    result_.warnings.insert(result_.warnings.end(), warnings.begin(), warnings.end());
  }

  void check_solids() {
    Stopwatch watch;
    const MeshedModel meshed{model_, result_.mesh, result_.sizes};
    append({}, check_volumes(meshed, model_volumes_));
    append({}, check_overlaps(meshed, runner_));
    result_.seconds.volume += watch.lap();
  }

  // What one rank cannot fill no other one knows of before the end, so ranks give up together.
  bool mesh_volume() {
    for (;;) {
      std::vector<Diagnostic> errors = fill_volume();
      if (errors.empty()) return true;
      const bool others = options_.keep_going && !on_several_ranks_ && !runner_.cancelled() && failed_.take(errors);
      if (!others) {
        append(errors, {});
        result_.status = MeshStatus::Failed;
        return false;
      }
      drop_faces(failed_.faces(), result_.mesh);
    }
  }

  std::vector<Diagnostic> fill_volume() {
    Stopwatch watch;
    const Mesh& mesh = result_.mesh;
    std::vector<FaceSides> sides(mesh.tri_to_vert.size());
    for (std::size_t t = 0; t < sides.size(); ++t) sides[t] = model_.topology().face_to_sides[mesh.tri_to_entity[t]];
    const VolumeInput input{mesh.points,          mesh.tri_to_vert, sides, mesh.tri_to_entity, &model_, &result_.sizes,
                            mesh.point_to_entity, mesh.edge_to_vert};
    const VolumeOptions options{options_.volume_worker, options_.worker_only, options_.improve_surface,
                                options_.max_memory,    options_.goals,       options_.lattice,
                                options_.tets_per_part, options_.trace};
    FillingReport filling = fill_(input, options, runner_, result_.mesh);
    result_.seconds.volume += watch.lap();
    result_.filling = std::move(filling.figures);
    append({}, filling.warnings);
    return filling.errors;
  }

  const GeometricModel& model_;
  const MeshOptions& options_;
  const SharedWork work_;
  const TaskRunner& runner_;
  const FillVolume& fill_;
  const bool on_several_ranks_;
  MeshResult result_;
  std::vector<double> model_volumes_;  // per region
  std::optional<SmallFeatures> features_;
  FailedComplexes failed_{model_};
  SizeField first_sizes_ = SizeField::uniform(1);  // before any refinement
  double first_elements_ = 0;                      // the elements estimated for those
  bool refined_ = false;                           // in the last round
  std::map<std::uint32_t, std::size_t> refined_faces_;
  Vec3 smallest_place_;
};

Host with_clock(const Host& host, StageClock& clock) {
  Host timed = host;
  timed.progress = [&clock, progress = host.progress](const ProgressEvent& event) {
    clock.enter(event.stage);
    return !progress || progress(event);
  };
  return timed;
}

// A stage that was left by an exception has not been counted.
void count_unfinished_stage(const StageClock& clock, StageSeconds& seconds) {
  seconds.size_field = std::max(seconds.size_field, clock.seconds(Stage::SizeField));
  seconds.surface = std::max(
      seconds.surface, clock.seconds(Stage::Edges) + clock.seconds(Stage::Faces) + clock.seconds(Stage::Intersections));
  seconds.volume = std::max(seconds.volume, clock.seconds(Stage::Volume));
}

}  // namespace

MeshResult run_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host, const FillVolume& fill,
                    Communicator* ranks) {
  check_goals(options.goals);
  if (options.parts < 0) throw Error(ErrorCode::InvalidArgument, "the number of parts must not be negative");
  if (!(options.tets_per_part >= 0))
    throw Error(ErrorCode::InvalidArgument, "the tets of a part must not be fewer than none");
  if (!(options.small_feature >= 0 && std::isfinite(options.small_feature)))
    throw Error(ErrorCode::InvalidArgument, "small_feature must be positive and finite (or 0 to leave it unset)");
  if (!(options.most_refinement >= 1)) throw Error(ErrorCode::InvalidArgument, "most_refinement must be at least 1");
  StageClock clock;
  MeshResult result = MeshRun(model, options, with_clock(host, clock), fill, ranks).run();
  if (result.status != MeshStatus::Ok) count_unfinished_stage(clock, result.seconds);
  return result;
}

}  // namespace tetloom
