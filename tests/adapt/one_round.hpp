#pragma once
// One round of adaptation at a metric, for tests of what passes do in it.
#include <cmath>
#include <vector>

#include "adapt/kernel/passes.hpp"
#include "adapt/parts/rounds.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::test {

/// A mesh before its first round, on one thread.
struct BeforeRound {
  TaskRunner runner{1};
  adapt::BackgroundMesh background;
  std::vector<adapt::Tensor> implied;
  adapt::MetricFunction none;
  adapt::MetricStage stage;
  adapt::WholeMesh whole;
  SharedWork work;
  adapt::ShareLinks links;

  BeforeRound(const Mesh& mesh, const adapt::MetricField& metric)
      : background({mesh.points, mesh.tet_to_vert}, metric, runner),
        implied(adapt::implied_metric(background.mesh())),
        stage(background, implied, none, HUGE_VAL),
        whole(adapt::make_whole_mesh(mesh, runner)),
        work(runner) {
    for (std::size_t v = 0; v < whole.points.size(); ++v) {
      adapt::BackgroundTet hint = adapt::kNoTet;
      const adapt::Tensor tensor = stage.at(whole.points[v], hint);
      whole.to_metric[v] = {tensor, det(tensor)}, whole.to_hint[v] = hint;
    }
    links = take_share(whole);
  }

  /// To parts of as many tets each.
  adapt::Dealing deal(std::size_t part_count) const {
    return deal_tets(whole, links, std::vector<float>(whole.size(), 1), part_count, 0, work);
  }
};

/// Deals `mesh` to parts and calls visit(CavityMesh&, Passes&) for each of them, on one thread.
template <class Visit>
void in_one_round(const Mesh& mesh, const adapt::MetricField& metric, const SurfaceProjector& project,
                  std::size_t part_count, const Visit& visit) {
  using namespace adapt;
  BeforeRound before(mesh, metric);
  const auto adapt_part = [&](std::size_t, CavityMesh& part) {
    Passes passes(part, before.stage, project, {}, before.runner);
    visit(part, passes);
  };
  adapt_in_parts(before.whole, before.links, before.deal(part_count), {adapt_part}, before.work);
}

}  // namespace tetloom::test
