#include "threading/whole_mesh.hpp"

#include "core/part/convert.hpp"
#include "threading/migration.hpp"

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

}  // namespace

PartitionedMesh distribute_mesh(const Mesh& mesh, Communicator& communicator) {
  PartitionedMesh result(communicator, 1);
  std::optional<Error> error;
  if (communicator.rank() == 0) {
    try {
      result.parts.at(PartId(0)).mesh = make_part(mesh);
    } catch (const Error& caught) {
      error = caught;
    }
  }
  std::array<std::int64_t, 1> failed{error ? 1 : 0};
  communicator.sum(failed);
  if (error) throw *error;
  if (failed[0] != 0) throw Error(ErrorCode::InputUnsuitable, "the mesh cannot be dealt to parts; rank 0 says why");
  share_fields(result);
  return result;
}

Mesh gather_mesh(const PartitionedMesh& mesh, const TaskRunner& runner) {
  PartitionedMesh copy = mesh;
  PerPart<Destinations> destinations(copy.part_count(), copy.local());
  for (const PartId part : copy.local()) destinations.at(part).assign(copy.parts.at(part).mesh.cell_count(), 0);
  migrate(copy, std::move(destinations), 1, runner);
  return copy.communicator->rank() == 0 ? make_mesh(copy.parts.at(PartId(0)).mesh) : Mesh{};
}

}  // namespace tetloom
