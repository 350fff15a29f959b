#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "core/base/lists.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/parts/residence.hpp"

namespace tetloom {
namespace {

using EdgeVerts = std::array<std::uint32_t, 2>;

// A boundary edge or face that another part may have too, named by the positions of its vertices in the list of
// vertices that the two parts share. Both sides have that list in the same order, so the key is the same on both.
template <class Entity>
struct MaybeShared {
  FaceKey key;
  Entity entity;
};

// Everything about one neighbour.
struct Neighbor {
  PartId part;
  std::vector<std::uint32_t> verts;  // shared with it, by ascending global id
  std::vector<MaybeShared<EdgeVerts>> edges;
  std::vector<MaybeShared<CellPlace>> faces;  // candidates, later those that are shared, by key
};

class PartLinker {
 public:
  void begin(const PartMesh& part, Residence residence) {
    part_ = &part;
    residence_ = std::move(residence);
    list_neighbors();
    number_positions();
  }
  const std::vector<PartId>& neighbor_parts() const { return neighbor_parts_; }

  // Step 1: local numbers of shared vertices, in the order that both sides know.
  void send_vertices(PartTask& task) const {
    for (const Neighbor& neighbor : neighbors_) {
      MessageWriter writer;
      writer.put_array(std::span<const std::uint32_t>(neighbor.verts));
      task.send(neighbor.part, writer.take());
    }
  }

  // Step 2: the vertices are linked; proposes edges and faces.
  void link_vertices(PartTask& task, SharedEntities<std::uint32_t>& shared) {
    std::vector<std::pair<std::uint32_t, Copy>> links;
    for (const Message& message : task.inbox()) {
      const Neighbor& neighbor = neighbor_of(message.from);
      const auto theirs = MessageReader(message.bytes).get_view<std::uint32_t>();
      TETLOOM_ASSERT(theirs.size() == neighbor.verts.size());
      for (std::size_t i = 0; i < theirs.size(); ++i) links.push_back({neighbor.verts[i], {message.from, theirs[i]}});
    }
    fill(shared, std::move(links));
    find_candidates();
    for (Neighbor& neighbor : neighbors_) {
      MessageWriter writer;
      put_keys(writer, neighbor.edges);
      put_keys(writer, neighbor.faces);
      task.send(neighbor.part, writer.take());
    }
  }

  // Step 3: what both sides proposed is shared; it gets its places in the lists of this part, which are sent.
  void match_candidates(PartTask& task, PartBoundary& boundary) {
    for (const Message& message : task.inbox()) {
      Neighbor& neighbor = neighbor_of(message.from);
      MessageReader reader(message.bytes);
      keep_common(neighbor.edges, reader.get_view<FaceKey>());
      keep_common(neighbor.faces, reader.get_view<FaceKey>());
    }
    boundary.edges.entities = list_entities(&Neighbor::edges);
    boundary.faces.entities = list_entities(&Neighbor::faces);
    for (const Neighbor& neighbor : neighbors_) {
      MessageWriter writer;
      writer.put_array(std::span<const std::uint32_t>(places_in(boundary.edges.entities, neighbor.edges)));
      writer.put_array(std::span<const std::uint32_t>(places_in(boundary.faces.entities, neighbor.faces)));
      task.send(neighbor.part, writer.take());
    }
  }

  // Step 4: the places in the others' lists.
  void link_edges_and_faces(PartTask& task, PartBoundary& boundary) {
    std::vector<std::pair<EdgeVerts, Copy>> edges;
    std::vector<std::pair<CellPlace, Copy>> faces;
    for (const Message& message : task.inbox()) {
      const Neighbor& neighbor = neighbor_of(message.from);
      MessageReader reader(message.bytes);
      add_links(neighbor.edges, message.from, reader.get_view<std::uint32_t>(), edges);
      add_links(neighbor.faces, message.from, reader.get_view<std::uint32_t>(), faces);
    }
    fill(boundary.edges, std::move(edges));
    fill(boundary.faces, std::move(faces));
    boundary.neighbors = neighbor_parts_;
    *this = {};
  }

 private:
  Neighbor& neighbor_of(PartId part) { return neighbors_[index_of(part)]; }
  std::size_t index_of(PartId part) const {
    const auto it = std::lower_bound(neighbor_parts_.begin(), neighbor_parts_.end(), part);
    return static_cast<std::size_t>(it - neighbor_parts_.begin());
  }

