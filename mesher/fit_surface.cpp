#include "mesher/fit_surface.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/stopwatch.hpp"
#include "mesher/complexes.hpp"
#include "mesher/intersection/model_crossings.hpp"
#include "mesher/intersection/pinched_edges.hpp"
#include "mesher/intersection/skins.hpp"
#include "mesher/sizing/refinement_budget.hpp"
#include "mesher/surface/drop_faces.hpp"
#include "mesher/volume/volume_mesher.hpp"

namespace tetloom {
namespace {

SmallWidth small_width(const GeometricModel& model, const MeshOptions& options) {
  if (options.keep_small_features) return {};
  return {options.small_feature, kSmallFeature, small_face_limits(model)};
}

}  // namespace

SurfaceFitter::SurfaceFitter(const GeometricModel& model, const MeshOptions& options, const SharedWork& work,
                             FailedComplexes& failed, MeshResult& result)
    : model_(model),
      options_(options),
      work_(work),
      runner_(work.runner()),
      failed_(failed),
      result_(result),
      complexes_(find_complexes(model.topology())),
      sizing_(model, options.sizes, work, options.max_memory, small_width(model, options),
              options.refine_surface ? options.most_refinement : 1),
      mesher_(model, work) {}

bool SurfaceFitter::run() {
  if (!options_.keep_small_features) features_.emplace(model_, options_, build_asked_sizes());
  SizedModel sized = build_sizes({});
  first_sizes_ = sized.sizes;
  first_elements_ = count_elements(sized.estimate);
  std::optional<Candidate> good;
  for (SurfaceRounds rounds(options_.refine_surface);;) {
    Candidate candidate = make_candidate(sized);
    if (!candidate.surface.errors.empty()) return reject(std::move(candidate));
    if (rounds.count() == 0) {
      if (options_.stop_where_model_crosses && crosses_in_model(candidate)) return stop_early(std::move(candidate));
      if (has_skins(candidate)) return judge_crossings(std::move(candidate));
    }
    const NarrowPlaces narrow = find_narrow_places(candidate, rounds);
    switch (rounds.decide(count_round(candidate, narrow))) {
      case NextStep::Accept: return accept(std::move(candidate), true);
      case NextStep::AcceptBefore: return accept(std::move(*good), true);
      case NextStep::Judge: return judge_crossings(std::move(candidate));
      case NextStep::KeepFacets:
        if (!keep_facets(candidate)) return judge_crossings(std::move(candidate));
        continue;
      case NextStep::Refine: break;
    }
    const bool crosses = !candidate.solid_hits.empty();
    try {
      if (!refine_together(candidate, narrow, sized)) return accept(std::move(candidate), true);
    } catch (const Error& error) {
      if (!crosses) good = std::move(candidate);
      if (error.code() != ErrorCode::OutOfMemory || !good) throw;
      for (const Misfit& misfit : narrow.misfits) log_.note(misfit, good->surface.mesh);
      result_.refinement.rounds = rounds.count();
      return accept(std::move(*good), false);
    }
    result_.refinement.rounds = rounds.count();
    if (!crosses) good = std::move(candidate);
  }
}

SizedModel SurfaceFitter::build_sizes(const std::vector<SizeRefinement>& refinements) {
  Stopwatch watch;
  runner_.begin_stage(Stage::SizeField, 0);
  SizedModel sized = sizing_.build(refinements);
  check_memory(options_.surface_only ? surface_part(sized.estimate) : sized.estimate, options_.max_memory);
  result_.seconds.size_field += watch.lap();
  return sized;
}

// Without those from curvature and proximity.
SizeField SurfaceFitter::build_asked_sizes() const {
  SizeOptions asked = options_.sizes;
  asked.curvature = asked.proximity = 0;
  return SizeFieldBuilder(model_, asked, work_, options_.max_memory).build({}).sizes;
}

// Tets, or triangles where nothing is filled.
double SurfaceFitter::count_elements(const MeshEstimate& estimate) const {
  const bool fills = !options_.surface_only && model_.topology().region_count() > 0;
  return fills ? tetloom::count_elements(estimate) : estimate.triangles;
}

SurfaceFitter::Candidate SurfaceFitter::make_candidate(const SizedModel& sized) {
  Stopwatch watch;
  Candidate candidate;
  candidate.sizes = sized.sizes;
  candidate.elements = count_elements(sized.estimate);
  work_.together([&] { candidate.surface = mesher_.mesh(sized.sizes); });
  set_aside(candidate.surface);
  if (candidate.surface.errors.empty()) settle_features(candidate);
  result_.seconds.surface += watch.lap();
  return candidate;
}

// The complexes that failed go out of the surface, as far as the host wants the others.
void SurfaceFitter::set_aside(SurfaceMeshResult& surface) {
  if (options_.keep_going && !surface.errors.empty() && failed_.take(surface.errors)) surface.errors.clear();
  if (!failed_.empty()) drop_faces(failed_.faces(), surface.mesh);
}

// Eliminates small features from the surface, and finds where it crosses itself afterwards. Where it does so at a place
// where something was eliminated, or where a region would lose too much of its volume, that is undone.
void SurfaceFitter::settle_features(Candidate& candidate) {
  if (!features_) return find_crossings(candidate);
  Mesh given = std::move(candidate.surface.mesh);
  constexpr int kMostTries = 6;  // at places that cross; those at regions end by themselves
  for (int tries = 1;; ++tries) {
    EliminationResult eliminated = features_->eliminate(given, candidate.sizes, runner_);
    if (features_->spare_regions(given, eliminated)) continue;
    const bool has_changed = eliminated.mesh.has_value();
    candidate.surface.mesh = std::move(has_changed ? *eliminated.mesh : given);  // then this is the last try
    find_crossings(candidate);
    if (has_changed && tries < kMostTries &&
        features_->keep_where_crossing(candidate.surface.mesh, eliminated.changed, candidate.all_hits))
      continue;
    candidate.absorbed = std::move(eliminated.absorbed);
    return;
  }
}

void SurfaceFitter::find_crossings(Candidate& candidate) {
  const Mesh& mesh = candidate.surface.mesh;
  runner_.begin_stage(Stage::Intersections, mesh.tri_to_vert.size());
  candidate.tree.emplace(mesh.points, mesh.tri_to_vert, work_);
  candidate.tri_is_new = embedded_.find_new(mesh, runner_);
  std::vector<std::uint32_t> groups(mesh.tri_to_vert.size());
  runner_.for_blocks(groups.size(), std::size_t{1} << 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) groups[t] = complexes_[mesh.tri_to_entity[t]];
  });
  IntersectionSearch search{mesh.points, mesh.tri_to_vert, groups};
  search.tri_is_new = candidate.tri_is_new;
  search.tells_progress = true;
  candidate.all_hits = find_self_intersections(search, *candidate.tree, work_);
  const std::vector<TriangleIntersection> pinched = find_pinched_edges(mesh, work_);
  candidate.all_hits.insert(candidate.all_hits.end(), pinched.begin(), pinched.end());
  candidate.solid_hits = those_of_solids(candidate.all_hits, mesh);
}

