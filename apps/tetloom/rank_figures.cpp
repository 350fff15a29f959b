#include "apps/tetloom/rank_figures.hpp"

#include "threading/comm/collectives.hpp"

namespace tetloom::app {

void note_ranks(Communicator& communicator, std::uint64_t tets, RunReport& report) {
  if (communicator.rank_count() == 1) return;
  nlohmann::ordered_json ranks = nlohmann::ordered_json::array();
  gather(
      communicator,
      [&](MessageWriter& writer) {
        writer.put(peak_bytes());
        writer.put(tets);
      },
      [&](MessageReader& reader) {
        const auto bytes = reader.get<std::uint64_t>();
        ranks.push_back({{"peak_bytes", bytes}, {"tets", reader.get<std::uint64_t>()}});
      });
  report.extra["ranks"] = std::move(ranks);
}

std::uint64_t tets_of_rank(const PartitionedMesh& mesh) {
  std::uint64_t tets = 0;
  for (const PartId part : mesh.local()) tets += mesh.parts.at(part).mesh.block(CellKind::Tet).size();
  return tets;
}

}  // namespace tetloom::app