  void list_neighbors() {
    neighbor_parts_ = residence_.parts;
    sort_unique(neighbor_parts_);
    neighbors_.resize(neighbor_parts_.size());
    for (std::size_t k = 0; k < neighbors_.size(); ++k) neighbors_[k].part = neighbor_parts_[k];
  }

  // positions_[i] is the position of a shared vertex in the list of residence_.parts[i].
  void number_positions() {
    slot_.assign(part_->vertex_count(), kNone);
    positions_.resize(residence_.parts.size());
    for (std::uint32_t s = 0; s < residence_.verts.size(); ++s) {
      slot_[residence_.verts[s]] = s;
      for (std::uint32_t i = residence_.first[s]; i < residence_.first[s + 1]; ++i) {
        Neighbor& neighbor = neighbor_of(residence_.parts[i]);
        positions_[i] = static_cast<std::uint32_t>(neighbor.verts.size());
        neighbor.verts.push_back(residence_.verts[s]);
      }
    }
  }

  // Calls visit(neighbour, key) for every part that has all of these shared vertices.
  template <class Visit>
  void for_each_common_part(std::span<const std::uint32_t> verts, const Visit& visit) const {
    const std::uint32_t s = slot_[verts[0]];
    for (std::uint32_t i = residence_.first[s]; i < residence_.first[s + 1]; ++i) {
      FaceKey key{positions_[i], kNone, kNone, kNone};
      bool common = true;
      for (std::size_t k = 1; k < verts.size() && common; ++k) {
        key[k] = position_in(slot_[verts[k]], residence_.parts[i]);
        common = key[k] != kNone;
      }
      if (!common) continue;
      std::sort(key.begin(), key.end());
      visit(index_of(residence_.parts[i]), key);
    }
  }

  std::uint32_t position_in(std::uint32_t slot, PartId part) const {
    for (std::uint32_t i = residence_.first[slot]; i < residence_.first[slot + 1]; ++i)
      if (residence_.parts[i] == part) return positions_[i];
    return kNone;
  }

  void find_candidates() {
    for_each_open_face(*part_, [&](CellPlace face) {
      const auto verts = vertices_of_face(*part_, face);
      const std::size_t count = verts[3] == kNone ? 3 : 4;
      for (std::size_t k = 0; k < count; ++k)
        if (slot_[verts[k]] == kNone) return;
      for_each_common_part(std::span(verts).first(count), [&](std::size_t neighbor, const FaceKey& key) {
        neighbors_[neighbor].faces.push_back({key, face});
      });
    });
    for (const EdgeVerts& edge : edges_between_shared_vertices()) {
      for_each_common_part(edge, [&](std::size_t neighbor, const FaceKey& key) {
        neighbors_[neighbor].edges.push_back({key, edge});
      });
    }
    const auto by_key = [](const auto& a, const auto& b) { return a.key < b.key; };
    for (Neighbor& neighbor : neighbors_) {
      std::sort(neighbor.edges.begin(), neighbor.edges.end(), by_key);
      std::sort(neighbor.faces.begin(), neighbor.faces.end(), by_key);
    }
  }

  std::vector<EdgeVerts> edges_between_shared_vertices() const {
    std::vector<EdgeVerts> edges;
    for (const CellKind kind : kAllCellKinds) {
      const CellShape& shape = shape_of(kind);
      const auto& to_vert = part_->block(kind).to_vert;
      for (std::size_t base = 0; base < to_vert.size(); base += shape.vertex_count) {
        std::uint32_t shared = 0;
        for (std::uint32_t i = 0; i < shape.vertex_count; ++i)
          shared |= static_cast<std::uint32_t>(slot_[to_vert[base + i]] != kNone) << i;
        if ((shared & (shared - 1)) == 0) continue;
        for (const auto& edge : shape.edges()) {
          if ((shared >> edge[0] & shared >> edge[1] & 1) == 0) continue;
          const auto [low, high] = std::minmax(to_vert[base + edge[0]], to_vert[base + edge[1]]);
          edges.push_back({low, high});
        }
      }
    }
    sort_unique(edges);
    return edges;
  }

  template <class Entity>
  static void put_keys(MessageWriter& writer, const std::vector<MaybeShared<Entity>>& candidates) {
    const std::span<FaceKey> room = writer.put_room<FaceKey>(candidates.size());
    for (std::size_t i = 0; i < candidates.size(); ++i) room[i] = candidates[i].key;
  }

