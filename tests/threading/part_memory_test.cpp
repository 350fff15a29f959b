// What a part takes.
#include <catch2/catch.hpp>

#include "core/part/convert.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/threading/part_cases.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

std::size_t allowed(const PartMesh& part) {
  std::size_t bytes = 40 * part.cell_count() + 48 * part.vertex_count();
  for (std::size_t kind = 0; kind < 3; ++kind)
    bytes += part.boundary[kind].size() * (kBoundaryVertexCount[kind] + 1) * sizeof(std::uint32_t);
  return bytes;
}

std::size_t needed(const PartMesh& part) { return allowed(part) - 4 * part.cell_count() - 8 * part.vertex_count(); }

}  // namespace

TEST_CASE("a part takes at most 40 bytes per tet and 48 per vertex beside its boundary") {
  const auto communicator = make_thread_communicator();
  const TaskRunner runner(2);
  PartitionedMesh mesh = distribute_mesh(make_tet_box(24, 24, 24, 1), *communicator);
  const PartMesh& whole = mesh.parts.at(PartId(0)).mesh;
  CHECK(whole.cell_count() == 6 * 24 * 24 * 24);
  CHECK(memory_of(whole) >= needed(whole));
  CHECK(memory_of(whole) <= allowed(whole));
  for (const std::size_t part_count : {5, 2}) {
    migrate(mesh, deal(mesh, part_count, Dealing::Slabs, 1), part_count, runner);
    for (const PartId id : mesh.local()) {
      const PartMesh& part = mesh.parts.at(id).mesh;
      CAPTURE(part_count, id.value, part.cell_count(), part.vertex_count(), part.further_places.size());
      CHECK(memory_of(part) >= needed(part));
      CHECK(memory_of(part) <= allowed(part));
    }
  }
}

TEST_CASE("migrated parts keep no room that they do not use") {
  const auto communicator = make_thread_communicator();
  PartitionedMesh mesh = distribute_mesh(make_case(3), *communicator);
  migrate(mesh, deal(mesh, 4, Dealing::Scatter, 1), 4, TaskRunner(1));
  for (const PartId id : mesh.local()) {
    const PartMesh& part = mesh.parts.at(id).mesh;
    CHECK(memory_of(part) == memory_of(PartMesh(part)));  // a copy takes what its values need
  }
}

TEST_CASE("room that is reserved counts as memory, and fields do") {
  PartMesh part = make_part(make_tet_box(2, 2, 2));
  const std::size_t before = memory_of(part);
  part.points.reserve(2 * part.points.size());
  const std::size_t reserved = memory_of(part);
  CHECK(reserved == before + part.points.size() * sizeof(Vec3));
  part.vertex_fields.push_back({"field", 1, {}});
  part.vertex_fields[0].values.resize(part.vertex_count());
  CHECK(memory_of(part) == reserved + part.vertex_count() * sizeof(double));
}