// Leaves only the crossings that no size helps, where there are any.
bool SurfaceFitter::crosses_in_model(Candidate& candidate) {
  if (options_.surface_only) return false;
  Stopwatch watch;
  std::vector<TriangleIntersection> found =
      find_model_crossings(candidate.solid_hits, candidate.surface.mesh, model_, runner_);
  result_.seconds.surface += watch.lap();
  if (found.empty()) return false;
  candidate.all_hits = candidate.solid_hits = std::move(found);
  return true;
}

// Adds what has no thickness to the crossings: smaller sizes do not help. Only what would leave nothing but flat tets
// is looked for, however coarse the model's tolerance is.
bool SurfaceFitter::has_skins(Candidate& candidate) const {
  if (options_.surface_only) return false;
  constexpr double kMostOfSize = 1e-3;
  const double most = kMostOfSize * candidate.sizes.smallest();
  std::vector<double> tolerances(model_.topology().face_count());
  for (std::size_t f = 0; f < tolerances.size(); ++f)
    tolerances[f] = std::min(most, model_.attributes(ModelFaceId(f)).tolerance);
  const std::vector<TriangleIntersection> skins =
      find_skins(candidate.surface.mesh, tolerances, *candidate.tree, work_);
  candidate.all_hits.insert(candidate.all_hits.end(), skins.begin(), skins.end());
  candidate.solid_hits.insert(candidate.solid_hits.end(), skins.begin(), skins.end());
  return !skins.empty();
}

