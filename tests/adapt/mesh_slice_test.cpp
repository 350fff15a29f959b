// What ranks have of a mesh before it is adapted.
#include "adapt/parts/mesh_slice.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "tests/adapt/random_tensors.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/simulated_ranks.hpp"
#include "threading/parts/gather_mesh.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

Mesh box_with_field() {
  Mesh mesh = test::make_tet_box({4, 3, 5, true, 2});
  MeshField wave{"wave", 2, {}};
  for (const Vec3& x : mesh.points) wave.values.insert(wave.values.end(), {std::sin(x.x), x.y * x.z});
  mesh.point_fields = {wave, {"other", 1, std::vector<double>(mesh.points.size(), 1)}};
  MeshField step{"wave", 3, {}};
  for (const auto& tet : mesh.tet_to_vert) {
    const Vec3& x = mesh.points[tet[1]];
    step.values.insert(step.values.end(), {x.x, x.y - x.z, std::floor(x.z)});
  }
  mesh.cell_fields = {{"other", 1, std::vector<double>(mesh.tet_to_vert.size(), 1)}, step};
  return mesh;
}

/// The tets dealt to parts without regard to where they lie.
PartitionedMesh scattered(const Mesh& mesh, std::size_t parts, const SharedWork& work) {
  PartitionedMesh made = distribute_mesh(mesh, work.ranks());
  PerPart<Destinations> destinations(1, made.local());
  for (const PartId part : made.local())
    for (std::size_t tet = 0; tet < mesh.tet_to_vert.size(); ++tet)
      destinations.at(part).push_back(static_cast<std::uint32_t>(tet * 5 / 3 % parts));
  migrate(made, std::move(destinations), parts, work.runner());
  return made;
}

/// The metric of a vertex by its place, so that it is the same wherever that is.
Tensor metric_at(const Vec3& x) { return diagonal(1 + x.x, 2 + x.y, 3 + x.z); }

PerPart<MetricField> metric_of(const PartitionedMesh& mesh) {
  PerPart<MetricField> metric(mesh.part_count(), mesh.local());
  for (const PartId part : mesh.local())
    for (const Vec3& x : mesh.parts.at(part).mesh.points) metric.at(part).logs.push_back(metric_at(x));
  return metric;
}

/// Elements with what they lie on, by numbers in the whole mesh.
template <class Elements>
auto by_number(const MeshSlice& slice, const Elements& elements, const std::vector<std::uint32_t>& entities) {
  std::multiset<std::pair<typename Elements::value_type, std::uint32_t>> all;
  for (std::size_t i = 0; i < elements.size(); ++i) {
    auto verts = elements[i];
    for (std::uint32_t& v : verts) v = static_cast<std::uint32_t>(slice.to_vert_number[v]);
    std::ranges::sort(verts);
    all.emplace(verts, entities[i]);
  }
  return all;
}

std::size_t differences(const MeshSlice& one, const MeshSlice& other) {
  std::size_t wrong = 0;
  wrong += one.to_vert_number != other.to_vert_number;
  wrong += one.to_tet_number != other.to_tet_number;
  wrong += one.is_own != other.is_own;
  wrong += one.begin != other.begin || one.end != other.end || one.vert_count != other.vert_count;
  wrong += one.first_tets != other.first_tets;
  wrong += one.mesh.points != other.mesh.points;
  wrong += one.mesh.point_to_entity != other.mesh.point_to_entity;
  wrong += one.mesh.tet_to_vert != other.mesh.tet_to_vert;
  wrong += one.mesh.tet_to_entity != other.mesh.tet_to_entity;
  wrong += one.metric.logs != other.metric.logs;
  wrong += by_number(one, one.mesh.tri_to_vert, one.mesh.tri_to_entity) !=
           by_number(other, other.mesh.tri_to_vert, other.mesh.tri_to_entity);
  wrong += by_number(one, one.mesh.edge_to_vert, one.mesh.edge_to_entity) !=
           by_number(other, other.mesh.edge_to_vert, other.mesh.edge_to_entity);
  wrong += one.mesh.point_fields.size() != 1 || other.mesh.point_fields.size() != 1 ||
           one.mesh.point_fields[0].values != other.mesh.point_fields[0].values;
  wrong += one.mesh.cell_fields.size() != 1 || other.mesh.cell_fields.size() != 1 ||
           one.mesh.cell_fields[0].values != other.mesh.cell_fields[0].values;
  for (std::size_t dim = 0; dim < 4; ++dim) wrong += one.mesh.entities[dim].size() != other.mesh.entities[dim].size();
  return wrong;
}

}  // namespace

TEST_CASE("the slices of parts are those of the mesh that they make up", "[adapt][slices]") {
  const Mesh mesh = box_with_field();
  for (const int ranks : {1, 2, 5}) {
    CAPTURE(ranks);
    std::vector<std::size_t> wrong(static_cast<std::size_t>(ranks), 1);
    on_simulated_ranks(ranks, [&](Communicator& communicator) {
      const SharedWork work(1, {}, &communicator);
      work.together([&] {
        const Mesh whole = copy_to_all(scattered(mesh, 3, work), work);
        MetricField metric;
        for (const Vec3& x : whole.points) metric.logs.push_back(metric_at(x));
        PartitionedMesh parts = scattered(mesh, 3, work);
        PerPart<MetricField> of_parts = metric_of(parts);
        const MeshSlice slice = slice_of(std::move(parts), std::move(of_parts), {"wave"}, work);
        wrong[static_cast<std::size_t>(work.rank())] =
            differences(slice, slice_of(whole, metric, {"wave"}, work.rank(), ranks));
      });
    });
    CHECK(wrong == std::vector<std::size_t>(static_cast<std::size_t>(ranks), 0));
  }
}

TEST_CASE("slices are gathered into the mesh that they were cut from", "[adapt][slices]") {
  const Mesh mesh = box_with_field();
  RandomTensors random(3);
  MetricField metric;
  for (std::size_t v = 0; v < mesh.points.size(); ++v) metric.logs.push_back(random.tensor());
  std::vector<MeshWithMetric> gathered(3);
  on_simulated_ranks(3, [&](Communicator& communicator) {
    const SharedWork work(1, {}, &communicator);
    work.together([&] {
      const MeshSlice slice = slice_of(mesh, metric, {"wave"}, work.rank(), 3);
      gathered[static_cast<std::size_t>(work.rank())] = gather_slices(slice, work);
    });
  });
  for (const MeshWithMetric& whole : gathered) {
    CHECK(whole.mesh.points == mesh.points);
    CHECK(whole.mesh.tet_to_vert == mesh.tet_to_vert);
    CHECK(whole.mesh.tri_to_vert.size() == mesh.tri_to_vert.size());
    CHECK(whole.mesh.edge_to_vert.size() == mesh.edge_to_vert.size());
    CHECK(whole.metric.logs == metric.logs);
    CHECK(whole.mesh.point_fields[0].values == mesh.point_fields[0].values);
  }
}
