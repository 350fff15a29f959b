#include "mesher/tets/surface_improvement.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/tets/dihedral.hpp"
#include "core/tets/many_values.hpp"
#include "mesher/tets/angle_search.hpp"
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
constexpr int kFairRounds = 1;                      // for tets that are fair, not poor
constexpr double kFair = 0.8;                       // mean ratio below which tets are, where sizes vary
constexpr std::size_t kLeastShare = 10;             // rounds end when one changes less than the first over this
constexpr std::size_t kVisitsBetweenChecks = 1024;  // for cancellation
constexpr std::size_t kSearchesBetweenChecks = 64;
// Angles below this, half a degree more than what users are told of, are widened by what the mean ratio does not see.
// Those below the second one are out of reach: walls so thin take thousands of poor tets whatever is done to them.
constexpr double kSharpAngle = 5.5 * std::numbers::pi / 180, kHopelessAngle = 0.4 * std::numbers::pi / 180;
constexpr double kLeastForAngle = 0.04 * 0.04 * 0.04;  // cubed quality that may come of that, where nothing is worse
constexpr double kGrowthPerRound = 0.01;               // of squared edges; what moves little goes first

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
    const int rounds = options_.goals.rounds;
    std::size_t changes = 0;
    if (const double fair = quality_to_improve(options_); fair > poor_) changes += improve(fair, kFairRounds, report);
    changes += improve(poor_, kRoundsPerRound * rounds, report);
    if (widen_angles(report) + changes > 0) summarize_result(mesh_, options_.goals, report);
    mesh_.finish(options_.keep_points);
    report.tets = mesh_.mesh().size();
  }

 private:
  // Rounds over the tets of cubed quality below `limit`. Returns the number of changes of the surface.
  std::size_t improve(double limit, int most_rounds, OptimizeReport& report) {
    std::size_t first = 0, sum = 0;
    for (int round = 0; round < most_rounds; ++round) {
      const std::size_t swapped = swap_edges(limit), slid = slide_vertices(limit);
      report.edges_swapped += swapped, report.vertices_slid += slid;
      if (swapped + slid == 0) break;
      sum += swapped + slid;
      repair(limit, report);
      if (round == 0) first = swapped + slid;
      if ((swapped + slid) * kLeastShare < first) break;
    }
    return sum;
  }

  // The tets of cubed quality below `limit`, the worst first; of equal ones that with the lower id.
  std::vector<std::pair<float, std::uint32_t>> find_below(double limit) {
    std::vector<std::pair<float, std::uint32_t>> poor;
    const auto bound = static_cast<float>(limit);
    const std::span<const float> qualities = mesh_.qualities();
    for (std::uint32_t tet = 0; tet < qualities.size(); ++tet) {
      if (qualities[tet] < bound) poor.emplace_back(qualities[tet], tet);
    }
    std::sort(poor.begin(), poor.end());
    return poor;
  }

  template <class Visit>
  std::size_t for_each_below(double limit, Visit&& visit) {
    std::size_t count = 0, visits = 0;
    for (const auto& [quality, tet] : find_below(limit)) {
      if (visits++ % kVisitsBetweenChecks == 0) runner_.check_cancelled();
      if (static_cast<double>(mesh_.quality(tet)) < limit) count += visit(tet);
    }
    return count;
  }

  std::size_t swap_edges(double limit) {
    SurfaceSwapper swapper(mesh_, surface_, triangles_, limit);
    return for_each_below(
        limit, [&](std::uint32_t tet) { return std::size_t{swapper.swap_edge_of(tet) == SwapVerdict::Swapped}; });
  }

  std::size_t slide_vertices(double limit) {
    SurfaceSlider slider(mesh_, surface_, triangles_, limit);
    std::vector<bool> visited(surface_.point_to_entity.size());
    return for_each_below(limit, [&](std::uint32_t tet) {
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

  // The tets of the smallest angles, the worst first; of equal ones that with the lower id.
  std::vector<std::pair<double, std::uint32_t>> find_sharp() {
    std::vector<std::pair<double, std::uint32_t>> sharp;
    const auto bound = static_cast<float>(largest_quality_with_dihedral(kSharpAngle) * kGain);
    const double cosine = std::cos(kSharpAngle);
    const std::span<const float> qualities = mesh_.qualities();
    for (std::uint32_t tet = 0; tet < qualities.size(); ++tet) {
      if (qualities[tet] >= bound || mesh_.mesh().is_dead(tet) || !may_be_below(mesh_.mesh(), tet, cosine)) continue;
      const double angle = smallest_dihedral(mesh_.mesh(), tet).angle;
      if (angle < kSharpAngle && angle > kHopelessAngle) sharp.emplace_back(angle, tet);
    }
    std::ranges::sort(sharp);
    return sharp;
  }

  // What the mean ratio does not tell apart, but the angles do. Returns the number of changes.
  std::size_t widen_angles(OptimizeReport& report) {
    const double least = std::min(kLeastForAngle, static_cast<double>(least_of(mesh_.qualities())));
    std::size_t sum = 0;
    for (int round = 1; round <= kRoundsPerRound * options_.goals.rounds; ++round) {
      const std::size_t changes = widen_once({least, 1 + kGrowthPerRound * round}, report);
      if (changes == 0) break;
      sum += changes;
    }
    return sum;
  }

  struct Widening {
    double least, growth;  // as SurfaceSlider::slide_for_angle has them
  };

  // Moves each vertex of the sharp tets once, and puts points into those that stay sharp.
  std::size_t widen_once(const Widening& allowed, OptimizeReport& report) {
    SurfaceSlider slider(mesh_, surface_, triangles_, poor_);
    std::vector<bool> visited(mesh_.mesh().points.size());
    std::size_t slid = 0, moved = 0, inserted = 0, visits = 0;
    for (const auto& [angle, tet] : find_sharp()) {
      if (visits++ % kSearchesBetweenChecks == 0) runner_.check_cancelled();
      if (mesh_.mesh().is_dead(tet)) continue;
      for (std::uint32_t corner = 0; corner < 4; ++corner) {
        const std::uint32_t vertex = mesh_.verts(tet)[corner];
        if (vertex >= visited.size() || visited[vertex]) continue;
        visited[vertex] = true;
        if (vertex < surface_.point_to_entity.size())
          slid += slider.slide_for_angle(tet, corner, allowed.least, allowed.growth) == SlideVerdict::Moved;
        else
          moved += move_for_angle(mesh_, tet, corner, allowed.least);
      }
      if (smallest_dihedral(mesh_.mesh(), tet).angle < kSharpAngle)
        inserted += insert_for_angle(mesh_, tet, allowed.least);
    }
    report.vertices_slid += slid, report.vertices_moved += moved, report.points_inserted += inserted;
    return slid + moved + inserted;
  }

  // Inside, as the optimiser does it.
  void repair(double limit, OptimizeReport& report) {
    report.edges_removed += remove_edges(mesh_, cube(.60), runner_);
    report.vertices_moved += move_vertices(mesh_, std::max(limit, cube(.60)), runner_);
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

double quality_to_improve(const OptimizeOptions& options) {
  const double poor = poor_quality(options.goals);
  return options.sizes && options.goals.rounds > 0 ? std::max(poor, cube(kFair)) : poor;
}

void improve_surface(TetMesh& mesh, const ChangeableSurface& surface, const OptimizeOptions& options,
                     OptimizeReport& report, const TaskRunner& runner) {
  if (cube(report.least) >= quality_to_improve(options)) return;
  SurfaceImprover(mesh, surface, options, runner).run(report);
}

}  // namespace tetloom::tets
