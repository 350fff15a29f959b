#include "mesher/volume/fill_complex.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "core/base/failure.hpp"
#include "core/tets/link_tets.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/lattice/lattice_points.hpp"
#include "mesher/parts/fill_in_parts.hpp"
#include "mesher/volume/angle_causes.hpp"
#include "mesher/volume/lattice_filling.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "mesher/volume/worker_process.hpp"
#include "mesher/volume/worker_protocol.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/copy_of_machine.hpp"

namespace tetloom::volume {

namespace {

constexpr int kOwnAttempts = 3;
constexpr std::size_t kFewLost = 100;  // triangles; where more are, the place of the lattice makes no difference
constexpr std::size_t kTrianglesOfAttempts = 400'000;  // those of a complex times the worker's attempts
constexpr std::size_t kLeastAttempts = 2;

// One way of asking. TetGen's switches: p surface, Y keep its triangles, M merge nothing, Q quiet, J keep the
// numbering, z count from 0, O optimise, T tolerance for coplanar points.
struct Attempt {
  const char* switches;
  bool interior_points;
  bool reversed;  // points in reverse order: another sequence of insertions
};
constexpr std::array kAttempts{Attempt{"pYMQJzq1.4/14O4/7", true, false}, Attempt{"pYMQJzO4/7", true, false},
                               Attempt{"pYMQJzO2/7T1e-11", true, true},   Attempt{"pYMQJzO2/7", false, false},
                               Attempt{"pYMQJzT1e-11", false, true},      Attempt{"pYMQJzO0/0T1e-6", false, false},
                               Attempt{"pYMQJzO0/0T1e-14", false, true}};

// Why an attempt did not succeed.
struct Failure {
  ErrorCode code = ErrorCode::VolumeFailed;
  std::string message;
  std::vector<std::uint32_t> triangles;  // of the complex
  std::optional<Vec3> point;
};

class ComplexFiller {
 public:
  ComplexFiller(const FillingPlan& plan, const Complex& complex, FillingProgress& progress, const SharedWork& work)
      : plan_(plan),
        input_(plan.input),
        complex_(complex),
        progress_(progress),
        work_(work),
        runner_(work.runner()),
        tree_(complex.points, complex.tri_to_vert, work) {}

  VolumeParts run(bool may_be_parted) {
    if (!plan_.options.worker_only) fill_by_own_means(may_be_parted);
    if (is_filled()) return std::move(result_);
    if (failure_ && failure_->code == ErrorCode::SelfIntersection) {
      result_.errors.push_back(describe_failure());
      return std::move(result_);
    }
    if (!result_.errors.empty() || (!knows_crossings_ && surface_crosses_itself(result_.errors)))
      return std::move(result_);
    ask_worker();
    if (!is_filled()) {
      result_.errors.push_back(describe_failure());
    } else if (failure_) {
      result_.warnings.push_back(describe_fallback());
    }
    return std::move(result_);
  }

  void move_tree(const KeepBytes& keep) { tree_.move_arrays(keep); }

  VolumeParts run_in_parts() {
    fill_in_parts();
    return std::move(result_);
  }

 private:
  bool is_filled() const { return result_.part_count > 0; }

  // Where a triangle could not be recovered among the points of a lattice, it may be among those of a shifted one.
  void fill_by_own_means(bool may_be_parted) {
    if (may_be_parted && fill_in_parts()) return;
    for (int attempt = 0; attempt < kOwnAttempts; ++attempt) {
      FillingInput input = filling_input();
      input.attempt = attempt;
      FilledMesh own = fill_by_lattice(input, runner_);
      const bool failed = own.fault.any(), may_differ = own.figures.missing_triangles > 0 &&
                                                        own.fault.triangles.size() <= kFewLost &&
                                                        own.fault.code != ErrorCode::SelfIntersection;
      const bool retries = failed && may_differ && attempt + 1 < kOwnAttempts;
      if (failed) own.figures.core_tets = own.figures.shell_tets = own.figures.recovery_points = 0;
      if (retries) own.figures.missing_triangles = 0;
      accept(std::move(own));
      if (!retries) return;
      if (attempt == 0 && surface_crosses_itself(result_.errors)) return;
    }
  }

