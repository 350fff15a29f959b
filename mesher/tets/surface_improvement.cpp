#include "mesher/tets/surface_improvement.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "mesher/tets/edge_removal.hpp"
#include "mesher/tets/newton_smoothing.hpp"
#include "mesher/tets/point_insertion.hpp"
#include "mesher/tets/quality_summary.hpp"
#include "mesher/tets/surface_slide.hpp"
#include "mesher/tets/surface_swap.hpp"
#include "mesher/tets/vertex_removal.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

constexpr int kRoundsPerRound = 4;                  // of the surface for one inside
constexpr std::size_t kLeastShare = 10;             // rounds end when one changes less than the first over this
constexpr std::size_t kVisitsBetweenChecks = 1024;  // for cancellation

class SurfaceImprover {
 public:
  SurfaceImprover(TetMesh& mesh, const ChangeableSurface& surface, const OptimizeOptions& options,
                  const TaskRunner& runner)
      : mesh_(mesh, options.fixed_points),
        surface_(surface),
        triangles_(surface.tri_to_vert, options.fixed_points),
        options_(options),
        runner_(runner),
        poor_(poor_quality(options.goals)) {}

  void run(OptimizeReport& report) {
    std::size_t first = 0;
    for (int round = 0; round < kRoundsPerRound * options_.goals.rounds; ++round) {
      const std::size_t swapped = swap_edges(), slid = slide_vertices();
      report.edges_swapped += swapped, report.vertices_slid += slid;
      if (swapped + slid == 0) break;
      repair(report);
      if (round == 0) first = swapped + slid;
      if ((swapped + slid) * kLeastShare < first) break;
    }
    if (first > 0) summarize_result(mesh_, options_.goals, report);
    mesh_.finish(options_.keep_points);
    report.tets = mesh_.mesh().size();
  }

 private:
  // The poor tets, the worst first; of equal ones that with the lower id.
  std::vector<std::pair<float, std::uint32_t>> find_poor() {
    std::vector<std::pair<float, std::uint32_t>> poor;
    const auto bound = static_cast<float>(poor_);
    const std::span<const float> qualities = mesh_.qualities();
    for (std::uint32_t tet = 0; tet < qualities.size(); ++tet) {
      if (qualities[tet] < bound) poor.emplace_back(qualities[tet], tet);
    }
    std::sort(poor.begin(), poor.end());
    return poor;
  }

  template <class Visit>
  std::size_t for_each_poor(Visit&& visit) {
    std::size_t count = 0, visits = 0;
    for (const auto& [quality, tet] : find_poor()) {
      if (visits++ % kVisitsBetweenChecks == 0) runner_.check_cancelled();
      if (static_cast<double>(mesh_.quality(tet)) < poor_) count += visit(tet);
    }
    return count;
  }

  std::size_t swap_edges() {
    SurfaceSwapper swapper(mesh_, surface_, triangles_, poor_);
    return for_each_poor(
        [&](std::uint32_t tet) { return std::size_t{swapper.swap_edge_of(tet) == SwapVerdict::Swapped}; });
  }

  std::size_t slide_vertices() {
    SurfaceSlider slider(mesh_, surface_, triangles_, poor_);
    std::vector<bool> visited(surface_.point_to_entity.size());
    return for_each_poor([&](std::uint32_t tet) {
      std::size_t count = 0;
      for (std::uint32_t corner = 0; corner < 4; ++corner) {
        const std::uint32_t vertex = mesh_.verts(tet)[corner];
        if (vertex >= visited.size() || visited[vertex]) continue;
        visited[vertex] = true;
        count += slider.slide(tet, corner) == SlideVerdict::Moved;
      }
      return count;
    });
  }

  // Inside, as the optimiser does it.
  void repair(OptimizeReport& report) {
    report.edges_removed += remove_edges(mesh_, cube(.60), runner_);
    report.vertices_moved += move_vertices(mesh_, cube(.60), runner_);
    report.vertices_removed += remove_vertices(mesh_, poor_, runner_);
    report.points_inserted += insert_points(mesh_, poor_, runner_);
  }

  WorkingMesh mesh_;
  const ChangeableSurface& surface_;
  SurfaceTriangles triangles_;
  const OptimizeOptions& options_;
  const TaskRunner& runner_;
  double poor_;  // cubed quality
};

}  // namespace

void improve_surface(TetMesh& mesh, const ChangeableSurface& surface, const OptimizeOptions& options,
                     OptimizeReport& report, const TaskRunner& runner) {
  if (cube(report.least) >= poor_quality(options.goals)) return;  // as the optimiser left it, nothing is poor
  SurfaceImprover(mesh, surface, options, runner).run(report);
}

}  // namespace tetloom::tets
