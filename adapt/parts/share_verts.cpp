#include "adapt/parts/share_verts.hpp"

#include <algorithm>
#include <utility>

#include "adapt/kernel/metric_stage.hpp"
#include "adapt/metric/start_grid.hpp"
#include "core/predicates/predicates.hpp"

namespace tetloom::adapt {

namespace {

constexpr std::size_t kAtOnce = std::size_t{1} << 15, kGrain = std::size_t{1} << 10;

// Calls visit(tets) for some tets after the other, turned so that their volumes are positive.
template <class Visit>
void for_some_tets(const Mesh& mesh, const TaskRunner& runner, const Visit& visit) {
  std::vector<TetVerts> tets;
  for (std::size_t first = 0; first < mesh.tet_to_vert.size(); first += kAtOnce) {
    tets.resize(std::min(kAtOnce, mesh.tet_to_vert.size() - first));
    runner.for_blocks(tets.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const auto& [a, b, c, d] = tets[i] = mesh.tet_to_vert[first + i];
        if (orient3d(mesh.points[a], mesh.points[b], mesh.points[c], mesh.points[d]) < 0)
          std::swap(tets[i][2], tets[i][3]);
      }
    });
    visit(TetView{mesh.points, tets});
  }
}

// The order of a tet's vertices decides about the last bits of its centre.
StartGrid grid_of(const Mesh& mesh, const TaskRunner& runner) {
  Box3 box;
  for (const TetVerts& tet : mesh.tet_to_vert)
    for (const std::uint32_t v : tet) box.add(mesh.points[v]);
  StartGrid grid(box, mesh.tet_to_vert.size());
  for_some_tets(mesh, runner, [&](const TetView& some) { grid.add(some); });
  grid.finish();
  return grid;
}

std::vector<Tensor> find_implied(const Mesh& mesh, FiguresBefore& fields, const TaskRunner& runner) {
  ImpliedMetric implied(mesh.points.size());
  for_some_tets(mesh, runner, [&](const TetView& some) {
    implied.add(some, runner);
    fields.add(some, runner);
  });
  fields.finish();
  return implied.finish();
}

}  // namespace

ShareVerts verts_of_mesh(const Mesh& mesh, const std::vector<std::uint8_t>& is_own, const MetricField& metric,
                         FiguresBefore& fields, const TaskRunner& runner) {
  ShareVerts verts;
  verts.has_metric = metric.size() > 0;
  for (std::uint32_t v = 0; v < is_own.size(); ++v)
    if (is_own[v] != 0) verts.to_given.push_back(v);
  const auto of_own = [&](const std::vector<Tensor>& all, std::vector<Tensor>& own) {
    own.reserve(verts.to_given.size());
    for (const std::uint32_t v : verts.to_given) own.push_back(all[v]);
  };
  if (verts.has_metric) of_own(metric.logs, verts.logs);
  of_own(find_implied(mesh, fields, runner), verts.implied);
  for (const MeshField* field : fields.fields) verts.components += static_cast<std::size_t>(field->components);
  for (const std::uint32_t v : verts.to_given) {
    for (const MeshField* field : fields.fields) {
      const auto n = static_cast<std::ptrdiff_t>(field->components), at = static_cast<std::ptrdiff_t>(v) * n;
      verts.fields.insert(verts.fields.end(), field->values.begin() + at, field->values.begin() + at + n);
    }
  }
  const StartGrid grid = grid_of(mesh, runner);
  for (const std::uint32_t v : verts.to_given) verts.to_start.push_back(grid.tet_near(mesh.points[v]));
  return verts;
}

ShareVerts as_in_share(const ShareVerts& verts, const WholeMesh& share, const ShareLinks& links,
                       const TouchingVerts& touching, std::size_t given) {
  ShareVerts own;
  own.has_metric = verts.has_metric, own.components = verts.components;
  for (std::uint32_t v = 0; v < share.points.size(); ++v) {
    std::uint32_t number = links.number_of(v);
    if (number >= given) number = touching.verts[share.to_entity[v].unpack().index - touching.first];
    const auto at = static_cast<std::size_t>(std::ranges::lower_bound(verts.to_given, number) - verts.to_given.begin());
    own.to_given.push_back(number);
    if (own.has_metric) own.logs.push_back(verts.logs[at]);
    own.implied.push_back(verts.implied[at]);
    own.to_start.push_back(verts.to_start[at]);
    for (std::size_t c = 0; c < own.components; ++c) own.fields.push_back(verts.fields[at * own.components + c]);
  }
  return own;
}

}  // namespace tetloom::adapt
