#include "threading/parts/gather_mesh.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/codec.hpp"
#include "core/part/convert.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/packet_detail.hpp"

namespace tetloom {
namespace {

// Fields are the same on all ranks; rank 0 knows them.
void share_fields(PartitionedMesh& mesh) {
  const auto put = [&](MessageWriter& writer) {
    const auto put_fields = [&](const auto& fields) {
      writer.put(static_cast<std::uint64_t>(fields.size()));
      for (const auto& field : fields) {
        put_text(writer, field.name);
        writer.put(field.components);
      }
    };
    const PartMesh& part = mesh.parts.at(PartId(0)).mesh;
    put_fields(part.vertex_fields);
    put_fields(part.cell_fields);
  };
  const auto take = [&](MessageReader& reader) {
    for (std::vector<FieldInfo>* fields : {&mesh.vertex_fields, &mesh.cell_fields}) {
      const auto count = reader.get<std::uint64_t>();
      for (std::uint64_t i = 0; i < count; ++i) {
        std::string name = get_text(reader);
        fields->push_back({std::move(name), reader.get<int>()});
      }
    }
  };
  share_from_first(*mesh.communicator, put, take);
}

void pack_whole(const Part& part, MessageWriter& writer) {
  std::vector<std::uint32_t> cells(part.mesh.cell_count());
  std::iota(cells.begin(), cells.end(), 0u);
  detail::CellPacker::Scratch scratch;
  detail::CellPacker(part).pack(cells, scratch, writer);
}

// All of a part, for the only one.
Message whole_message(const Part& part, PartId sender) {
  MessageWriter writer;
  pack_whole(part, writer);
  return {sender, PartId(0), 0, writer.take()};
}

}  // namespace

Mesh fields_of(const PartitionedMesh& mesh) {
  Mesh names;
  for (const FieldInfo& info : mesh.vertex_fields) names.point_fields.push_back({info.name, info.components, {}});
  for (const FieldInfo& info : mesh.cell_fields) names.cell_fields.push_back({info.name, info.components, {}});
  return names;
}

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
  const auto pack = [&] {
    std::vector<Message> packets(local.size());
    runner.for_each(local.size(),
                    [&](std::size_t i) { packets[i] = whole_message(mesh.parts.at(local[i]), local[i]); });
    return packets;
  };
  std::vector<Message> packets = exchange(communicator, pack, [](PartId) { return 0; });
  Mesh whole;
  run_on_first(communicator, [&] { whole = make_mesh(detail::merge_packets(packets, mesh)); });
  return whole;
}

std::vector<PartEntity> gather_entities(const PartitionedMesh& mesh, const SharedWork& work) {
  const std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
    for (const PartId part : mesh.local())
      for (const PartEntity& entity : mesh.parts.at(part).mesh.entities) detail::put_entity(writer, entity);
  });
  std::vector<PartEntity> all;
  for (const Bytes& bytes : given)
    for (MessageReader reader(bytes); !reader.at_end();) all.push_back(detail::get_entity(reader));
  std::ranges::stable_sort(all, {}, &PartEntity::entity);
  const auto copies = std::ranges::unique(all, {}, &PartEntity::entity);
  all.erase(copies.begin(), copies.end());
  return all;
}

Mesh copy_to_all(PartitionedMesh&& mesh, const SharedWork& work) {
  const auto next = [&](std::size_t i) {
    const PartId part(i);
    std::vector<Bytes> given = work.all_gather([&](MessageWriter& writer) {
      work.runner().check_cancelled();
      if (!mesh.parts.is_local(part)) return;
      pack_whole(mesh.parts.at(part), writer);
      mesh.parts.at(part) = Part();
    });
    return std::move(given[static_cast<std::size_t>(work.ranks().rank_of(part, mesh.part_count()))]);
  };
  PartMesh whole = detail::merge_packets(mesh.part_count(), next, mesh);
  Mesh result;
  work.each([&] { result = make_mesh(std::exchange(whole, {})); });
  return result;
}

}  // namespace tetloom