  // False when there is one part only, or where the parts' tets do not fit together.
  bool fill_in_parts() {
    auto filled = parts::fill_in_parts(filling_input(), work_);
    if (!filled) return false;
    if (filled->fault.any()) {
      result_.figures.parts.given_up = 1;
      result_.figures.parts.given_up_why = filled->fault.message;
      return false;
    }
    name_causes(input_, complex_, filled->tri_to_vert, filled->volume.figures.optimizer.acute_tets);
    result_ = std::move(filled->volume);
    return true;
  }

  FillingInput filling_input() const {
    return {complex_, tree_, *input_.sizes, progress_, plan_.options, plan_.freedom};
  }

  void accept(FilledMesh&& filled) {
    const auto& triangles = filled.tri_to_vert.empty() ? complex_.tri_to_vert : filled.tri_to_vert;
    name_causes(input_, complex_, triangles, filled.figures.optimizer.acute_tets);
    result_.figures.add(filled.figures);
    if (filled.fault.any())
      return note({filled.fault.code, filled.fault.message, filled.fault.triangles, filled.fault.point});
    result_.parts.push_back(to_part(std::move(filled), complex_, runner_));
    result_.new_points = result_.parts.back().points.size() - complex_.points.size();
    result_.part_count = 1;
  }

  void ask_worker() {
    if (plan_.worker.empty()) return;
    make_interior();
    const std::size_t most = std::max(kLeastAttempts, kTrianglesOfAttempts / complex_.tri_to_vert.size());
    for (const Attempt& attempt : std::span(kAttempts).first(std::min(most, kAttempts.size()))) {
      try_once(attempt);
      has_interior_ = attempt.interior_points;
      if (is_filled() || hopeless_) return;
    }
  }

  void make_interior() {
    lattice::LatticeRequest request{&tree_, complex_.tri_to_sides, {}, input_.sizes, plan_.options.lattice};
    for (const Vec3& p : complex_.points) request.box.add(p);
    for (const lattice::LevelPoints& level : make_lattice_points(request, runner_)) {
      for (const lattice::Site& site : level.sites) interior_.push_back(level.lattice.point(site));
    }
  }

  void try_once(const Attempt& attempt) {
    WorkerRequest request{attempt.switches,
                          {complex_.points.begin(), complex_.points.end()},
                          {complex_.tri_to_vert.begin(), complex_.tri_to_vert.end()}};
    if (attempt.interior_points) request.points.insert(request.points.end(), interior_.begin(), interior_.end());
    if (attempt.reversed) reverse(request);
    std::optional<WorkerResponse> response = ask(request);
    if (!response) return;
    if (attempt.reversed) reverse(request, *response);
    take(request.points, *response);
  }

  // The worker's answer, when it says that it has filled the complex.
  std::optional<WorkerResponse> ask(const WorkerRequest& request) {
    try {
      const WorkerRun run = run_worker(plan_.worker, encode(request), runner_);
      if (run.response.empty()) {
        note({ErrorCode::WorkerFailed, run.failure, {}, {}});
        hopeless_ = !run.crashed;
        return std::nullopt;
      }
      WorkerResponse response = decode_response(run.response, request.points.size());
      if (response.status == WorkerStatus::Filled) return response;
      hopeless_ = response.status == WorkerStatus::OutOfMemory;
      note({hopeless_ ? ErrorCode::OutOfMemory : ErrorCode::VolumeFailed, response.message, {}, {}});
    } catch (const Error& error) {
      if (error.code() != ErrorCode::WorkerFailed) throw;
      note({error.code(), error.what(), {}, {}});
      hopeless_ = true;
    }
    return std::nullopt;
  }

  void take(const std::vector<Vec3>& points, const WorkerResponse& response) {
    FilledMesh filled;
    tets::TetMesh all;
    all.points = GrowingArray<Vec3>(std::span(points));
    all.points.append(response.new_points);
    runner_.check_cancelled();
    filled.fault = link_tets(all, response.tet_to_vert, complex_.tri_to_vert, runner_);
    const tets::Surface surface{complex_.tri_to_vert, complex_.tri_to_sides};
    if (!filled.fault.any()) filled.fault = join_shell(filled.mesh, std::move(all), {}, surface, runner_);
    runner_.check_cancelled();
    if (!filled.fault.any()) finish_filling(filled, filling_input(), runner_);
    filled.figures.worker_complexes = filled.fault.any() ? 0 : 1;
    accept(std::move(filled));
  }

