#include "adapt/parts/share_verts.hpp"

#include <algorithm>

#include "adapt/kernel/metric_stage.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kAtOnce = std::size_t{1} << 18;

// Calls visit(tets) for some tets after the other, as they were before fans had vertices of their own.
template <class Visit>
void for_some_tets(const WholeMesh& whole, const TouchingVerts& touching, std::size_t given, const Visit& visit) {
  for (std::size_t first = 0; first < whole.size(); first += kAtOnce) {
    const auto tets =
        tets_before_fans(whole, touching, given, first, std::min(kAtOnce, whole.size() - first));
    visit(TetView{whole.points.span(), tets});
  }
}

Box3 box_of_tets(const WholeMesh& whole) {
  Box3 box;
  for (const std::uint32_t v : whole.to_vert) box.add(whole.points[v]);
  return box;
}

}  // namespace

WholeFindings find_in_whole(const WholeMesh& whole, const TouchingVerts& touching, std::size_t given,
                            const TaskRunner& runner) {
  WholeFindings found{given, StartGrid(box_of_tets(whole), whole.size()), {}};
  ImpliedMetric implied(given);
  for_some_tets(whole, touching, given, [&](const TetView& some) {
    found.grid.add(some);
    implied.add(some, runner);
  });
  found.grid.finish();
  found.implied = implied.finish();
  return found;
}

ShareVerts verts_of_share(const WholeMesh& share, const ShareLinks& links, const TouchingVerts& touching,
                          const WholeFindings& found, const MetricField& metric) {
  ShareVerts verts;
  verts.has_metric = metric.size() > 0;
  for (std::uint32_t v = 0; v < share.points.size(); ++v) {
    const std::uint32_t number = links.number_of(v);
    const std::uint32_t given = number < found.given
                                    ? number
                                    : touching.verts[share.to_entity[v].unpack().index - touching.first];
    verts.to_given.push_back(given);
    if (verts.has_metric) verts.logs.push_back(metric.logs[given]);
    verts.implied.push_back(found.implied[given]);
    verts.to_start.push_back(found.grid.tet_near(share.points[v]));
  }
  return verts;
}

}  // namespace tetloom::adapt
