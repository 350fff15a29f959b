#include <algorithm>
#include <tuple>

#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#include "threading/parts/residence.hpp"

namespace tetloom {
namespace {

using OpenVerts = PerPart<std::vector<OpenVertex>>;

constexpr std::size_t kBucketsPerRank = 64;

struct Resident {
  std::uint64_t global;
  PartId part;
  std::uint32_t padding = 0;
  friend auto operator<=>(const Resident& a, const Resident& b) {
    return std::tie(a.global, a.part) <=> std::tie(b.global, b.part);
  }
};

// Part `to` shares the vertex `global` with part `with`.
struct RemoteCopy {
  std::uint64_t global;
  PartId to, with;
  friend auto operator<=>(const RemoteCopy& a, const RemoteCopy& b) {
    return std::tie(a.to, a.global, a.with) <=> std::tie(b.to, b.global, b.with);
  }
};

std::vector<OpenVertex> find_open_vertices(const PartMesh& part) {
  std::vector<OpenVertex> open_vertices;
  std::vector<bool> seen(part.vertex_count(), false);
  for_each_open_face(part, [&](CellPlace face) {
    for (const std::uint32_t v : vertices_of_face(part, face)) {
      if (v == kNone || seen[v]) continue;
      seen[v] = true;
      open_vertices.push_back({part.vert_to_global[v], v});
    }
  });
  std::sort(open_vertices.begin(), open_vertices.end(),
            [](const OpenVertex& a, const OpenVertex& b) { return a.global < b.global; });
  return open_vertices;
}

// The range of ids is cut into equal buckets, and these are dealt to ranks in blocks.
class Homes {
 public:
  Homes(Communicator& communicator, const OpenVerts& open_verts)
      : count_(kBucketsPerRank * static_cast<std::size_t>(communicator.rank_count())) {
    std::uint64_t highest = 0;
    for (const PartId part : open_verts.local())
      if (!open_verts.at(part).empty()) highest = std::max(highest, open_verts.at(part).back().global);
    gather(
        communicator, [&](MessageWriter& writer) { writer.put(highest); },
        [&](MessageReader& reader) { highest = std::max(highest, reader.get<std::uint64_t>()); });
    width_ = highest / count_ + 1;
  }
  std::size_t count() const { return count_; }
  int rank_of_bucket(std::size_t bucket) const { return static_cast<int>(bucket / kBucketsPerRank); }
  std::uint64_t begin_of(std::size_t bucket) const { return bucket * width_; }