  static void reverse(WorkerRequest& request) {
    const auto last = static_cast<std::uint32_t>(request.points.size() - 1);
    std::reverse(request.points.begin(), request.points.end());
    for (auto& triangle : request.tri_to_vert) {
      for (std::uint32_t& vertex : triangle) vertex = last - vertex;
    }
  }
  // Back to the order of the complex; new points stay behind the given ones.
  static void reverse(WorkerRequest& request, WorkerResponse& response) {
    const auto given = static_cast<std::uint32_t>(request.points.size());
    reverse(request);
    for (auto& tet : response.tet_to_vert) {
      for (std::uint32_t& vertex : tet) vertex = vertex < given ? given - 1 - vertex : vertex;
    }
  }

  // The first failure tells most, but one that knows its triangles tells more.
  void note(Failure failure) {
    if (!failure_ || (failure_->triangles.empty() && !failure.triangles.empty())) failure_ = std::move(failure);
  }

  bool surface_crosses_itself(std::vector<Diagnostic>& errors) {
    knows_crossings_ = true;
    const auto found = find_self_intersections({complex_.points, complex_.tri_to_vert, {}, 1000}, runner_);
    if (found.empty()) return false;
    std::vector<std::uint32_t> tri_to_face;
    for (const std::uint32_t t : complex_.to_input_tri) tri_to_face.push_back(input_.tri_to_face[t]);
    errors = describe_intersections(found, {tri_to_face, input_.model});
    for (Diagnostic& diagnostic : errors) {
      for (std::uint64_t& element : diagnostic.elements) element = complex_.to_input_tri[element];
      for (const std::uint32_t region : complex_.regions)
        diagnostic.entities.push_back(named_entity(input_, {3, region}));
    }
    return true;
  }

  Diagnostic describe_failure() const {
    Diagnostic diagnostic;
    diagnostic.code = failure_->code;
    diagnostic.message = describe_regions(input_, complex_.regions) + " could not be filled: " + failure_->message;
    std::vector<std::uint32_t> triangles;
    for (const std::uint32_t t : failure_->triangles) triangles.push_back(complex_.to_input_tri[t]);
    diagnostic.entities = faces_of(input_, triangles.empty() ? complex_.to_input_tri : triangles);
    for (const std::uint32_t region : complex_.regions)
      diagnostic.entities.push_back(named_entity(input_, {3, region}));
    diagnostic.point = failure_->point.value_or(complex_.points[complex_.tri_to_vert[0][0]]);
    triangles.resize(std::min(triangles.size(), kElementsToldAtMost));
    diagnostic.elements.assign(triangles.begin(), triangles.end());
    return diagnostic;
  }

  Diagnostic describe_fallback() const {
    Diagnostic diagnostic = describe_failure();
    diagnostic.message = describe_regions(input_, complex_.regions) + " was filled by TetGen" +
                         (has_interior_ ? "" : ", without regard to the size field inside") +
                         "; before that: " + failure_->message;
    return diagnostic;
  }

  const FillingPlan& plan_;
  const VolumeInput& input_;
  const Complex& complex_;
  FillingProgress& progress_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  intersection::TriangleTree tree_;
  VolumeParts result_;
  std::vector<Vec3> interior_;
  std::optional<Failure> failure_;
  bool hopeless_ = false;      // other attempts would end like this one
  bool has_interior_ = false;  // of the last attempt
  bool knows_crossings_ = false;
};

}  // namespace

VolumeParts fill_complex(const FillingPlan& plan, const Complex& complex, FillingProgress& progress, bool may_be_parted,
                         const TaskRunner& runner) {
  std::optional<TraceSpan> span(std::in_place, plan.options.trace, "tree of triangles", runner.threads(),
                                intersection::TriangleTree::pieces(complex.tri_to_vert.size()));
  const SharedWork alone(runner);
  ComplexFiller filler(plan, complex, progress, alone);
  span.reset();
  return filler.run(may_be_parted);
}

VolumeParts fill_complex_in_parts(const FillingPlan& plan, const Complex& complex, FillingProgress& progress,
                                  const SharedWork& work) {
  ComplexFiller filler(plan, complex, progress, work);
  filler.move_tree(copy_of_machine(work.ranks()));
  return filler.run_in_parts();
}

}  // namespace tetloom::volume
