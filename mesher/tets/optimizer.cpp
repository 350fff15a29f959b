#include "mesher/tets/optimizer.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/error.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "mesher/tets/newton_smoothing.hpp"

namespace tetloom::tets {

namespace {

void check_options(const TetMesh& mesh, const OptimizeOptions& options) {
  const auto refuse = [](const char* why) { throw Error(ErrorCode::InvalidArgument, why); };
  if (options.fixed_points > mesh.points.size()) refuse("more points are to stay than the mesh has");
  if (!(options.goal > 0 && options.goal < 1)) refuse("the goal must lie between 0 and 1");
  if (!(options.least_dihedral >= 0 && options.least_dihedral <= 60))
    refuse("the least dihedral angle must lie between 0 and 60 degrees");
}

struct QualitySummary {
  double least = 1, mean = 0;
  std::size_t below = 0;
};

QualitySummary summarize(WorkingMesh& mesh, double goal) {
  QualitySummary summary;
  float least = 1;
  const auto bound = static_cast<float>(cube(goal));
  std::size_t count = 0;
  for (const float quality : mesh.qualities()) {
    if (quality == WorkingMesh::kDeadQuality) continue;
    least = std::min(least, quality);
    summary.below += quality < bound;
    summary.mean += std::cbrt(quality);
    ++count;
  }
  summary.least = std::cbrt(double{least});
  if (count > 0) summary.mean /= static_cast<double>(count);
  return summary;
}

class Optimizer {
 public:
  Optimizer(TetMesh& mesh, const OptimizeOptions& options, const TaskRunner& runner)
      : mesh_(mesh, options.fixed_points), options_(options), runner_(runner) {}

  OptimizeReport run() {
    const QualitySummary before = summarize(mesh_, options_.goal);
    report_.least_before = before.least, report_.mean_before = before.mean;
    for (int i = 0; i < 3; ++i) swap(.60), smooth(.70);
    if (options_.strong_gradation) {
      for (int i = 0; i < 3; ++i) swap(.80), smooth(1);
    }
    swap(.60), smooth(.70), swap(.60), smooth(.95);
    const QualitySummary after = summarize(mesh_, options_.goal);
    report_.least = after.least, report_.mean = after.mean, report_.below_goal = after.below;
    mesh_.finish();
    return report_;
  }

 private:
  void swap(double threshold) { report_.edges_removed += remove_edges(mesh_, cube(threshold), runner_); }
  void smooth(double threshold) { report_.vertices_moved += move_vertices(mesh_, cube(threshold), runner_); }

  WorkingMesh mesh_;
  const OptimizeOptions& options_;
  const TaskRunner& runner_;
  OptimizeReport report_;
};

}  // namespace

OptimizeReport optimize(TetMesh& mesh, const OptimizeOptions& options, const TaskRunner& runner) {
  check_options(mesh, options);
  return Optimizer(mesh, options, runner).run();
}

}  // namespace tetloom::tets
