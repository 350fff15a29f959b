#include "mesher/tets/optimizer.hpp"

#include <algorithm>

#include "core/tets/many_values.hpp"
#include "core/tets/tet_quality.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "mesher/tets/newton_smoothing.hpp"
#include "mesher/tets/point_insertion.hpp"
#include "mesher/tets/quality_goals.hpp"
#include "mesher/tets/quality_summary.hpp"
#include "mesher/tets/relaxation.hpp"
#include "mesher/tets/vertex_removal.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

void check_options(const TetMesh& mesh, const OptimizeOptions& options) {
  if (options.lattice_tets > mesh.size())
    throw Error(ErrorCode::InvalidArgument, "more tets are of the lattice than the mesh has");
  if (options.fixed_points > mesh.points.size())
    throw Error(ErrorCode::InvalidArgument, "more points are to stay than the mesh has");
  check_goals(options.goals);
}

constexpr double kSpreadFloor = 0.05 * 0.05 * 0.05;  // flat tets that come of it are removed by what follows

class Optimizer {
 public:
  Optimizer(TetMesh& mesh, const OptimizeOptions& options, const TaskRunner& runner)
      : mesh_(mesh, options.fixed_points, options.lattice_tets, options.open_faces),
        options_(options),
        runner_(runner) {}

  OptimizeReport run() {
    const QualitySummary before = summarize(mesh_, options_.goals.mean_ratio);
    report_.least_before = before.least, report_.mean_before = before.mean;
    if (options_.sizes) {
      spread();
      swap(.60), smooth(.92), swap(.80);
      repair();
      smooth(.92);
    } else {
      swap(.60), smooth(.70), swap(.75), smooth(.75), swap(.70);
      repair();
      smooth(.90);  // the tets of lattices have .945 and more
    }
    if (!options_.qualities) summarize_result(mesh_, options_.goals, report_);
    mesh_.finish(options_.keep_points);
    if (options_.qualities) *options_.qualities = mesh_.take_qualities();
    report_.tets = mesh_.mesh().size();
    return report_;
  }

 private:
  void swap(double threshold) { report_.edges_removed += remove_edges(mesh_, cube(threshold), runner_); }
  void smooth(double threshold) { report_.vertices_moved += move_vertices(mesh_, cube(threshold), runner_); }

  // Where sizes vary, next to no tet is of an undisturbed lattice: numbers of tets at vertices are what has to be
  // mended.
  void spread() {
    if (mesh_.qualities().empty()) return;
    const double floor = std::max(kSpreadFloor, double{least_of(mesh_.qualities())});
    report_.vertices_moved += relax(mesh_, options_.lattice_tets, *options_.sizes, floor, runner_);
  }

  // What is still so poor that an angle may be too small gets another choice of points.
  void repair() {
    const double poor = poor_quality(options_.goals);
    for (int round = 0; round < options_.goals.rounds; ++round) {
      const std::size_t removed = remove_vertices(mesh_, poor, runner_);
      const std::size_t inserted = insert_points(mesh_, poor, runner_);
      report_.vertices_removed += removed, report_.points_inserted += inserted;
      if (removed + inserted == 0) return;
      swap(.60), smooth(.70);
    }
  }

  WorkingMesh mesh_;
  const OptimizeOptions& options_;
  const TaskRunner& runner_;
  OptimizeReport report_;
};

}  // namespace

void OptimizeReport::add(const OptimizeReport& other) {
  if (other.tets == 0) return;
  if (tets == 0) {
    *this = other;
    return;
  }
  const double share = static_cast<double>(other.tets) / static_cast<double>(tets + other.tets);
  mean_before += share * (other.mean_before - mean_before);
  mean += share * (other.mean - mean);
  for (const auto least_of : {&OptimizeReport::least_before, &OptimizeReport::least, &OptimizeReport::least_dihedral})
    this->*least_of = std::min(this->*least_of, other.*least_of);
  for (const auto count :
       {&OptimizeReport::edges_swapped, &OptimizeReport::vertices_slid, &OptimizeReport::edges_removed,
        &OptimizeReport::vertices_moved, &OptimizeReport::points_inserted, &OptimizeReport::vertices_removed,
        &OptimizeReport::below_goal, &OptimizeReport::below_dihedral, &OptimizeReport::forced,
        &OptimizeReport::forced_by_angles, &OptimizeReport::forced_by_triangles, &OptimizeReport::forced_by_points,
        &OptimizeReport::tets})
    this->*count += other.*count;
  acute_tets.insert(acute_tets.end(), other.acute_tets.begin(), other.acute_tets.end());
  keep_worst(acute_tets);
}

OptimizeReport optimize(TetMesh& mesh, const OptimizeOptions& options, const TaskRunner& runner) {
  check_options(mesh, options);
  return Optimizer(mesh, options, runner).run();
}

}  // namespace tetloom::tets