// Has the facets stay as they are where triangles cross and the model does not, in larger and larger balls. Whether
// anything changes.
bool SurfaceFitter::keep_facets(const Candidate& candidate) {
  constexpr int kMostRounds = 4;
  const Mesh& mesh = candidate.surface.mesh;
  if (kept_rounds_ == kMostRounds) return false;
  Stopwatch watch;
  const auto is_of_facets = [&](std::uint32_t tri) {
    const auto geometry = model_.face_geometry(ModelFaceId(mesh.tri_to_entity[tri]));
    return geometry->parametrization() == Parametrization::Piecewise;
  };
  std::vector<KeptPlace> places;
  for (const TriangleIntersection& hit : candidate.solid_hits) {
    if (!is_of_facets(hit.first) || !is_of_facets(hit.second)) continue;
    const double length = longest_edge(mesh, hit);
    places.push_back({hit.point, std::ldexp(length, kept_rounds_)});
  }
  ++kept_rounds_;
  const bool helps = !places.empty() && find_model_crossings(candidate.solid_hits, mesh, model_, runner_).empty() &&
                     mesher_.keep_facets(places);
  result_.seconds.surface += watch.lap();
  return helps;
}

SurfaceFitter::NarrowPlaces SurfaceFitter::find_narrow_places(const Candidate& candidate, const SurfaceRounds& rounds) {
  Stopwatch watch;
  NarrowPlaces narrow;
  if (rounds.seeks_misfits()) {
    narrow.misfits = find_misfits(candidate);
    narrow.takes_back = drop_contacts(candidate, narrow.misfits);
  }
  if (rounds.count() > 0 && candidate.solid_hits.empty() &&
      are_negligible(narrow.misfits, candidate.surface.mesh, candidate.sizes, rounds.last().misfits))
    narrow.misfits.clear();
  result_.seconds.surface += watch.lap();
  return narrow;
}

SurfaceRound SurfaceFitter::count_round(const Candidate& candidate, const NarrowPlaces& narrow) {
  const std::size_t of_solids = candidate.solid_hits.size();
  return {candidate.surface.mesh.tri_to_vert.size(), of_solids, candidate.all_hits.size() - of_solids,
          narrow.misfits.size(), narrow.takes_back};
}

std::vector<Misfit> SurfaceFitter::find_misfits(const Candidate& candidate) const {
  std::vector<std::uint8_t> face_has_layers;
  if (!options_.layers.walls.empty()) face_has_layers.resize(model_.topology().face_count());
  for (const WallLayers& wall : options_.layers.walls) face_has_layers[wall.face.value] = 1;
  return tetloom::find_misfits(
      candidate.surface.mesh, model_.topology(), candidate.sizes, [&](const Vec3& x) { return floor_at(x); },
      *candidate.tree, work_, candidate.tri_is_new, face_has_layers);
}

