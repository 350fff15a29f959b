#include "mesher/second_order/make_second_order.hpp"

#include <algorithm>

#include "core/base/stopwatch.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "mesher/second_order/mend_tets.hpp"
#include "mesher/second_order/mid_node_places.hpp"
#include "mesher/second_order/straighten.hpp"

namespace tetloom::second_order {
namespace {

// Other tets first where moving mid nodes inside does not help. What is made may be in the way of what is left. Beside
// layers tets stay: their patches would have other cells behind them.
Straightening mend_and_straighten(std::vector<CurvedNode>& curved, double least, Mesh& mesh, const TaskRunner& runner) {
  const int rounds = cell_count(mesh) == mesh.tet_to_vert.size() ? 2 : 0;
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint32_t> hopeless;
    if (auto done = straighten_unless_hopeless(curved, least, mesh, hopeless, runner)) return std::move(*done);
    if (mend_tets(hopeless, least, curved, mesh, runner) == 0) break;
  }
  return straighten(curved, least, mesh, runner);
}

}  // namespace

SecondOrderFigures make_second_order(const GeometricModel& model, double min_scaled_jacobian, Mesh& mesh,
                                     const TaskRunner& runner) {
  Stopwatch watch;
  SecondOrderFigures figures;
  MidNodePlaces places = place_mid_nodes(model, mesh, runner);
  const Straightening straightening = mend_and_straighten(places.curved, min_scaled_jacobian, mesh, runner);
  figures.mid_nodes = mesh.mid_to_vert.size();
  const auto is_on_surface = [&](const CurvedNode& node) {
    return mesh.point_to_entity[vertex_count(mesh) + node.mid].dim < 3;
  };
  figures.curved =
      static_cast<std::size_t>(std::ranges::count_if(places.curved, is_on_surface)) - straightening.off_model.size();
  figures.moved = straightening.moved.size();
  figures.min_scaled_jacobian = straightening.min_scaled_jacobian;
  figures.invalid = straightening.not_positive;
  figures.off_model = std::move(places.off_model);
  for (const CurvedNode& node : straightening.off_model) {
    const std::size_t p = vertex_count(mesh) + node.mid;
    figures.off_model.push_back({mesh.point_to_entity[p], distance(mesh.points[p], node.place), mesh.points[p]});
  }
  figures.seconds = watch.lap();
  return figures;
}

}  // namespace tetloom::second_order
