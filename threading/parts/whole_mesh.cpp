#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <numeric>

#include "core/part/convert.hpp"
#include "threading/comm/agreement.hpp"
#include "threading/comm/exchange.hpp"
#include "threading/parts/packet_detail.hpp"

namespace tetloom {
namespace {

// Fields are the same on all ranks; rank 0 knows them.
void share_fields(PartitionedMesh& mesh) {
  MessageWriter writer;
  if (mesh.communicator->rank() == 0) {
    const PartMesh& part = mesh.parts.at(PartId(0)).mesh;
    const auto put = [&](const std::string& name, int components) {
      writer.put_array(std::span<const char>(name.data(), name.size()));
      writer.put(components);
    };
    writer.put(static_cast<std::uint64_t>(part.vertex_fields.size()));
    for (const VertexField& field : part.vertex_fields) put(field.name, field.components);
    writer.put(static_cast<std::uint64_t>(part.cell_fields.size()));
    for (const CellField& field : part.cell_fields) put(field.name, field.components);
  }
  const std::vector<Bytes> all = mesh.communicator->all_gather(writer.take());
  MessageReader reader(all[0]);
  for (std::vector<FieldInfo>* fields : {&mesh.vertex_fields, &mesh.cell_fields}) {
    const auto count = reader.get<std::uint64_t>();
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto name = reader.get_view<char>();
      fields->push_back({{name.begin(), name.end()}, reader.get<int>()});
    }
  }
}

// All of a part, for the only one.
Message pack_whole(const Part& part, PartId sender) {
  std::vector<std::uint32_t> cells(part.mesh.cell_count());
  std::iota(cells.begin(), cells.end(), 0u);
  detail::CellPacker::Scratch scratch;
  MessageWriter writer;
  detail::CellPacker(part).pack(cells, scratch, writer);
  return {sender, PartId(0), 0, writer.take()};
}

}  // namespace

PartitionedMesh distribute_mesh(const Mesh& mesh, Communicator& communicator) {
  PartitionedMesh result(communicator, 1);
  run_on_first(communicator, [&] { result.parts.at(PartId(0)).mesh = make_part(mesh); });
  share_fields(result);
  return result;
}

void gather_in_one_part(PartitionedMesh& mesh, const TaskRunner& runner) {
  PerPart<Destinations> destinations(mesh.part_count(), mesh.local());
  for (const PartId part : mesh.local()) destinations.at(part).assign(mesh.parts.at(part).mesh.cell_count(), 0);
  migrate(mesh, std::move(destinations), 1, runner);
}

Mesh gather_mesh(const PartitionedMesh& mesh, const TaskRunner& runner) {
  Communicator& communicator = *mesh.communicator;
  const auto local = mesh.local();
  std::vector<Message> packets(local.size());
  run_on_all(communicator, [&] {
    runner.for_each(local.size(), [&](std::size_t i) { packets[i] = pack_whole(mesh.parts.at(local[i]), local[i]); });
  });
  packets = exchange(communicator, std::move(packets), [](PartId) { return 0; });
  Mesh whole;
  run_on_first(communicator, [&] { whole = make_mesh(detail::merge_packets(packets, mesh)); });
  return whole;
}

}  // namespace tetloom
