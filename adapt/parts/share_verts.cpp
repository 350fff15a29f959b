#include "adapt/parts/share_verts.hpp"

#include <algorithm>

#include "adapt/kernel/metric_stage.hpp"
#include "adapt/metric/start_grid.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kAtOnce = std::size_t{1} << 15;

// Calls visit(tets) for some tets after the other.
template <class Visit>
void for_some_tets(const tets::TetMesh& whole, const Visit& visit) {
  std::vector<TetVerts> tets;
  for (std::size_t first = 0; first < whole.size(); first += kAtOnce) {
    tets.resize(std::min(kAtOnce, whole.size() - first));
    for (std::size_t i = 0; i < tets.size(); ++i) std::copy_n(&whole.to_vert[(first + i) * 4], 4, tets[i].begin());
    visit(TetView{whole.points.span(), tets});
  }
}

StartGrid grid_of(const tets::TetMesh& whole) {
  Box3 box;
  for (const std::uint32_t v : whole.to_vert) box.add(whole.points[v]);
  StartGrid grid(box, whole.size());
  for_some_tets(whole, [&](const TetView& some) { grid.add(some); });
  grid.finish();
  return grid;
}

std::vector<Tensor> implied_of(const tets::TetMesh& whole, const TaskRunner& runner) {
  ImpliedMetric implied(whole.points.size());
  for_some_tets(whole, [&](const TetView& some) { implied.add(some, runner); });
  return implied.finish();
}

}  // namespace

ShareVerts verts_of_tets(const tets::TetMesh& whole, std::size_t first, std::size_t count, const MetricField& metric,
                         const TaskRunner& runner) {
  ShareVerts verts;
  verts.has_metric = metric.size() > 0;
  std::vector<std::uint8_t> is_used(whole.points.size(), 0);
  for (std::size_t i = first * 4; i < (first + count) * 4; ++i) is_used[whole.to_vert[i]] = 1;
  for (std::uint32_t v = 0; v < is_used.size(); ++v)
    if (is_used[v] != 0) verts.to_given.push_back(v);
  is_used = {};
  const auto of_used = [&](const std::vector<Tensor>& all, std::vector<Tensor>& used) {
    used.reserve(verts.to_given.size());
    for (const std::uint32_t v : verts.to_given) used.push_back(all[v]);
  };
  if (verts.has_metric) of_used(metric.logs, verts.logs);
  of_used(implied_of(whole, runner), verts.implied);
  const StartGrid grid = grid_of(whole);
  for (const std::uint32_t v : verts.to_given) verts.to_start.push_back(grid.tet_near(whole.points[v]));
  return verts;
}

ShareVerts as_in_share(const ShareVerts& verts, const WholeMesh& share, const ShareLinks& links,
                       const TouchingVerts& touching, std::size_t given) {
  ShareVerts own;
  own.has_metric = verts.has_metric;
  for (std::uint32_t v = 0; v < share.points.size(); ++v) {
    std::uint32_t number = links.number_of(v);
    if (number >= given) number = touching.verts[share.to_entity[v].unpack().index - touching.first];
    const auto at =
        static_cast<std::size_t>(std::ranges::lower_bound(verts.to_given, number) - verts.to_given.begin());
    own.to_given.push_back(number);
    if (own.has_metric) own.logs.push_back(verts.logs[at]);
    own.implied.push_back(verts.implied[at]);
    own.to_start.push_back(verts.to_start[at]);
  }
  return own;
}

}  // namespace tetloom::adapt
