#include "mesher/parts/fill_in_parts.hpp"

#include <algorithm>
#include <cmath>

#include "mesher/parts/borders.hpp"
#include "mesher/parts/improve_part.hpp"
#include "mesher/parts/lattice_steps.hpp"
#include "mesher/parts/mend_surface.hpp"
#include "mesher/parts/optimize_part.hpp"
#include "mesher/parts/part_meshes.hpp"
#include "mesher/parts/shell_steps.hpp"
#include "mesher/parts/strips.hpp"
#include "mesher/volume/filling_messages.hpp"
#include "threading/agreement.hpp"
#include "threading/exchange.hpp"

namespace tetloom::parts {

namespace {

constexpr std::size_t kMostRoundsOfAsking = 8;
constexpr std::size_t kMostMissing = 3000;  // triangles: more say that the surface is not sound

class Filler {
 public:
  Filler(const SharedInput& input, Communicator& communicator, const TaskRunner& runner, Trace* trace)
      : input_(input),
        communicator_(communicator),
        runner_(runner),
        schedule_(communicator, runner, input.decomposition.part_count(), trace),
        states_(input.decomposition.part_count(), schedule_.local_parts()) {
    for (std::size_t p = 0; p < states_.part_count(); ++p) all_work_ += input.decomposition.work(PartId(p));
    links_ = neighbour_links([this](PartId part) { return input_.decomposition.neighbors(part); });
  }

  FilledParts run(bool keep_parts) {
    make_tets();
    ask_others();
    if (!any_fault()) {
      mend();
      if (!any_fault()) optimize();
    }
    FilledParts result;
    take_figures(result);
    if (result.fault.any()) return result;
    const HandsOn what = keep_parts ? HandsOn::TetsAndTriangles : HandsOn::Tets;
    HandedOn handed_on = hand_on_parts(input_, states_, what, communicator_, runner_);
    if (!keep_parts) {
      result.filling = put_together(input_.filling.complex.points, std::move(handed_on), runner_);
      return result;
    }
    result.parts = std::move(handed_on.parts);
    result.new_points = handed_on.new_points;
    return result;
  }

 private:
  enum class Sends { Nothing, Messages };

  // `percent`: of the whole time, roughly, for progress; all steps together take less than 100.
  Step step(const char* name, int percent, Sends sends, std::function<void(PartState&, PartTask&)> body) {
    Step made;
    made.name = name;
    percents_.push_back(percent);
    made.body = [this, percent, body = std::move(body)](PartTask& task) {
      PartState& state = states_[task];
      if (!state.fault.any()) body(state, task);
      runner_.advance(progress_of(task.part(), percent));
    };
    if (sends == Sends::Messages) made.links = links_;
    made.work = [this](PartId part) { return input_.decomposition.work(part); };
    return made;
  }

  std::uint64_t progress_of(PartId part, int percent) const {
    return input_.filling.progress.part_of_whole(percent, input_.decomposition.work(part) / all_work_);
  }

  void run_steps(const std::vector<Step>& steps) {
    schedule_.run(steps);
    std::uint64_t advanced = 0;
    for (const PartId part : states_.local())
      for (const int percent : percents_) advanced += progress_of(part, percent);
    input_.filling.progress.note(advanced);
    percents_.clear();
  }

  void make_tets() {
    std::vector<Step> steps;
    steps.push_back(step("points", 14, Sends::Messages, [&](PartState& s, PartTask& t) { find_points(input_, s, t); }));
    if (input_.is_graded())
      steps.push_back(
          step("grading", 3, Sends::Messages, [&](PartState& s, PartTask& t) { drop_near_finer(input_, s, t); }));
    steps.push_back(step("core", 8, Sends::Messages, [&](PartState& s, PartTask& t) { make_core(input_, s, t); }));
    const auto shell = [&](PartState& s, PartTask& t) {
      take_shell_points(s, t);
      make_shell(input_, s, t.part(), t.runner());
    };
    steps.push_back(step("shell", 26, Sends::Nothing, shell));
    run_steps(steps);
  }

  // Tets whose balls reach beyond what their part knows are asked about where they reach to.
  void ask_others() {
    for (std::size_t round = 0; round < kMostRoundsOfAsking && !any_fault(); ++round) {
      std::vector<Message> questions;
      run_on_all(communicator_, [&] {
        for (const PartId part : states_.local()) ask(part, questions);
      });
      std::array<std::int64_t, 1> count{static_cast<std::int64_t>(questions.size())};
      communicator_.sum(count);
      if (count[0] == 0) return;
      ++rounds_;
      questions = exchange_all(std::move(questions));
      std::vector<Message> answers;
      run_on_all(communicator_, [&] { answers = answer(questions); });
      if (!take_answers(exchange_all(std::move(answers)))) return;
    }
  }