// By default no smaller than what fits a feature that is just not eliminated, but where angles are very small.
SizeFloor SurfaceFitter::floor_at(const Vec3& x) const {
  if (options_.sizes.min_size > 0) return {options_.sizes.min_size, options_.sizes.min_size};
  constexpr double kLeastShare = 0.1, kSevereShare = 0.02;
  const double first = first_sizes_.size_at(x), least = kLeastShare * first;
  const double usual = features_ ? std::max(least, features_->tolerance_at(x, first, {}) / kLeastWidth) : least;
  return {usual, is_in_contact(x) ? usual : kSevereShare * usual};
}

bool SurfaceFitter::is_in_contact(const Vec3& x) const {
  return std::ranges::any_of(contacts_, [&](const Contact& c) { return distance(x, c.center) < c.radius; });
}

// Where walls touch, what is narrow is as narrow again at every size: there would only be more poor tets. Such are
// places that no size fits, and those that ask for far more once they have less than the usual floor. Takes these
// misfits out and what was refined for the like before. Returns whether anything was.
bool SurfaceFitter::drop_contacts(const Candidate& candidate, std::vector<Misfit>& misfits) {
  constexpr double kFarLess = 0.3, kReach = 2, kApart = 0.5;  // the last two: in first sizes, and in radii
  const Mesh& mesh = candidate.surface.mesh;
  const auto place_of = [](const std::array<Vec3, 3>& x) { return (1.0 / 3) * (x[0] + x[1] + x[2]); };
  const std::size_t before = contacts_.size();
  for (const Misfit& misfit : misfits) {
    const Vec3 x = place_of(refinement_for(misfit, mesh).corners);
    const double present = candidate.sizes.size_at(x);
    const bool was_refined = present < std::min(floor_at(x).usual, kWorthwhileSize * first_sizes_.size_at(x));
    if (misfit.size > 0 && !(was_refined && misfit.size < kFarLess * present)) continue;
    const bool is_known =
        std::ranges::any_of(contacts_, [&](const Contact& c) { return distance(x, c.center) < kApart * c.radius; });
    if (!is_known) contacts_.push_back({x, kReach * first_sizes_.size_at(x)});
  }
  if (contacts_.empty()) return false;
  std::erase_if(misfits, [&](const Misfit& misfit) {
    const Vec3 x = place_of(refinement_for(misfit, mesh).corners);
    return misfit.size == 0 || (misfit.size < floor_at(x).usual && is_in_contact(x));
  });
  return contacts_.size() > before && log_.take_back([&](const SizeRefinement& refinement) {
    const Vec3 x = place_of(refinement.corners);
    return refinement.size < floor_at(x).usual && is_in_contact(x);
  });
}

std::vector<TriangleIntersection> SurfaceFitter::those_of_solids(std::vector<TriangleIntersection> hits,
                                                                 const Mesh& mesh) const {
  std::erase_if(hits, [&](const TriangleIntersection& hit) {
    return !bounds_region(mesh.tri_to_entity[hit.first]) && !bounds_region(mesh.tri_to_entity[hit.second]);
  });
  return hits;
}

bool SurfaceFitter::bounds_region(std::uint32_t face) const {
  const FaceSides& sides = model_.topology().face_to_sides[face];
  return sides.front.valid() || sides.back.valid();
}

// The sizes of the next round; false where nothing is refined.
bool SurfaceFitter::refine_together(const Candidate& candidate, const NarrowPlaces& narrow, SizedModel& sized) {
  bool is_refined = false;
  work_.together([&] {
    std::optional<SizedModel> finer = refine(candidate, narrow);
    is_refined = finer.has_value();
    if (is_refined) sized = std::move(*finer);
  });
  if (!is_refined) return false;
  Stopwatch watch;
  embedded_ = candidate.all_hits.empty() ? KnownTriangles(candidate.surface.mesh, runner_) : KnownTriangles();
  result_.seconds.surface += watch.lap();
  return true;
}