 private:
  std::size_t count_;
  std::uint64_t width_ = 1;
};

using Residents = std::vector<std::vector<Resident>>;  // by bucket

Residents collect_residents(const OpenVerts& open_verts, const Homes& homes, const TaskRunner& runner) {
  Residents residents(homes.count());
  runner.for_each(residents.size(), [&](std::size_t bucket) {
    const auto before = [](const OpenVertex& a, std::uint64_t global) { return a.global < global; };
    for (const PartId part : open_verts.local()) {
      const std::vector<OpenVertex>& own = open_verts.at(part);
      auto it = std::lower_bound(own.begin(), own.end(), homes.begin_of(bucket), before);
      const auto end = std::lower_bound(it, own.end(), homes.begin_of(bucket + 1), before);
      for (; it != end; ++it) residents[bucket].push_back({it->global, part});
    }
  });
  return residents;
}

// Sends each bucket to its home rank; afterwards this rank holds all residents of its own buckets, and no others.
void send_home(Communicator& communicator, const Homes& homes, Residents& residents) {
  const auto self = PartId(static_cast<std::size_t>(communicator.rank()));
  const auto rank_of = [](PartId rank) { return static_cast<int>(rank.value); };
  const auto pack = [&] {
    std::vector<Message> outgoing;
    for (std::size_t bucket = 0; bucket < residents.size(); ++bucket) {
      const auto home = PartId(static_cast<std::size_t>(homes.rank_of_bucket(bucket)));
      if (home == self || residents[bucket].empty()) continue;
      MessageWriter writer;
      writer.put_array(std::span<const Resident>(residents[bucket]));
      outgoing.push_back({self, home, static_cast<std::uint32_t>(bucket), writer.take()});
      residents[bucket] = std::vector<Resident>();
    }
    return outgoing;
  };
  for (const Message& message : exchange(communicator, pack, rank_of)) {
    const auto view = MessageReader(message.bytes).get_view<Resident>();
    residents[message.step].insert(residents[message.step].end(), view.begin(), view.end());
  }
}

std::vector<RemoteCopy> find_remote_copies(std::vector<Resident> residents) {
  std::sort(residents.begin(), residents.end());
  std::vector<RemoteCopy> copies;
  for (std::size_t begin = 0; begin < residents.size();) {
    std::size_t end = begin + 1;
    while (end < residents.size() && residents[end].global == residents[begin].global) ++end;
    for (std::size_t i = begin; i < end && end > begin + 1; ++i)
      for (std::size_t j = begin; j < end; ++j)
        if (i != j) copies.push_back({residents[i].global, residents[i].part, residents[j].part});
    begin = end;
  }
  std::sort(copies.begin(), copies.end());
  return copies;
}

using RemoteCopies = std::vector<std::vector<RemoteCopy>>;  // by bucket, each sorted by part and global id

// Brings the copies for parts of other ranks there, and those for this rank's parts here.
void send_copies_back(Communicator& communicator, std::size_t part_count, RemoteCopies& copies) {
  const auto self = PartId(static_cast<std::size_t>(communicator.rank()));
  const auto rank_of = [](PartId rank) { return static_cast<int>(rank.value); };
  const auto pack = [&] {
    std::vector<Message> outgoing;
    for (std::size_t bucket = 0; bucket < copies.size(); ++bucket) {
      std::vector<std::vector<RemoteCopy>> by_rank(static_cast<std::size_t>(communicator.rank_count()));
      for (const RemoteCopy& copy : copies[bucket])
        by_rank[static_cast<std::size_t>(communicator.rank_of(copy.to, part_count))].push_back(copy);
      for (std::size_t rank = 0; rank < by_rank.size(); ++rank) {
        if (rank == self.value || by_rank[rank].empty()) continue;
        MessageWriter writer;
        writer.put_array(std::span<const RemoteCopy>(by_rank[rank]));
        outgoing.push_back({self, PartId(rank), static_cast<std::uint32_t>(bucket), writer.take()});
      }
      copies[bucket] = std::move(by_rank[self.value]);
    }
    return outgoing;
  };
  for (const Message& message : exchange(communicator, pack, rank_of)) {
    const auto view = MessageReader(message.bytes).get_view<RemoteCopy>();
    copies[message.step].insert(copies[message.step].end(), view.begin(), view.end());
  }
}

// Buckets ascend with global ids, so the residence comes out in order.
Residence read_residence(PartId part, std::span<const OpenVertex> open_vertices, const RemoteCopies& copies) {
  Residence residence;
  auto vertex = open_vertices.begin();
  const auto before = [](const RemoteCopy& a, PartId id) { return a.to < id; };
  for (const std::vector<RemoteCopy>& bucket : copies) {
    auto it = std::lower_bound(bucket.begin(), bucket.end(), part, before);
    for (; it != bucket.end() && it->to == part; ++it) {
      if (vertex == open_vertices.end() || residence.verts.empty() || vertex->global != it->global) {
        while (vertex->global != it->global) ++vertex;
        residence.verts.push_back(vertex->vert);
        residence.first.push_back(residence.first.back());
      }
      residence.parts.push_back(it->with);
      ++residence.first.back();
    }
  }
  return residence;
}

}  // namespace

PerPart<Residence> find_residence(const OpenVerts& open_verts, Communicator& communicator, const TaskRunner& runner) {
  const std::span<const PartId> local = open_verts.local();
  const Homes homes(communicator, open_verts);
  Residents residents = collect_residents(open_verts, homes, runner);
  if (communicator.rank_count() > 1) send_home(communicator, homes, residents);
  RemoteCopies copies(residents.size());
  runner.for_each(residents.size(),
                  [&](std::size_t b) { copies[b] = find_remote_copies(std::exchange(residents[b], {})); });
  if (communicator.rank_count() > 1) send_copies_back(communicator, open_verts.part_count(), copies);
  PerPart<Residence> residence(open_verts.part_count(), local);
  runner.for_each(local.size(), [&](std::size_t i) {
    residence.at(local[i]) = read_residence(local[i], open_verts.at(local[i]), copies);
  });
  return residence;
}

PerPart<Residence> find_residence(const PartitionedMesh& mesh, const TaskRunner& runner) {
  const std::span<const PartId> local = mesh.local();
  OpenVerts open_verts(mesh.part_count(), local);
  runner.for_each(local.size(),
                  [&](std::size_t i) { open_verts.at(local[i]) = find_open_vertices(mesh.parts.at(local[i]).mesh); });
  return find_residence(open_verts, *mesh.communicator, runner);
}

}  // namespace tetloom