  // Both are ascending.
  template <class Entity>
  static void keep_common(std::vector<MaybeShared<Entity>>& own, std::span<const FaceKey> theirs) {
    auto it = theirs.begin();
    std::erase_if(own, [&](const MaybeShared<Entity>& candidate) {
      while (it != theirs.end() && *it < candidate.key) ++it;
      return it == theirs.end() || *it != candidate.key;
    });
  }

  template <class Entity>
  GrowingArray<Entity> list_entities(std::vector<MaybeShared<Entity>> Neighbor::*candidates) const {
    std::vector<Entity> entities;
    for (const Neighbor& neighbor : neighbors_)
      for (const auto& candidate : neighbor.*candidates) entities.push_back(candidate.entity);
    sort_unique(entities);
    return GrowingArray<Entity>(std::span<const Entity>(entities));
  }

  template <class Entity>
  static std::vector<std::uint32_t> places_in(const GrowingArray<Entity>& entities,
                                              const std::vector<MaybeShared<Entity>>& candidates) {
    std::vector<std::uint32_t> places(candidates.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
      const auto it = std::lower_bound(entities.begin(), entities.end(), candidates[i].entity);
      places[i] = static_cast<std::uint32_t>(it - entities.begin());
    }
    return places;
  }

  template <class Entity>
  static void add_links(const std::vector<MaybeShared<Entity>>& own, PartId part, std::span<const std::uint32_t> theirs,
                        std::vector<std::pair<Entity, Copy>>& links) {
    TETLOOM_ASSERT(theirs.size() == own.size());
    for (std::size_t i = 0; i < own.size(); ++i) links.push_back({own[i].entity, {part, theirs[i]}});
  }

  template <class Entity>
  static void fill(SharedEntities<Entity>& shared, std::vector<std::pair<Entity, Copy>> links) {
    std::sort(links.begin(), links.end());
    shared = {};
    shared.copies.reserve(links.size());
    for (const auto& [entity, copy] : links) {
      if (shared.entities.empty() || shared.entities.back() != entity) {
        shared.entities.push_back(entity);
        shared.first.push_back(static_cast<std::uint32_t>(shared.copies.size()));
      }
      shared.copies.push_back(copy);
    }
    shared.first.push_back(static_cast<std::uint32_t>(shared.copies.size()));
    shared.entities.shrink_to_fit();
    shared.first.shrink_to_fit();
  }

  const PartMesh* part_ = nullptr;
  Residence residence_;
  std::vector<PartId> neighbor_parts_;
  std::vector<Neighbor> neighbors_;
  std::vector<std::uint32_t> slot_;       // of local vertices among the shared ones
  std::vector<std::uint32_t> positions_;  // beside residence_.parts
};

}  // namespace

Links links_of_neighbors(const PartitionedMesh& mesh) {
  return neighbour_links(
      [&mesh](PartId part) { return std::span<const PartId>(mesh.parts.at(part).boundary.neighbors); });
}

void link_parts(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace) {
  const TaskRunner deaf_runner = runner.uninterruptible();
  PerPart<Residence> residence = find_residence(mesh, deaf_runner);
  PerPart<PartLinker> linkers(mesh.part_count(), mesh.local());
  deaf_runner.for_each(mesh.local().size(), [&](std::size_t i) {
    const PartId part = mesh.local()[i];
    linkers.at(part).begin(mesh.parts.at(part).mesh, std::move(residence.at(part)));
  });
  // The linkers are emptied by their last step, while neighbours may still ask for links.
  PerPart<std::vector<PartId>> neighbors(mesh.part_count(), mesh.local());
  for (const PartId part : mesh.local()) neighbors.at(part) = linkers.at(part).neighbor_parts();
  const Links links = neighbour_links([&](PartId part) { return std::span<const PartId>(neighbors.at(part)); });
  const std::vector<Step> steps{
      {"link: send vertices", [&](PartTask& task) { linkers[task].send_vertices(task); }, links, {}},
      {"link: vertices",
       [&](PartTask& task) { linkers[task].link_vertices(task, mesh.parts[task].boundary.vertices); },
       links,
       {}},
      {"link: match edges and faces",
       [&](PartTask& task) { linkers[task].match_candidates(task, mesh.parts[task].boundary); },
       links,
       {}},
      {"link: edges and faces",
       [&](PartTask& task) { linkers[task].link_edges_and_faces(task, mesh.parts[task].boundary); },
       {},
       {}}};
  Schedule(*mesh.communicator, runner, mesh.part_count(), trace).run(steps, true);
}

}  // namespace tetloom