  std::vector<Message> exchange_all(std::vector<Message> messages) {
    return exchange(communicator_, std::move(messages),
                    [&](PartId part) { return communicator_.rank_of(part, input_.decomposition.part_count()); });
  }

  void ask(PartId part, std::vector<Message>& questions) {
    const PartState& state = states_.at(part);
    if (state.doubts.empty()) return;
    if (rounds_ == 0) asked_ += state.doubts.size();
    std::vector<std::vector<Doubt>> part_to_doubts(input_.decomposition.part_count());
    for (const Doubt& doubt : state.doubts) {
      const Vec3 reach{doubt.radius, doubt.radius, doubt.radius};
      input_.decomposition.for_each_in({doubt.center - reach, doubt.center + reach}, [&](PartId other) {
        if (other != part) part_to_doubts[other.value].push_back(doubt);
      });
    }
    for (std::size_t other = 0; other < part_to_doubts.size(); ++other) {
      if (part_to_doubts[other].empty()) continue;
      MessageWriter writer;
      writer.put_array<Doubt>(part_to_doubts[other]);
      questions.push_back({part, PartId(other), 0, writer.take()});
    }
  }

  std::vector<Message> answer(const std::vector<Message>& questions) {
    std::vector<Message> answers(questions.size());
    runner_.for_each(questions.size(), [&](std::size_t i) {
      const Message& question = questions[i];
      const auto doubts = MessageReader(question.bytes).get_view<Doubt>();
      const std::vector<ShellPoint> found = find_points_in(input_, states_.at(question.to), question.to, doubts);
      MessageWriter writer;
      writer.put_array<ShellPoint>(found);
      answers[i] = {question.to, question.from, 0, writer.take()};
    });
    return answers;
  }

  // Whether any part has learnt something new, and has made its shell anew then.
  bool take_answers(const std::vector<Message>& answers) {
    std::vector<std::vector<ShellPoint>> part_to_points(input_.decomposition.part_count());
    for (const Message& message : answers) {
      const auto points = MessageReader(message.bytes).get_view<ShellPoint>();
      auto& list = part_to_points[message.to.value];
      list.insert(list.end(), points.begin(), points.end());
    }
    const auto local = states_.local();
    std::vector<char> learnt(local.size(), 0);
    run_on_all(communicator_, [&] {
      runner_.for_each(local.size(), [&](std::size_t i) {
        PartState& state = states_.at(local[i]);
        state.doubts.clear();
        if (!add_shell_points(input_, state, part_to_points[local[i].value])) return;
        make_shell(input_, state, local[i], runner_);
        learnt[i] = 1;
      });
    });
    std::array<std::int64_t, 1> count{std::count(learnt.begin(), learnt.end(), 1)};
    communicator_.sum(count);
    return count[0] > 0;
  }

  // Triangles that are no faces of the tets.
  void mend() {
    const std::vector<std::uint32_t> missing = gather_missing();
    if (missing.empty()) return;
    const std::vector<Cluster> clusters = make_clusters(input_, missing);
    std::vector<Message> answers;
    for (std::uint32_t c = 0; c < clusters.size(); ++c) send_neighborhood(clusters[c], c, answers);
    std::vector<Neighborhood> around(clusters.size());
    for (const Message& message : exchange_all(std::move(answers))) {
      MessageReader reader(message.bytes);
      Neighborhood& one = around[reader.get<std::uint64_t>()];
      const auto points = reader.get_view<ShellPoint>();
      const auto pure = reader.get_view<PureSite>();
      one.points.insert(one.points.end(), points.begin(), points.end());
      one.pure.insert(one.pure.end(), pure.begin(), pure.end());
    }
    patches_.resize(clusters.size());
    run_on_all(communicator_, [&] {
      runner_.for_each(clusters.size(), [&](std::size_t c) {
        if (!states_.is_local(clusters[c].part)) return;
        patches_[c] = recover_cluster(input_, clusters[c], std::move(around[c]), runner_);
      });
    });
    take_patches(clusters);
  }

  std::vector<std::uint32_t> gather_missing() {
    MessageWriter writer;
    std::vector<std::uint32_t> own;
    for (const PartId part : states_.local()) {
      PartState& state = states_.at(part);
      state.figures.missing_triangles = state.missing.size();
      own.insert(own.end(), state.missing.begin(), state.missing.end());
    }
    writer.put_array<std::uint32_t>(own);
    std::vector<std::uint32_t> all;
    for (const Bytes& bytes : communicator_.all_gather(writer.take())) {
      const auto missing = MessageReader(bytes).get_view<std::uint32_t>();
      all.insert(all.end(), missing.begin(), missing.end());
    }
    std::sort(all.begin(), all.end());
    if (all.size() > kMostMissing) {
      for (const PartId part : states_.local())
        states_.at(part).fault.message = std::to_string(all.size()) + " triangles of the surface are missing";
      return {};
    }
    return all;
  }

