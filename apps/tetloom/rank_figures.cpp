#include "apps/tetloom/rank_figures.hpp"

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
      },
      [&](MessageReader& reader) {
        nlohmann::ordered_json rank{{"peak_bytes", reader.get<std::uint64_t>()}, {"model_bytes", nullptr}};
        const bool is_stored = reader.get<bool>();
        if (const auto held = reader.get<std::uint64_t>(); is_stored) rank["model_bytes"] = held;
        rank["tets"] = reader.get<std::uint64_t>();
        ranks.push_back(std::move(rank));
      });
  report.extra["ranks"] = std::move(ranks);
}

std::uint64_t tets_of_rank(const PartitionedMesh& mesh) {
  std::uint64_t tets = 0;
  for (const PartId part : mesh.local()) tets += mesh.parts.at(part).mesh.block(CellKind::Tet).size();
  return tets;
}

}  // namespace tetloom::app
