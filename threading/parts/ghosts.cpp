#include "threading/parts/ghosts.hpp"

#include <algorithm>
#include <functional>
#include <utility>

#include "core/base/lists.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/neighbor_writers.hpp"
#include "threading/parts/packet_detail.hpp"

namespace tetloom {
namespace {

// A vertex or a cell that another part wants to see.
struct Wish {
  PartId part;
  std::uint32_t item = 0;
  friend constexpr auto operator<=>(const Wish&, const Wish&) = default;
};

// What other parts want of one part, layer by layer: first the cells around the vertices that they share, then those
// around all vertices of these cells, where every part that has such a vertex must know of the wish.
class GhostGiver {
 public:
  void begin(const Part& part) {
    part_ = &part;
    const auto& shared = part.boundary.vertices;
    slot_.assign(part.mesh.vertex_count(), kNone);
    for (std::uint32_t i = 0; i < shared.size(); ++i) {
      slot_[shared.entities[i]] = i;
      for (const Copy& copy : shared.copies_of(i)) wishes_.push_back({copy.part, shared.entities[i]});
    }
    sort_unique(wishes_);
  }

  // Wishes for one more layer, told to those who share the vertices.
  void spread(PartTask& task) {
    find_cells();
    const CellNumbers numbers(part_->mesh);
    for (const Wish& wish : cells_)
      for (const std::uint32_t v : vertices_of(part_->mesh, numbers.cell_of(wish.item)))
        wishes_.push_back({wish.part, v});
    sort_unique(wishes_);
    detail::NeighborWriters told(part_->boundary.neighbors);
    for (const Wish& wish : wishes_) {
      if (slot_[wish.item] == kNone) continue;
      for (const Copy& copy : part_->boundary.vertices.copies_of(slot_[wish.item]))
        if (copy.part != wish.part) told.to(copy.part).put(Wish{wish.part, copy.local});
    }
    told.send(task);
  }

  void hear(PartTask& task) {
    for (const Message& message : task.inbox()) {
      MessageReader reader(message.bytes);
      while (!reader.at_end()) wishes_.push_back(reader.get<Wish>());
    }
    sort_unique(wishes_);
  }

  // After the last layer: whom this part gives cells to.
  std::vector<PartId> find_receivers() {
    find_cells();
    std::vector<PartId> receivers;
    for (const Wish& wish : cells_)
      if (receivers.empty() || receivers.back() != wish.part) receivers.push_back(wish.part);
    return receivers;
  }

  // Each packet is followed by where its vertices and cells live.
  void send_cells(PartTask& task) const {
    const detail::CellPacker packer(*part_);
    detail::CellPacker::Scratch scratch;
    for (std::size_t begin = 0; begin < cells_.size();) {
      std::size_t end = begin;
      std::vector<std::uint32_t> cells, verts;
      for (; end < cells_.size() && cells_[end].part == cells_[begin].part; ++end) cells.push_back(cells_[end].item);
      MessageWriter writer;
      packer.pack(cells, scratch, writer, &verts);
      writer.put_array(std::span<const std::uint32_t>(cells));
      const std::span<Copy> owners = writer.put_room<Copy>(verts.size());
      for (std::size_t i = 0; i < verts.size(); ++i) owners[i] = owner_of_vertex(task.part(), verts[i]);
      task.send(cells_[begin].part, writer.take());
      begin = end;
    }
  }

 private:
  void find_cells() {
    BallFinder finder(part_->mesh);
    const CellNumbers numbers(part_->mesh);
    cells_.clear();
    for (const Wish& wish : wishes_)
      for (const CellPlace corner : finder.find_ball(wish.item))
        cells_.push_back({wish.part, static_cast<std::uint32_t>(numbers.number_of(corner))});
    sort_unique(cells_);
  }

  Copy owner_of_vertex(PartId self, std::uint32_t vert) const {
    if (slot_[vert] == kNone) return {self, vert};
    const auto copies = part_->boundary.vertices.copies_of(slot_[vert]);
    return copies.front().part < self ? copies.front() : Copy{self, vert};
  }

