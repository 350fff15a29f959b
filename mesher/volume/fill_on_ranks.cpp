#include "mesher/volume/fill_on_ranks.hpp"

#include <algorithm>
#include <optional>

#include "core/base/codec.hpp"
#include "core/base/lists.hpp"
#include "mesher/parts/decomposition.hpp"
#include "mesher/volume/copied_filling.hpp"
#include "mesher/volume/filling_messages.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"
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

class RankFiller {
 public:
  RankFiller(const FillingPlan& plan, std::span<const Complex> complexes, std::span<FillingProgress> progress,
             const SharedWork& work)
      : plan_(plan),
        complexes_(complexes),
        progress_(progress),
        work_(work),
        communicator_(work.ranks()),
        runner_(work.runner()),
        is_alone_(work.rank_count() == 1),
        filled_(complexes.size()) {}

  std::vector<VolumeParts> run() {
    std::vector<std::optional<ComplexCopy>> copies;
    run_on_all(communicator_, [&] { copies = find_copies(plan_, complexes_, runner_); });
    std::vector<std::size_t> originals;
    for (std::size_t i = 0; i < complexes_.size(); ++i)
      if (!copies[i]) originals.push_back(i);
    fill(originals);
    fill(place(copies));
    run_on_all(communicator_, [&] {
      for (FillingProgress& one : progress_) one.reach(FillingStep::Done, runner_);
    });
    return std::move(filled_);
  }

 private:
  void fill(const std::vector<std::size_t>& numbers) {
    std::vector<std::size_t> left, own;
    for (const std::size_t i : numbers) {
      if (!is_alone_ && !plan_.options.worker_only && !is_one_part(i))
        filled_[i] = fill_complex_in_parts(plan_, complexes_[i], progress_[i], work_);
      if (filled_[i].part_count == 0) left.push_back(i);
    }
    const std::vector<int> owner = deal_to_ranks(left, progress_, communicator_.rank_count());
    std::vector<double> work;
    for (const std::size_t i : left) {
      if (owner[i] != communicator_.rank()) continue;
      own.push_back(i);
      work.push_back(static_cast<double>(progress_[i].whole()));
    }
    run_on_all(communicator_,
               [&] { runner_.for_each_largest_first(work, [&](std::size_t k) { fill_alone(own[k]); }); });
    share_results(communicator_, own, filled_);
  }

  bool is_one_part(std::size_t i) const {
    return parts::is_one_part(static_cast<double>(progress_[i].whole()), complexes_[i].tri_to_vert.size(),
                              plan_.options.tets_per_part);
  }

  void fill_alone(std::size_t i) {
    const FillingFigures before = std::move(filled_[i].figures);
    filled_[i] = fill_complex(plan_, complexes_[i], progress_[i], is_alone_, runner_);
    filled_[i].figures.add(before);
    progress_[i].reach(FillingStep::Done, runner_);
  }

  // Every rank moves the parts that it has; returns the copies that have to be filled for themselves, ascending.
  std::vector<std::size_t> place(const std::vector<std::optional<ComplexCopy>>& copies) {
    std::vector<char> failed(copies.size(), 0);
    run_on_all(communicator_, [&] {
      runner_.for_each(copies.size(), [&](std::size_t i) {
        if (!copies[i]) return;
        const auto& [original, motion] = *copies[i];
        auto copy = copy_filled(plan_, filled_[original], complexes_[original], complexes_[i], motion);
        failed[i] = !copy;
        if (copy) filled_[i] = std::move(*copy);
      });
    });
    std::vector<std::size_t> own;
    for (std::size_t i = 0; i < failed.size(); ++i)
      if (failed[i]) own.push_back(i);
    std::vector<std::size_t> all = gather_lists<std::size_t>(communicator_, own);
    sort_unique(all);
    for (const std::size_t i : all) filled_[i] = {};
    return all;
  }

  const FillingPlan& plan_;
  std::span<const Complex> complexes_;
  std::span<FillingProgress> progress_;
  const SharedWork& work_;
  Communicator& communicator_;
  const TaskRunner& runner_;
  const bool is_alone_;
  std::vector<VolumeParts> filled_;
};

}  // namespace

std::vector<VolumeParts> fill_on_ranks(const FillingPlan& plan, std::span<const Complex> complexes,
                                       std::span<FillingProgress> progress, const SharedWork& work) {
  return RankFiller(plan, complexes, progress, work).run();
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