// Sizes with what the surface calls for: all crossings, and narrow places as far as the budget goes. What narrow places
// cost is estimated, and known when the sizes are there: they are chosen again where it was too much. None where
// nothing is refined.
std::optional<SizedModel> SurfaceFitter::refine(const Candidate& candidate, const NarrowPlaces& narrow) {
  const Mesh& mesh = candidate.surface.mesh;
  for (const TriangleIntersection& hit : candidate.solid_hits) refine_at(hit, mesh);
  result_.refinement.crossings += candidate.solid_hits.size();
  const double most = most_elements(first_elements_, options_.most_refinement);
  const double allowed = std::max(0.0, most - candidate.elements);
  double budget = allowed;
  constexpr int kMostTries = 6;
  constexpr double kOver = 1.1, kUnder = 0.9;
  for (int tries = 1;; ++tries) {
    const bool give_up = tries == kMostTries;
    const AffordableMisfits chosen = choose_affordable(narrow.misfits, mesh, candidate.sizes, give_up ? 0 : budget);
    if (chosen.refined.empty() && candidate.solid_hits.empty() && !narrow.takes_back) return {};
    std::vector<SizeRefinement> more = log_.refinements();
    for (const Misfit& misfit : chosen.refined) more.push_back(refinement_for(misfit, mesh));
    SizedModel sized = build_sizes(more);
    const double added = count_elements(sized.estimate) - candidate.elements;
    if (added > kOver * allowed && !chosen.refined.empty()) {
      budget = kUnder * chosen.cost * allowed / added;
      continue;
    }
    for (const Misfit& misfit : chosen.refined) log_.note(misfit, mesh);
    result_.refinement.left = chosen.left;
    return sized;
  }
}

void SurfaceFitter::refine_at(const TriangleIntersection& hit, const Mesh& mesh) {
  const double length = longest_edge(mesh, hit);
  if (!(length > 0)) return;  // a triangle of one point: no size makes it better
  log_.note({{hit.point, hit.point, hit.point}, 0.5 * length}, {hit.first, hit.second}, mesh);
}

bool SurfaceFitter::reject(Candidate&& candidate) {
  append(candidate.surface.errors, candidate.surface.warnings);
  take(std::move(candidate));
  result_.status = MeshStatus::Failed;
  return false;
}

bool SurfaceFitter::accept(Candidate&& candidate, bool is_fine_enough) {
  append({}, candidate.surface.warnings);
  take(std::move(candidate));
  if (log_.smallest_size() > 0) result_.warnings.push_back(log_.describe(result_.refinement, is_fine_enough, model_));
  return true;
}

bool SurfaceFitter::stop_early(Candidate&& candidate) {
  append(describe_intersections(candidate.solid_hits, {candidate.surface.mesh.tri_to_entity, &model_}), {});
  take(std::move(candidate));
  result_.status = MeshStatus::Failed;
  result_.stopped_early = true;
  return false;
}

// Crossings spoil a solid and no sheet.
bool SurfaceFitter::judge_crossings(Candidate&& candidate) {
  const std::vector<Diagnostic> found =
      describe_intersections(candidate.all_hits, {candidate.surface.mesh.tri_to_entity, &model_});
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

void SurfaceFitter::take(Candidate&& candidate) {
  features_.reset();  // what it remembers of zones takes memory that the volume needs
  result_.mesh = std::move(candidate.surface.mesh);
  result_.sizes = candidate.sizes;
  result_.absorbed = std::move(candidate.absorbed);
  result_.refinement.narrow_places = log_.misfit_count();
  result_.refinement.smallest_size = log_.smallest_size();
}

void SurfaceFitter::append(const std::vector<Diagnostic>& errors, const std::vector<Diagnostic>& warnings) {
  result_.errors.insert(result_.errors.end(), errors.begin(), errors.end());
  result_.warnings.insert(result_.warnings.end(), warnings.begin(), warnings.end());
}

}  // namespace tetloom
