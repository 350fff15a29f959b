#include "apps/tetloom/rank_figures.hpp"

#include <set>
#include <utility>
#include <vector>

#include "threading/comm/collectives.hpp"

namespace tetloom::app {

void note_ranks(Communicator& communicator, std::uint64_t tets, const GeometricModel* model, RunReport& report) {
  if (communicator.rank_count() == 1) return;
  const std::optional<ShapeMemory> shapes = model ? model->shape_memory() : std::nullopt;
  nlohmann::ordered_json ranks = nlohmann::ordered_json::array();
  gather(
      communicator,
      [&](MessageWriter& writer) {
        writer.put(peak_bytes());
        writer.put(shapes.has_value());
        writer.put(shapes.value_or(ShapeMemory{}).most_held_bytes);
        writer.put(tets);
        writer.put(communicator.sent_bytes());
      },
      [&](MessageReader& reader) {
        nlohmann::ordered_json rank{{"peak_bytes", reader.get<std::uint64_t>()}, {"model_bytes", nullptr}};
        const bool is_stored = reader.get<bool>();
        if (const auto held = reader.get<std::uint64_t>(); is_stored) rank["model_bytes"] = held;
        rank["tets"] = reader.get<std::uint64_t>();
        rank["sent_bytes"] = reader.get<std::uint64_t>();
        ranks.push_back(std::move(rank));
      });
  report.extra["ranks"] = std::move(ranks);
}

namespace {

// Of the edges and faces that vertices and elements of the part lie on.
std::uint64_t model_bytes_of(const PartMesh& part, const GeometricModel& model) {
  std::set<std::pair<int, std::uint32_t>> entities;
  for (const PackedEntity packed : part.vert_to_entity)
    if (const ModelEntity entity = packed.unpack(); entity.dim == 1 || entity.dim == 2)
      entities.emplace(entity.dim, entity.index);
  for (const BoundaryKind kind : {BoundaryKind::Edge, BoundaryKind::Triangle, BoundaryKind::Quad})
    for (const std::uint32_t index : part.block(kind).to_entity)
      entities.emplace(kind == BoundaryKind::Edge ? 1 : 2, index);
  std::uint64_t bytes = 0;
  for (const auto& [dim, index] : entities) bytes += model.shape_bytes(ModelEntity(dim, index));
  return bytes;
}

}  // namespace

void note_model_bytes(const PartitionedMesh& mesh, const GeometricModel& model, nlohmann::ordered_json& partition) {
  if (!model.shape_memory()) return;
  std::vector<std::uint64_t> own;
  for (const PartId part : mesh.local()) own.push_back(model_bytes_of(mesh.parts.at(part).mesh, model));
  const std::vector<std::uint64_t> all = gather_lists<std::uint64_t>(*mesh.communicator, own);
  for (std::size_t part = 0; part < all.size(); ++part) partition["table"][part]["model_bytes"] = all[part];
}

std::uint64_t tets_of_rank(const PartitionedMesh& mesh) {
  std::uint64_t tets = 0;
  for (const PartId part : mesh.local()) tets += mesh.parts.at(part).mesh.block(CellKind::Tet).size();
  return tets;
}

}  // namespace tetloom::app
