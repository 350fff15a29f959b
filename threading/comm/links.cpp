// Who sends to whom.
#include <algorithm>
#include <utility>

#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {

namespace {

using Pair = std::pair<PartId, PartId>;  // receiver, sender

void put_pairs(const PerPart<std::vector<PartId>>& receivers, MessageWriter& writer) {
  for (const PartId from : receivers.local())
    for (const PartId to : receivers.at(from)) {
      writer.put(to);
      writer.put(from);
    }
}

void take_pairs(MessageReader& reader, const PerPart<std::vector<PartId>>& local, std::vector<Pair>& pairs) {
  while (!reader.at_end()) {
    const auto to = reader.get<PartId>(), from = reader.get<PartId>();
    TETLOOM_ASSERT(to.value < local.part_count());
    if (local.is_local(to)) pairs.push_back({to, from});
  }
}

/// The senders of each local part, one part after the other.
struct SenderLists {
  std::uint32_t first_part = 0;
  std::vector<std::size_t> begins;
  std::vector<PartId> senders;

  std::span<const PartId> of(PartId part) const {
    const std::size_t local = part.value - first_part;
    return std::span(senders).subspan(begins[local], begins[local + 1] - begins[local]);
  }
};

SenderLists make_sender_lists(std::span<const PartId> local, std::span<const Pair> pairs) {
  SenderLists lists;
  lists.first_part = local.empty() ? 0 : local.front().value;
  lists.begins.assign(local.size() + 1, 0);
  for (const auto& [to, from] : pairs) {
    ++lists.begins[to.value - lists.first_part + 1];
    lists.senders.push_back(from);
  }
  for (std::size_t i = 0; i < local.size(); ++i) lists.begins[i + 1] += lists.begins[i];
  return lists;
}

}  // namespace

Links neighbour_links(std::function<std::span<const PartId>(PartId)> neighbours) { return {neighbours, neighbours}; }

Links directed_links(Communicator& communicator, const PerPart<std::vector<PartId>>& receivers) {
  std::vector<Pair> pairs;
  gather(
      communicator, [&](MessageWriter& writer) { put_pairs(receivers, writer); },
      [&](MessageReader& reader) { take_pairs(reader, receivers, pairs); });
  std::shared_ptr<const SenderLists> lists;
  run_on_all(communicator, [&] {
    std::sort(pairs.begin(), pairs.end());
    lists = std::make_shared<const SenderLists>(make_sender_lists(receivers.local(), pairs));
  });
  return {[&receivers](PartId part) { return std::span<const PartId>(receivers.at(part)); },
          [lists](PartId part) { return lists->of(part); }};
}

}  // namespace tetloom
