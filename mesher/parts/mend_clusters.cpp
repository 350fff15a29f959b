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
    state.figures.missing_triangles = state.shell.missing.size();
    own.insert(own.end(), state.shell.missing.begin(), state.shell.missing.end());
  }
  std::vector<std::uint32_t> all = gather_lists<std::uint32_t>(parts.communicator, own);
  std::sort(all.begin(), all.end());
  return all;
}

void send_near_points(const AllParts& parts, const Cluster& cluster, std::uint32_t index,
                      std::vector<Message>& messages) {
  parts.input.decomposition.for_each_in(cluster.box, [&](PartId part) {
    if (!parts.states.is_local(part)) return;
    const NearPoints found = find_near_points(parts.input, parts.states.at(part).shell, part, cluster);
    MessageWriter writer;
    writer.put(std::uint64_t{index});
    writer.put_array<ShellPoint>(found.points);
    writer.put_array<PureSite>(found.pure);
    messages.push_back({part, cluster.part, index, writer.take()});
  });
}

std::vector<NearPoints> gather_near_points(const AllParts& parts, const std::vector<Cluster>& clusters) {
  const auto pack = [&] {
    std::vector<Message> messages;
    for (std::uint32_t c = 0; c < clusters.size(); ++c) send_near_points(parts, clusters[c], c, messages);
    return messages;
  };
  std::vector<NearPoints> around(clusters.size());
  for (const Message& message : parts.exchange(pack)) {
    MessageReader reader(message.bytes);
    NearPoints& one = around[reader.get<std::uint64_t>()];
    const auto points = reader.get_view<ShellPoint>();
    const auto pure = reader.get_view<PureSite>();
    one.points.insert(one.points.end(), points.begin(), points.end());
    one.pure.insert(one.pure.end(), pure.begin(), pure.end());
  }
  return around;
}

// What recovering all clusters has removed.
std::vector<TetKeys> gather_removed(const AllParts& parts, const std::vector<Cluster>& clusters,
                                    std::span<const RecoveredCluster> recovered) {
  std::vector<TetKeys> own;
  for (std::size_t c = 0; c < clusters.size(); ++c) {
    if (!parts.states.is_local(clusters[c].part)) continue;
    PartState& state = parts.states.at(clusters[c].part);
    own.insert(own.end(), recovered[c].removed.begin(), recovered[c].removed.end());
    state.figures.recovery_points += recovered[c].tets.new_points.size();
    if (!recovered[c].recovered) state.fault.message = "triangles of the surface could not be recovered";
  }
  std::vector<TetKeys> removed = gather_lists<TetKeys>(parts.communicator, own);
  std::sort(removed.begin(), removed.end());
  return removed;
}

// The tets to the parts that are to have them.
PerPart<std::vector<RecoveredTets>> deal_all_recovered(const AllParts& parts, const std::vector<Cluster>& clusters,
                                                       std::span<const RecoveredCluster> recovered) {
  const auto pack = [&] {
    std::vector<Message> messages;
    for (std::uint32_t c = 0; c < clusters.size(); ++c) {
      if (!parts.states.is_local(clusters[c].part)) continue;
      for (const auto& [part, tets] : deal_recovered(parts.input, recovered[c].tets)) {
        MessageWriter writer;
        put(writer, tets);
        messages.push_back({clusters[c].part, part, c, writer.take()});
      }
    }
    return messages;
  };
  PerPart<std::vector<RecoveredTets>> dealt(parts.states.part_count(), parts.states.local());
  for (const Message& message : parts.exchange(pack)) {
    MessageReader reader(message.bytes);
    dealt.at(message.to).push_back(get_recovered(reader));
  }
  return dealt;
}

}  // namespace

Mending mend_surface(const AllParts& parts) {
  Mending mending{{}, {parts.states.part_count(), parts.states.local()}};
  const std::vector<std::uint32_t> missing = gather_missing(parts);
  if (missing.empty()) return mending;
  if (are_too_many(parts, missing.size())) {
    parts.set_fault(std::to_string(missing.size()) + " triangles of the surface are missing");
    return mending;
  }
  const std::vector<Cluster> clusters = make_clusters(parts.input, missing);
  std::vector<NearPoints> around = gather_near_points(parts, clusters);
  std::vector<RecoveredCluster> recovered(clusters.size());
  run_on_all(parts.communicator, [&] {
    parts.runner.for_each(clusters.size(), [&](std::size_t c) {
      if (!parts.states.is_local(clusters[c].part)) return;
      recovered[c] = recover_cluster(parts.input, clusters[c], std::move(around[c]), parts.runner);
    });
  });
  mending.removed = gather_removed(parts, clusters, recovered);
  mending.recovered = deal_all_recovered(parts, clusters, recovered);
  return mending;
}

}  // namespace tetloom::parts