  const Part* part_ = nullptr;
  std::vector<std::uint32_t> slot_;  // of vertices among the shared ones
  std::vector<Wish> wishes_;         // vertices around which a part wants all cells
  std::vector<Wish> cells_;
};

GhostedPart receive_ghosts(PartTask& task, Part&& part, const PartitionedMesh& mesh) {
  GhostedPart ghosted;
  ghosted.own_vertices = part.mesh.vertex_count();
  for (std::size_t kind = 0; kind < kCellKinds; ++kind) ghosted.own_cells[kind] = part.mesh.cells[kind].size();
  ghosted.mesh = detail::extend_part(std::move(part), task.inbox(), mesh, [&](const detail::AddedPacket& packet) {
    const auto cells = packet.rest.get_view<std::uint32_t>();
    const auto owners = packet.rest.get_view<Copy>();
    // New vertices have numbers in the order in which they are met.
    for (std::size_t i = 0; i < owners.size(); ++i)
      if (packet.verts[i] == ghosted.own_vertices + ghosted.ghost_vertices.size())
        ghosted.ghost_vertices.push_back(owners[i]);
    std::size_t at = 0;
    for (std::size_t kind = 0; kind < kCellKinds; ++kind)
      for (std::size_t i = 0; i < packet.cells[kind]; ++i)
        ghosted.ghost_cells[kind].push_back({packet.sender, cells[at++]});
  });
  return ghosted;
}

// `take`: a part, once nothing more of it is sent.
PerPart<GhostedPart> make_ghosts(const PartitionedMesh& mesh, int layers, const std::function<Part(PartId)>& take,
                                 const TaskRunner& runner, Trace* trace) {
  if (layers < 1) throw Error(ErrorCode::InvalidArgument, "there is at least one layer of ghosts");
  PerPart<GhostGiver> givers(mesh.part_count(), mesh.local());
  const Links neighbors = links_of_neighbors(mesh);
  std::vector<Step> steps{{"ghosts: begin", [&](PartTask& task) { givers[task].begin(mesh.parts[task]); }, {}, {}}};
  for (int layer = 1; layer < layers; ++layer) {
    steps.push_back({"ghosts: spread", [&](PartTask& task) { givers[task].spread(task); }, neighbors, {}});
    steps.push_back({"ghosts: hear", [&](PartTask& task) { givers[task].hear(task); }, {}, {}});
  }
  PerPart<std::vector<PartId>> receivers(mesh.part_count(), mesh.local());
  steps.push_back({"ghosts: choose", [&](PartTask& task) { receivers[task] = givers[task].find_receivers(); }, {}, {}});
  Schedule schedule(*mesh.communicator, runner, mesh.part_count(), trace);
  schedule.run(steps);

  PerPart<GhostedPart> ghosted(mesh.part_count(), mesh.local());
  const std::vector<Step> exchange{
      {"ghosts: send",
       [&](PartTask& task) { givers[task].send_cells(task); },
       directed_links(*mesh.communicator, receivers),
       {}},
      {"ghosts: receive",
       [&](PartTask& task) { ghosted[task] = receive_ghosts(task, take(task.part()), mesh); },
       {},
       {}}};
  schedule.run(exchange);
  return ghosted;
}

}  // namespace

PerPart<GhostedPart> make_ghosts(const PartitionedMesh& mesh, int layers, const TaskRunner& runner, Trace* trace) {
  PerPart<GhostedPart> ghosted = make_ghosts(
      mesh, layers, [&](PartId part) { return Part(mesh.parts.at(part)); }, runner, trace);
  const auto local = mesh.local();
  runner.for_each(local.size(), [&](std::size_t i) { connect_cells(ghosted.at(local[i]).mesh); });
  return ghosted;
}

PerPart<GhostedPart> add_ghosts(PartitionedMesh&& mesh, int layers, const TaskRunner& runner, Trace* trace) {
  const auto take = [&](PartId id) {
    Part part = std::exchange(mesh.parts.at(id), Part());
    disconnect_cells(part.mesh);
    return part;
  };
  return make_ghosts(mesh, layers, take, runner, trace);
}

namespace {

// Sends for every shared vertex that a part owns what `value_of(task, vertex)` puts, and hands it to `take` at the
// copies.
template <class Put, class Take>
void send_from_owners(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace, const Put& put, const Take& take) {
  const auto send = [&](PartTask& task) {
    const PartBoundary& boundary = mesh.parts[task].boundary;
    detail::NeighborWriters writers(boundary.neighbors);
    for (std::size_t i = 0; i < boundary.vertices.size(); ++i) {
      const auto copies = boundary.vertices.copies_of(i);
      if (owner_of(copies, task.part()) != task.part()) continue;
      for (const Copy& copy : copies) {
        MessageWriter& writer = writers.to(copy.part);
        writer.put(copy.local);
        put(task, boundary.vertices.entities[i], writer);
      }
    }
    writers.send(task);
  };
  const auto receive = [&](PartTask& task) {
    for (const Message& message : task.inbox()) {
      MessageReader reader(message.bytes);
      while (!reader.at_end()) {
        const auto vert = reader.get<std::uint32_t>();
        take(task, vert, reader);
      }
    }
  };
  const std::vector<Step> steps{{"owners: send", send, links_of_neighbors(mesh), {}},
                                {"owners: receive", receive, {}, {}}};
  Schedule(*mesh.communicator, runner, mesh.part_count(), trace).run(steps, true);
}

}  // namespace

void update_copies(PartitionedMesh& mesh, std::size_t field, const TaskRunner& runner, Trace* trace) {
  if (field >= mesh.vertex_fields.size()) throw Error(ErrorCode::InvalidArgument, "there is no such field");
  const auto n = static_cast<std::size_t>(mesh.vertex_fields[field].components);
  send_from_owners(
      mesh, runner, trace,
      [&](PartTask& task, std::uint32_t vert, MessageWriter& writer) {
        const auto& values = mesh.parts[task].mesh.vertex_fields[field].values;
        for (std::size_t i = 0; i < n; ++i) writer.put(values[vert * n + i]);
      },
      [&](PartTask& task, std::uint32_t vert, MessageReader& reader) {
        auto& values = mesh.parts[task].mesh.vertex_fields[field].values;
        for (std::size_t i = 0; i < n; ++i) values[vert * n + i] = reader.get<double>();
      });
}

void assign_global_ids(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace) {
  // How many vertices each part owns, summed over all ranks, where each fills in its own parts.
  std::vector<std::int64_t> owned(mesh.part_count() + 1, 0);
  for (const PartId id : mesh.local()) {
    const Part& part = mesh.parts.at(id);
    std::int64_t foreign = 0;
    for (std::size_t i = 0; i < part.boundary.vertices.size(); ++i)
      foreign += owner_of(part.boundary.vertices.copies_of(i), id) != id ? 1 : 0;
    owned[id.value + 1] = static_cast<std::int64_t>(part.mesh.vertex_count()) - foreign;
  }
  mesh.communicator->sum(owned);
  for (std::size_t i = 1; i < owned.size(); ++i) owned[i] += owned[i - 1];
  runner.for_each(mesh.local().size(), [&](std::size_t k) {
    const PartId id = mesh.local()[k];
    Part& part = mesh.parts.at(id);
    std::vector<bool> foreign(part.mesh.vertex_count(), false);
    for (std::size_t i = 0; i < part.boundary.vertices.size(); ++i)
      foreign[part.boundary.vertices.entities[i]] = owner_of(part.boundary.vertices.copies_of(i), id) != id;
    auto next = static_cast<std::uint64_t>(owned[id.value]);
    for (std::size_t v = 0; v < foreign.size(); ++v)
      if (!foreign[v]) part.mesh.vert_to_global[v] = next++;
  });
  send_from_owners(
      mesh, runner, trace,
      [&](PartTask& task, std::uint32_t vert, MessageWriter& writer) {
        writer.put(mesh.parts[task].mesh.vert_to_global[vert]);
      },
      [&](PartTask& task, std::uint32_t vert, MessageReader& reader) {
        mesh.parts[task].mesh.vert_to_global[vert] = reader.get<std::uint64_t>();
      });
}

}  // namespace tetloom