  void send_neighborhood(const Cluster& cluster, std::uint32_t index, std::vector<Message>& messages) {
    input_.decomposition.for_each_in(cluster.box, [&](PartId part) {
      if (!states_.is_local(part)) return;
      const Neighborhood found = find_neighborhood(input_, states_.at(part), part, cluster);
      MessageWriter writer;
      writer.put(std::uint64_t{index});
      writer.put_array<ShellPoint>(found.points);
      writer.put_array<PureSite>(found.pure);
      messages.push_back({part, cluster.part, index, writer.take()});
    });
  }

  void take_patches(const std::vector<Cluster>& clusters) {
    std::vector<TetKeys> own;
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      if (!states_.is_local(clusters[c].part)) continue;
      PartState& state = states_.at(clusters[c].part);
      own.insert(own.end(), patches_[c].removed.begin(), patches_[c].removed.end());
      state.patches.push_back(static_cast<std::uint32_t>(c));
      state.figures.recovery_points += patches_[c].new_points.size();
      if (!patches_[c].recovered) state.fault.message = "triangles of the surface could not be recovered";
    }
    MessageWriter writer;
    writer.put_array<TetKeys>(own);
    for (const Bytes& bytes : communicator_.all_gather(writer.take())) {
      const auto tets = MessageReader(bytes).get_view<TetKeys>();
      removed_.insert(removed_.end(), tets.begin(), tets.end());
    }
    std::sort(removed_.begin(), removed_.end());
  }

  void optimize() {
    std::vector<Step> steps;
    const auto inside = [&](PartState& s, PartTask& t) {
      join_shell(input_, s, removed_);
      for (const std::uint32_t c : s.patches) put_in_patch(s, t.part(), patches_[c], input_.only_region);
      name_regions(input_, s);
      if (s.fault.any()) return;
      optimize_inside(input_, s, t.part(), t.runner());
      send_poor(input_, s, t);
    };
    steps.push_back(step("optimize", 22, Sends::Messages, inside));
    for (std::size_t round = 0; round < kStripRounds; ++round) {
      steps.push_back(step("share", 1, Sends::Messages, [&](PartState& s, PartTask& t) { send_shared(input_, s, t); }));
      steps.push_back(
          step("claim", 1, Sends::Messages, [&, round](PartState& s, PartTask& t) { send_strips(s, round, t); }));
      const auto take = [&, is_last = round + 1 == kStripRounds](PartState& s, PartTask& t) {
        take_strips(input_, s, t);
        is_last ? send_borders(s, t) : send_poor(input_, s, t);
      };
      steps.push_back(step("strips", 3, Sends::Messages, take));
    }
    const auto finish = [&](PartState& s, PartTask& t) {
      take_borders(s, t);
      finish_part(input_, s, t.part(), t.runner());
    };
    steps.push_back(step("finish", 8, Sends::Nothing, finish));
    run_steps(steps);
    if (all_faces_met()) return;
    for (const PartId part : states_.local()) states_.at(part).fault.message = "the faces of parts do not fit together";
  }

  // What the neighbours have to know of a part in the end: its open faces and its points of the surface.
  void send_borders(PartState& state, PartTask& task) {
    name_open_faces(state);
    const std::vector<std::uint32_t> points = find_surface_points(state);
    for (const PartId other : input_.decomposition.neighbors(task.part())) {
      const Box3& box = input_.decomposition.box(other);
      MessageWriter writer;
      writer.put_array<std::uint64_t>(open_faces_near(state, box));
      writer.put_array<std::uint32_t>(surface_points_near(input_, points, box));
      task.send(other, writer.take());
    }
  }

  void take_borders(PartState& state, PartTask& task) {
    std::vector<std::span<const std::uint64_t>> names;
    for (const Message& message : task.inbox()) {
      MessageReader reader(message.bytes);
      names.push_back(reader.get_view<std::uint64_t>());
      const auto points = reader.get_view<std::uint32_t>();
      state.surface_elsewhere.insert(state.surface_elsewhere.end(), points.begin(), points.end());
    }
    check_open_faces(state, names);
  }

