#include "mesher/parts/mend_clusters.hpp"

#include <algorithm>

#include "threading/comm/collectives.hpp"

namespace tetloom::parts {

namespace {

// More missing triangles than both say that the surface is not sound.
constexpr std::size_t kMissingOfAnySurface = 3000;
constexpr std::size_t kLeastPerMissing = 4;  // triangles of the surface

bool are_too_many(const AllParts& parts, std::size_t missing) {
  const std::size_t all = parts.input.filling.complex.tri_to_vert.size();
  return missing > kMissingOfAnySurface && missing > all / kLeastPerMissing;
}

std::vector<std::uint32_t> gather_missing(const AllParts& parts) {
  std::vector<std::uint32_t> own;
  for (const PartId part : parts.states.local()) {
    PartState& state = parts.states.at(part);
    state.figures.missing_triangles = state.missing.size();
    own.insert(own.end(), state.missing.begin(), state.missing.end());
  }
  std::vector<std::uint32_t> all = gather_lists<std::uint32_t>(parts.communicator, own);
  std::sort(all.begin(), all.end());
  return all;
}

void send_neighborhood(const AllParts& parts, const Cluster& cluster, std::uint32_t index,
                       std::vector<Message>& messages) {
  parts.input.decomposition.for_each_in(cluster.box, [&](PartId part) {
    if (!parts.states.is_local(part)) return;
    const Neighborhood found = find_neighborhood(parts.input, parts.states.at(part), part, cluster);
    MessageWriter writer;
    writer.put(std::uint64_t{index});
    writer.put_array<ShellPoint>(found.points);
    writer.put_array<PureSite>(found.pure);
    messages.push_back({part, cluster.part, index, writer.take()});
  });
}

std::vector<Neighborhood> gather_neighborhoods(const AllParts& parts, const std::vector<Cluster>& clusters) {
  const auto pack = [&] {
    std::vector<Message> messages;
    for (std::uint32_t c = 0; c < clusters.size(); ++c) send_neighborhood(parts, clusters[c], c, messages);
    return messages;
  };
  std::vector<Neighborhood> around(clusters.size());
  for (const Message& message : parts.exchange(pack)) {
    MessageReader reader(message.bytes);
    Neighborhood& one = around[reader.get<std::uint64_t>()];
    const auto points = reader.get_view<ShellPoint>();
    const auto pure = reader.get_view<PureSite>();
    one.points.insert(one.points.end(), points.begin(), points.end());
    one.pure.insert(one.pure.end(), pure.begin(), pure.end());
  }
  return around;
}

// What all patches have removed.
std::vector<TetKeys> gather_removed(const AllParts& parts, const std::vector<Cluster>& clusters,
                                    std::span<const Patch> patches) {
  std::vector<TetKeys> own;
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    if (!parts.states.is_local(clusters[c].part)) continue;
    PartState& state = parts.states.at(clusters[c].part);
    own.insert(own.end(), patches[c].removed.begin(), patches[c].removed.end());
    state.figures.recovery_points += patches[c].tets.new_points.size();
    if (!patches[c].recovered) state.fault.message = "triangles of the surface could not be recovered";
  }
  std::vector<TetKeys> removed = gather_lists<TetKeys>(parts.communicator, own);
  std::sort(removed.begin(), removed.end());
  return removed;
}

// The patches' tets to the parts that are to have them; those of this rank.
std::vector<PatchTets> deal_patches(const AllParts& parts, const std::vector<Cluster>& clusters,
                                    std::span<const Patch> patches) {
  const auto pack = [&] {
    std::vector<Message> messages;
    for (std::uint32_t c = 0; c < clusters.size(); ++c) {
      if (!parts.states.is_local(clusters[c].part)) continue;
      for (const auto& [part, tets] : deal_patch(parts.input, patches[c].tets)) {
        MessageWriter writer;
        put(writer, tets);
        messages.push_back({clusters[c].part, part, c, writer.take()});
      }
    }
    return messages;
  };
  std::vector<PatchTets> dealt;
  for (const Message& message : parts.exchange(pack)) {
    MessageReader reader(message.bytes);
    parts.states.at(message.to).patches.push_back(static_cast<std::uint32_t>(dealt.size()));
    dealt.push_back(get_patch(reader));
  }
  return dealt;
}

}  // namespace

Mending mend_surface(const AllParts& parts) {
  Mending mending;
  const std::vector<std::uint32_t> missing = gather_missing(parts);
  if (missing.empty()) return mending;
  if (are_too_many(parts, missing.size())) {
    parts.set_fault(std::to_string(missing.size()) + " triangles of the surface are missing");
    return mending;
  }
  const std::vector<Cluster> clusters = make_clusters(parts.input, missing);
  std::vector<Neighborhood> around = gather_neighborhoods(parts, clusters);
  std::vector<Patch> patches(clusters.size());
  run_on_all(parts.communicator, [&] {
    parts.runner.for_each(clusters.size(), [&](std::size_t c) {
      if (!parts.states.is_local(clusters[c].part)) return;
      patches[c] = recover_cluster(parts.input, clusters[c], std::move(around[c]), parts.runner);
    });
  });
  mending.removed = gather_removed(parts, clusters, patches);
  mending.patches = deal_patches(parts, clusters, patches);
  return mending;
}

}  // namespace tetloom::parts
