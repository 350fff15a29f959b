#include "core/part/adjacency.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

#include "threading/comm/collectives.hpp"
#include "threading/parts/idle_ranks.hpp"
#include "threading/parts/packet_detail.hpp"

namespace tetloom {
namespace {

struct Packing {
  std::vector<Message> packets;
  std::uint64_t cells_sent = 0;
  bool disconnected = false;  // the neighbours of the part were dropped
};

void pack_part(PartId self, Part& part, Destinations& destinations, std::size_t part_count, const TaskRunner& runner,
               Packing& packing) {
  if (destinations.size() != part.mesh.cell_count())
    throw Error(ErrorCode::InvalidArgument, "a list of destinations is not as long as its part has cells");
  const detail::SortedCells cells = detail::sort_by_destination(destinations, part_count);
  const detail::CellPacker packer(part);
  destinations = Destinations();
  packing.disconnected = true;
  disconnect_cells(part.mesh);  // what the receivers compute anew takes memory that the packets need
  const std::vector<PartId>& receivers = cells.receivers;
  packing.packets.resize(receivers.size());
  const std::size_t lanes = 4 * static_cast<std::size_t>(runner.threads());
  runner.for_blocks(receivers.size(), std::max<std::size_t>(1, receivers.size() / lanes),
                    [&](std::size_t begin, std::size_t end) {
                      detail::CellPacker::Scratch scratch;
                      for (std::size_t k = begin; k < end; ++k) {
                        MessageWriter writer;
                        packer.pack(cells.of(k), scratch, writer);
                        packing.packets[k] = {self, receivers[k], 0, writer.take()};
                      }
                    });
  for (std::size_t k = 0; k < receivers.size(); ++k)
    if (receivers[k] != self) packing.cells_sent += cells.of(k).size();
}

void pack_all(PartitionedMesh& mesh, PerPart<Destinations>& destinations, std::size_t part_count,
              const TaskRunner& runner, Trace* trace, PerPart<Packing>& packings) {
  const std::vector<Step> steps{
      {"migrate: pack",
       [&](PartTask& task) {
         pack_part(task.part(), mesh.parts[task], destinations[task], part_count, task.runner(), packings[task]);
       },
       {},
       [&](PartId part) { return static_cast<double>(mesh.parts.at(part).mesh.cell_count()); }}};
  try {
    const TaskRunner wide = runner_for_cells(mesh, runner);
    Schedule(*mesh.communicator, wide, mesh.part_count(), trace).run(steps);
  } catch (...) {
    for (const PartId part : mesh.local()) {
      packings.at(part).packets = std::vector<Message>();
      if (packings.at(part).disconnected) connect_cells(mesh.parts.at(part).mesh);
    }
    throw;
  }
}

MigrationFigures sum_figures(PartitionedMesh& mesh, const PerPart<Packing>& packings) {
  std::array<std::int64_t, 2> sums{};
  for (const PartId part : mesh.local()) {
    sums[0] += static_cast<std::int64_t>(packings.at(part).cells_sent);
    for (const Message& packet : packings.at(part).packets) sums[1] += static_cast<std::int64_t>(packet.bytes.size());
  }
  mesh.communicator->sum(sums);
  return {static_cast<std::uint64_t>(sums[0]), static_cast<std::uint64_t>(sums[1])};
}

void unpack_all(PartitionedMesh& mesh, std::vector<Message> arrived, const TaskRunner& runner, Trace* trace) {
  PerPart<std::vector<Message>> packets(mesh.part_count(), mesh.local());
  PerPart<double> work(mesh.part_count(), mesh.local());
  for (Message& message : arrived) {
    work.at(message.to) += static_cast<double>(message.bytes.size());
    packets.at(message.to).push_back(std::move(message));
  }
  const std::vector<Step> steps{{"migrate: unpack",
                                 [&](PartTask& task) {
                                   mesh.parts[task].mesh = detail::unpack_part(packets[task], mesh);
                                   packets[task] = std::vector<Message>();
                                 },
                                 {},
                                 [&](PartId part) { return work.at(part); }}};
  Schedule(*mesh.communicator, runner, mesh.part_count(), trace).run(steps, true);
}

}  // namespace

MigrationFigures migrate(PartitionedMesh& mesh, PerPart<Destinations> destinations, std::size_t part_count,
                         const TaskRunner& runner, Trace* trace) {
  if (part_count == 0) throw Error(ErrorCode::InvalidArgument, "a mesh has at least one part");
  PerPart<Packing> packings(mesh.part_count(), mesh.local());
  pack_all(mesh, destinations, part_count, runner, trace, packings);

  // From here on the packets are the mesh.
  const MigrationFigures figures = sum_figures(mesh, packings);
  Communicator& communicator = *mesh.communicator;
  const auto take_packets = [&] {
    std::vector<Message> outgoing;
    for (const PartId part : mesh.local()) std::ranges::move(packings.at(part).packets, std::back_inserter(outgoing));
    mesh.parts = PerPart<Part>(part_count, communicator.parts_of_rank(part_count));
    return outgoing;
  };
  const auto rank_of = [&](PartId part) { return communicator.rank_of(part, part_count); };
  unpack_all(mesh, exchange(communicator, take_packets, rank_of), runner, trace);
  link_parts(mesh, runner, trace);
  return figures;
}

}  // namespace tetloom