  // Strips may have brought together parts that do not tell each other of all they have: what they have not been told
  // of is asked of all.
  bool all_faces_met() {
    MessageWriter writer;
    std::vector<std::uint64_t> names;
    for (const PartId part : states_.local()) {
      const auto& unmet = states_.at(part).unmet_names;
      names.insert(names.end(), unmet.begin(), unmet.end());
    }
    writer.put_array<std::uint64_t>(names);
    names.clear();
    for (const Bytes& bytes : communicator_.all_gather(writer.take())) {
      const auto unmet = MessageReader(bytes).get_view<std::uint64_t>();
      names.insert(names.end(), unmet.begin(), unmet.end());
    }
    std::sort(names.begin(), names.end());
    names.erase(std::unique(names.begin(), names.end()), names.end());
    std::vector<std::int64_t> counts(names.size(), 0);
    for (const PartId part : states_.local()) {
      const auto& open = states_.at(part).open_names;
      for (std::size_t i = 0; i < names.size(); ++i) {
        const auto [begin, end] = std::equal_range(open.begin(), open.end(), names[i]);
        counts[i] += end - begin;
      }
    }
    communicator_.sum(counts);
    return std::all_of(counts.begin(), counts.end(), [](std::int64_t count) { return count == 2; });
  }

  bool any_fault() {
    std::array<std::int64_t, 1> count{0};
    for (const PartId part : states_.local()) count[0] += states_.at(part).fault.any();
    communicator_.sum(count);
    return count[0] > 0;
  }

  // What all ranks know in the end: the figures of all parts, in their order, and what became of the surface.
  void take_figures(FilledParts& result) {
    MessageWriter writer;
    for (const PartId part : states_.local()) {
      const PartState& state = states_.at(part);
      volume::put_figures(writer, state.figures);
      volume::put_text(writer, state.fault.message);
      writer.put(static_cast<std::uint64_t>(state.seen_sides));
      writer.put_array<ChangedTriangle>(state.changed_triangles);
    }
    result.figures.parts.parts = states_.part_count();
    result.figures.parts.asking_rounds = rounds_;
    result.tri_to_vert = input_.filling.complex.tri_to_vert;
    std::size_t seen = 0, wanted = 0;
    for (const Bytes& bytes : communicator_.all_gather(writer.take())) {
      for (MessageReader reader(bytes); !reader.at_end();) {
        result.figures.add(volume::get_figures(reader));
        const std::string fault = volume::get_text(reader);
        if (!result.fault.any()) result.fault.message = fault;
        seen += reader.get<std::uint64_t>();
        for (const ChangedTriangle& changed : reader.get_view<ChangedTriangle>())
          result.tri_to_vert[changed.triangle] = changed.verts;
      }
    }
    std::array<std::int64_t, 1> asked{static_cast<std::int64_t>(asked_)};
    communicator_.sum(asked);
    result.figures.parts.asked = static_cast<std::size_t>(asked[0]);
    for (const FaceSides& sides : input_.filling.complex.tri_to_sides)
      wanted += std::size_t{sides.front.valid()} + std::size_t{sides.back.valid()};
    if (!result.fault.any() && seen != wanted) result.fault.message = "sides of the surface were left empty";
  }

  const SharedInput& input_;
  Communicator& communicator_;
  const TaskRunner& runner_;
  Schedule schedule_;
  PerPart<PartState> states_;
  Links links_;
  std::vector<Patch> patches_;    // per cluster
  std::vector<TetKeys> removed_;  // tets of the shell, of any part, that are no more, ascending
  double all_work_ = 0;
  std::vector<int> percents_;  // of the steps that are about to run
  std::size_t rounds_ = 0;
  std::size_t asked_ = 0;
};

std::uint32_t only_region_of(const volume::Complex& complex) {
  return complex.regions.size() == 1 ? complex.regions[0] : kNone;
}

}  // namespace

std::optional<FilledParts> fill_in_parts(const volume::FillingInput& input, const PartsRequest& request,
                                         const TaskRunner& runner) {
  lattice::LatticeRequest lattice{&input.tree,  input.complex.tri_to_sides, {}, &input.sizes, input.lattice,
                                  input.attempt};
  for (const Vec3& x : input.complex.points) lattice.box.add(x);
  const std::unique_ptr<Communicator> own = request.communicator ? nullptr : make_thread_communicator();
  Communicator& communicator = own ? *own : *request.communicator;
  std::optional<lattice::LatticeCells> cells;
  std::optional<Decomposition> decomposition;
  std::optional<PartSurface> surface;
  std::optional<tets::TriangleIndex> triangles;
  run_on_all(communicator, [&] {
    cells.emplace(lattice, runner);
    const double parts = std::round(estimate_tets(*cells) / request.tets_per_part);
    if (!(parts >= 2)) return;
    decomposition.emplace(*cells, static_cast<std::size_t>(std::min(parts, 1e5)));
    surface.emplace(input.complex, input.sizes, *decomposition, kShellReach, runner);
    triangles.emplace(input.complex.tri_to_vert, input.complex.points.size());
  });
  if (!decomposition) return std::nullopt;
  const SharedInput shared{
      input, *cells, *decomposition, *surface, *triangles, lattice.box, only_region_of(input.complex)};
  return Filler(shared, communicator, runner, request.trace).run(request.keep_parts || request.communicator);
}

}  // namespace tetloom::parts
