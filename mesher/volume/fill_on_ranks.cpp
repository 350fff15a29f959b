#include "mesher/volume/fill_on_ranks.hpp"

#include <algorithm>
#include <numeric>

#include "mesher/volume/filling_messages.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/codec.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::volume {

namespace {

// Largest first, each to the rank that has least; the same on all ranks.
std::vector<int> deal_to_ranks(std::span<const std::size_t> complexes, std::span<const FillingProgress> progress,
                               int ranks) {
  std::vector<std::size_t> order(complexes.begin(), complexes.end());
  std::ranges::stable_sort(order,
                           [&](std::size_t a, std::size_t b) { return progress[a].whole() > progress[b].whole(); });
  std::vector<std::uint64_t> loads(static_cast<std::size_t>(ranks), 0);
  std::vector<int> owner(progress.size(), -1);
  for (const std::size_t i : order) {
    const auto least = std::ranges::min_element(loads);
    *least += progress[i].whole();
    owner[i] = static_cast<int>(least - loads.begin());
  }
  return owner;
}

void share_results(Communicator& communicator, std::span<const std::size_t> own, std::vector<VolumeParts>& filled) {
  const auto put = [&](MessageWriter& writer) {
    for (const std::size_t i : own) {
      writer.put(static_cast<std::uint64_t>(i));
      writer.put(filled[i].new_points);
      writer.put(static_cast<std::uint64_t>(filled[i].part_count));
      put_diagnostics(writer, filled[i].errors);
      put_diagnostics(writer, filled[i].warnings);
      put_figures(writer, filled[i].figures);
    }
  };
  const auto take = [&](MessageReader& reader) {
    while (!reader.at_end()) {
      VolumeParts& complex = filled[reader.get<std::uint64_t>()];
      complex.new_points = reader.get<std::uint64_t>();
      complex.part_count = reader.get<std::uint64_t>();
      complex.errors = get_diagnostics(reader);
      complex.warnings = get_diagnostics(reader);
      complex.figures = get_figures(reader);
    }
  };
  gather(communicator, put, take);
}

}  // namespace

std::vector<VolumeParts> fill_on_ranks(const FillingPlan& plan, std::span<const Complex> complexes,
                                       std::span<FillingProgress> progress, Communicator& communicator,
                                       const TaskRunner& runner) {
  const bool is_alone = communicator.rank_count() == 1;
  std::vector<VolumeParts> filled(complexes.size());
  std::vector<std::size_t> left, own;
  for (std::size_t i = 0; i < complexes.size(); ++i) {
    if (!is_alone && !plan.options.worker_only)
      filled[i] = fill_complex_in_parts(plan, complexes[i], progress[i], communicator, runner);
    if (filled[i].part_count == 0) left.push_back(i);
  }
  const std::vector<int> owner = deal_to_ranks(left, progress, communicator.rank_count());
  std::vector<double> work;
  for (const std::size_t i : left) {
    if (owner[i] != communicator.rank()) continue;
    own.push_back(i);
    work.push_back(static_cast<double>(progress[i].whole()));
  }
  run_on_all(communicator, [&] {
    runner.for_each_largest_first(work, [&](std::size_t k) {
      const std::size_t i = own[k];
      const FillingFigures before = std::move(filled[i].figures);
      filled[i] = fill_complex(plan, complexes[i], progress[i], is_alone, runner);
      filled[i].figures.add(before);
      progress[i].reach(FillingStep::Done, runner);
    });
    for (FillingProgress& one : progress) one.reach(FillingStep::Done, runner);
  });
  share_results(communicator, own, filled);
  return filled;
}

std::vector<PartMesh> send_home(std::vector<NumberedPart>&& parts, std::size_t part_count, Communicator& communicator) {
  const auto rank_of = [&](PartId part) { return communicator.rank_of(part, part_count); };
  const auto pack = [&] {
    std::vector<Message> messages;
    for (const NumberedPart& part : parts) {
      if (rank_of(part.number) == communicator.rank()) continue;
      MessageWriter writer;
      put_part(writer, part.part);
      messages.push_back({part.number, part.number, 0, writer.take()});
    }
    std::erase_if(parts, [&](const NumberedPart& part) { return rank_of(part.number) != communicator.rank(); });
    return messages;
  };
  for (Message& message : exchange(communicator, pack, rank_of)) {
    MessageReader reader(message.bytes);
    parts.push_back({message.to, get_part(reader)});
  }
  std::ranges::sort(parts, {}, &NumberedPart::number);
  std::vector<PartMesh> own;
  for (NumberedPart& part : parts) own.push_back(std::move(part.part));
  return own;
}

}  // namespace tetloom::volume
