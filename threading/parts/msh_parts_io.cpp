#include <array>

#include "core/io/mesh_parts.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/parts_io_detail.hpp"

namespace tetloom::detail {
namespace {

/// The parts of the cells of the gathered mesh: within a kind, cells stand by part.
MeshParts list_parts(const PartitionedMesh& mesh) {
  std::vector<std::int64_t> counts(kCellKinds * mesh.part_count(), 0);
  for (const PartId part : mesh.local())
    for (std::size_t kind = 0; kind < kCellKinds; ++kind)
      counts[kind * mesh.part_count() + part.value] =
          static_cast<std::int64_t>(mesh.parts.at(part).mesh.cells[kind].size());
  mesh.communicator->sum(counts);
  MeshParts parts{static_cast<std::uint32_t>(mesh.part_count()), {}};
  for (std::size_t i = 0; i < counts.size(); ++i)
    parts.cell_to_part.insert(parts.cell_to_part.end(), static_cast<std::size_t>(counts[i]),
                              static_cast<std::uint32_t>(i % mesh.part_count()));
  return parts;
}

}  // namespace

void write_partitioned(const PartitionedMesh& mesh, const std::filesystem::path& path, const TaskRunner& runner,
                       const CancelToken* cancel) {
  const MeshParts parts = list_parts(mesh);
  const Mesh whole = gather_mesh(mesh, runner);
  run_on_first(*mesh.communicator, [&] { write_msh_parts(whole, parts, path, cancel, runner); });
}

PartitionedMesh read_partitioned(const std::filesystem::path& path, Communicator& communicator,
                                 const TaskRunner& runner, const CancelToken* cancel) {
  MeshParts parts;
  Mesh whole;
  run_on_first(communicator, [&] { whole = read_msh_parts(path, parts, cancel); });
  PartitionedMesh mesh = distribute_mesh(whole, communicator);
  whole = {};
  const std::uint64_t count = share_number(communicator, parts.count);
  if (count == 0) return mesh;
  PerPart<Destinations> destinations(1, mesh.local());
  for (const PartId part : mesh.local()) destinations.at(part) = std::move(parts.cell_to_part);
  migrate(mesh, std::move(destinations), static_cast<std::size_t>(count), runner);
  return mesh;
}

}  // namespace tetloom::detail
