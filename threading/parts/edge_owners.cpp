#include "threading/parts/edge_owners.hpp"

#include <algorithm>
#include <array>
#include <functional>
#include <iterator>
#include <span>
#include <utility>

#include "core/base/lists.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {
namespace {

using SharedEdges = SharedEntities<std::array<std::uint32_t, 2>>;

// Its place; their number where it is not among them.
std::size_t find_edge(const SharedEdges& shared, std::uint32_t a, std::uint32_t b) {
  const std::array<std::uint32_t, 2> edge{a, b};
  const auto at = std::lower_bound(shared.entities.begin(), shared.entities.end(), edge);
  return at == shared.entities.end() || *at != edge ? shared.size()
                                                    : static_cast<std::size_t>(at - shared.entities.begin());
}

// Elements of one kind, all of whose vertices are joined by edges.
struct Elements {
  std::size_t corners = 0;
  std::function<std::span<const std::uint32_t>(const PartMesh&)> verts;
};

std::vector<std::uint8_t> mark_shared(const Part& part) {
  std::vector<std::uint8_t> is_shared(part.mesh.vertex_count(), 0);
  for (const std::uint32_t v : part.boundary.vertices.entities) is_shared[v] = 1;
  return is_shared;
}

// Calls visit(a, b), a < b, for edges between vertices that several parts have, some of them several times.
template <class Visit>
void for_each_outer_edge(const Part& part, const Elements& elements, const Visit& visit) {
  const std::vector<std::uint8_t> is_shared = mark_shared(part);
  const auto verts = elements.verts(part.mesh);
  for (std::size_t first = 0; first < verts.size(); first += elements.corners)
    for (std::size_t i = first; i < first + elements.corners; ++i)
      for (std::size_t j = i + 1; j < first + elements.corners; ++j)
        if (is_shared[verts[i]] != 0 && is_shared[verts[j]] != 0)
          visit(std::min(verts[i], verts[j]), std::max(verts[i], verts[j]));
}

// The places in PartBoundary::edges of those that elements of the part have, ascending.
std::vector<std::uint32_t> find_places(const Part& part, const Elements& elements) {
  std::vector<std::uint32_t> places;
  for_each_outer_edge(part, elements, [&](std::uint32_t a, std::uint32_t b) {
    if (const std::size_t place = find_edge(part.boundary.edges, a, b); place < part.boundary.edges.size())
      places.push_back(static_cast<std::uint32_t>(place));
  });
  sort_unique(places);
  return places;
}

// Keeps the places of edges that the part owns; the others go to their owners, by their places there.
std::vector<Message> tell_owners(const Part& part, PartId self, std::vector<std::uint32_t>& places) {
  std::vector<std::pair<PartId, std::uint32_t>> foreign;
  std::erase_if(places, [&](std::uint32_t place) {
    const Copy& first = part.boundary.edges.copies_of(place).front();
    if (first.part < self) foreign.emplace_back(first.part, first.local);
    return first.part < self;
  });
  std::ranges::sort(foreign);
  std::vector<Message> messages;
  for (auto begin = foreign.begin(); begin != foreign.end();) {
    const PartId owner = begin->first;
    std::vector<std::uint32_t> told;
    for (; begin != foreign.end() && begin->first == owner; ++begin) told.push_back(begin->second);
    MessageWriter writer;
    writer.put_array<std::uint32_t>(told);
    messages.push_back({self, owner, 0, writer.take()});
  }
  return messages;
}

PerPart<std::vector<std::uint32_t>> find_owned(const PartitionedMesh& mesh, const Elements& elements,
                                               const TaskRunner& runner) {
  PerPart<std::vector<std::uint32_t>> owned(mesh.part_count(), mesh.local());
  Communicator& communicator = *mesh.communicator;
  const auto local = mesh.local();
  const auto make = [&] {
    std::vector<std::vector<Message>> part_to_messages(local.size());
    runner.for_each(local.size(), [&](std::size_t i) {
      const Part& part = mesh.parts.at(local[i]);
      owned.at(local[i]) = find_places(part, elements);
      part_to_messages[i] = tell_owners(part, local[i], owned.at(local[i]));
    });
    std::vector<Message> messages;
    for (auto& list : part_to_messages) std::ranges::move(list, std::back_inserter(messages));
    return messages;
  };
  const auto rank_of = [&](PartId part) { return communicator.rank_of(part, mesh.part_count()); };
  const std::vector<Message> arrived = exchange(communicator, make, rank_of);
  run_on_all(communicator, [&] {
    for (const Message& message : arrived) {
      const auto told = MessageReader(message.bytes).get_view<std::uint32_t>();
      owned.at(message.to).insert(owned.at(message.to).end(), told.begin(), told.end());
    }
    for (const PartId part : local) sort_unique(owned.at(part));
  });
  return owned;
}

MeasuredEdges::Edges edges_at(const SharedEdges& shared, std::span<const std::uint32_t> places) {
  MeasuredEdges::Edges edges;
  for (const std::uint32_t place : places) edges.push_back(shared.entities[place]);
  return edges;
}

}  // namespace

EdgeOwners::EdgeOwners(const PartitionedMesh& mesh, const TaskRunner& runner)
    : of_tets_(
          find_owned(mesh, {4, [](const PartMesh& part) { return part.block(CellKind::Tet).to_vert.span(); }}, runner)),
      of_triangles_(find_owned(
          mesh, {3, [](const PartMesh& part) { return part.block(BoundaryKind::Triangle).to_vert.span(); }}, runner)) {}

MeasuredEdges EdgeOwners::of(const Part& part, PartId self) const {
  const SharedEdges& shared = part.boundary.edges;
  const auto is_inside = [&shared, is_shared = mark_shared(part)](std::uint32_t a, std::uint32_t b) {
    return is_shared[a] == 0 || is_shared[b] == 0 || find_edge(shared, a, b) == shared.size();
  };
  return {is_inside, edges_at(shared, of_tets_.at(self)), edges_at(shared, of_triangles_.at(self))};
}

}  // namespace tetloom
