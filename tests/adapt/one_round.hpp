#pragma once
// One round of adaptation at a metric, for tests of what passes do in it.
#include <cmath>
#include <vector>

#include "adapt/kernel/passes.hpp"
#include "adapt/parts/rounds.hpp"

namespace tetloom::test {

/// Deals `mesh` to parts and calls visit(CavityMesh&, Passes&) for each of them, on one thread.
template <class Visit>
void in_one_round(const Mesh& mesh, const adapt::MetricField& metric, const tets::SurfaceProjector& project,
                  std::size_t part_count, const Visit& visit) {
  using namespace adapt;
  const TaskRunner runner(1);
  const BackgroundMesh background({mesh.points, mesh.tet_to_vert}, metric, runner);
  const std::vector<Tensor> implied = implied_metric(background.mesh());
  const MetricFunction none;
  const MetricStage stage(background, implied, none, HUGE_VAL);
  WholeMesh whole = make_whole_mesh(mesh, runner);
  for (std::size_t v = 0; v < whole.points.size(); ++v) {
    std::uint32_t hint = kNone;
    const Tensor tensor = stage.at(whole.points[v], hint);
    whole.to_metric[v] = {tensor, det(tensor)}, whole.to_hint[v] = hint;
  }
  const SharedWork work(runner);
  ShareLinks links = take_share(whole, work);
  Dealing dealing = deal_tets(whole, links, std::vector<float>(whole.size(), 1), part_count, 0, work);
  const auto adapt_part = [&](std::size_t, CavityMesh& part) {
    Passes passes(part, stage, project, {}, runner);
    visit(part, passes);
  };
  adapt_in_parts(whole, links, std::move(dealing), adapt_part, work);
}

}  // namespace tetloom::test
