#include "mesher/parts/fill_in_parts.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/codec.hpp"
#include "core/base/free_memory.hpp"
#include "core/base/stopwatch.hpp"
#include "mesher/parts/ask_others.hpp"
#include "mesher/parts/borders.hpp"
#include "mesher/parts/lattice_steps.hpp"
#include "mesher/parts/mend_clusters.hpp"
#include "mesher/parts/optimize_part.hpp"
#include "mesher/parts/part_meshes.hpp"
#include "mesher/parts/shell_steps.hpp"
#include "mesher/parts/strips.hpp"
#include "mesher/volume/filling_messages.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::parts {

namespace {

// The time until the end of the scope.
class AddedTime {
 public:
  explicit AddedTime(double& seconds) : seconds_(seconds) {}
  ~AddedTime() { seconds_ += watch_.lap(); }
  AddedTime(const AddedTime&) = delete;
  AddedTime& operator=(const AddedTime&) = delete;

 private:
  double& seconds_;
  Stopwatch watch_;
};

class Filler {
 public:
  Filler(const SharedInput& input, Communicator& communicator, const TaskRunner& runner, Trace* trace)
      : input_(input),
        communicator_(communicator),
        runner_(runner),
        schedule_(communicator, runner, input.decomposition.part_count(), trace),
        states_(input.decomposition.part_count(), schedule_.local_parts()),
        parts_{input, states_, communicator, runner, trace} {
    for (std::size_t p = 0; p < states_.part_count(); ++p) all_work_ += input.decomposition.work(PartId(p));
    links_ = neighbour_links([this](PartId part) { return input_.decomposition.neighbors(part); });
  }

  FilledParts run() {
    make_tets();
    asked_ = ask_others(parts_);
    if (!parts_.any_fault()) {
      mending_ = mend_surface(parts_);
      if (!parts_.any_fault()) optimize();
    }
    FilledParts result;
    take_figures(result);
    if (!result.fault.any()) hand_on_parts(parts_, result.volume);
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

  // Core and shell of every part.
  void make_tets() {
    std::vector<Step> steps;
    const auto points = [&](PartState& s, PartTask& t) {
      const AddedTime time(s.figures.seconds.points);
      s.shell = find_points(input_, t);
    };
    const auto grading = [&](PartState& s, PartTask& t) {
      const AddedTime time(s.figures.seconds.points);
      drop_near_finer(input_, s.shell, t);
    };
    const auto core = [&](PartState& s, PartTask& t) {
      const AddedTime time(s.figures.seconds.core);
      make_core(input_, s.shell, t);
    };
    const auto shell = [&](PartState& s, PartTask& t) {
      const AddedTime time(s.figures.seconds.delaunay);
      take_shell_points(s.shell, t);
      s.fault = make_shell(input_, s.shell, t.part(), t.runner());
    };
    steps.push_back(step("points", 14, Sends::Messages, points));
    if (input_.is_graded()) steps.push_back(step("grading", 3, Sends::Messages, grading));
    steps.push_back(step("core", 8, Sends::Messages, core));
    steps.push_back(step("shell", 26, Sends::Nothing, shell));
    run_steps(steps);
  }

  // One mesh of core and shell, optimised but for what lies between parts.
  void join_and_optimize(PartState& s, PartTask& t) {
    FillingFigures& figures = s.figures;
    JoinedShell joined;
    {
      const AddedTime time(figures.seconds.join);
      joined = append_shell(input_, std::exchange(s.shell, {}), mending_.removed);
    }
    s.tets = std::move(joined.tets);
    s.seen_sides = joined.seen_sides, figures.core_tets = joined.core_tets, figures.shell_tets = joined.shell_tets;
    for (const RecoveredTets& recovered : mending_.recovered[t]) {
      s.seen_sides += add_recovered(s.tets, t.part(), recovered, input_.only_region);
      figures.shell_tets += recovered.made.size();
    }
    s.fault = name_regions(input_, s.tets.mesh);
    if (s.fault.any()) return;
    const AddedTime time(figures.seconds.optimize);
    figures.optimizer = optimize_inside(input_, s.tets, joined.open_faces, joined.core_tets, t.part(), t.runner());
  }

  void optimize() {
    std::vector<Step> steps;
    const auto inside = [&](PartState& s, PartTask& t) {
      join_and_optimize(s, t);
      if (!s.fault.any()) send_poor(input_, s.tets, s.strips, t);
    };
    steps.push_back(step("optimize", 22, Sends::Messages, inside));
    for (std::size_t round = 0; round < kStripRounds; ++round) add_strip_round(round, steps);
    const auto finish = [&](PartState& s, PartTask& t) {
      s.fault = take_borders(s.check, t);
      if (s.fault.any()) return;
      auto [changed, fault] = finish_part(input_, s.tets, s.check, s.figures, t.part(), t.runner());
      s.changed_triangles = std::move(changed), s.fault = std::move(fault);
    };
    steps.push_back(step("finish", 8, Sends::Nothing, finish));
    run_steps(steps);
    if (!all_faces_met(parts_)) parts_.set_fault("the faces of parts do not fit together");
  }

  void add_strip_round(std::size_t round, std::vector<Step>& steps) {
    const auto share = [&](PartState& s, PartTask& t) { send_shared(input_, s.tets, s.strips, t); };
    const auto send = [round](PartState& s, PartTask& t) {
      send_strips(s.tets, s.strips, round == 0, s.figures.parts.strips[round], t);
    };
    const auto take = [&, is_last = round + 1 == kStripRounds](PartState& s, PartTask& t) {
      {
        const AddedTime time(s.figures.seconds.optimize);
        take_strips(input_, s.tets, s.strips, s.figures.optimizer, t);
      }
      if (is_last) {
        s.check = send_borders(input_, s.tets, s.strips.open_faces, t);
      } else {
        send_poor(input_, s.tets, s.strips, t);
      }
    };
    steps.push_back(step("share", 1, Sends::Messages, share));
    steps.push_back(step("send strips", 1, Sends::Messages, send));
    steps.push_back(step("strips", 3, Sends::Messages, take));
  }

  // What all ranks know in the end: the figures of all parts, in their order, and what became of the surface.
  void take_figures(FilledParts& result) {
    const auto put = [&](MessageWriter& writer) {
      for (const PartId part : states_.local()) {
        const PartState& state = states_.at(part);
        volume::put_figures(writer, state.figures);
        put_text(writer, state.fault.message);
        writer.put(static_cast<std::uint64_t>(state.seen_sides));
        writer.put_array<ChangedTriangle>(state.changed_triangles);
      }
    };
    FillingFigures& figures = result.volume.figures;
    figures.parts.parts = states_.part_count();
    figures.parts.asking_rounds = asked_.rounds;
    figures.parts.asked = asked_.tets;
    const auto given = input_.filling.complex.tri_to_vert;
    result.tri_to_vert.assign(given.begin(), given.end());
    std::size_t seen = 0, wanted = 0;
    const auto take = [&](MessageReader& reader) {
      while (!reader.at_end()) {
        figures.add(volume::get_figures(reader));
        const std::string fault = get_text(reader);
        if (!result.fault.any()) result.fault.message = fault;
        seen += reader.get<std::uint64_t>();
        for (const ChangedTriangle& changed : reader.get_view<ChangedTriangle>())
          result.tri_to_vert[changed.triangle] = changed.verts;
      }
    };
    gather(communicator_, put, take);
    for (const FaceSides& sides : input_.filling.complex.tri_to_sides)
      wanted += std::size_t{sides.front.valid()} + std::size_t{sides.back.valid()};
    if (!result.fault.any() && seen != wanted) result.fault.message = "sides of the surface were left empty";
  }

  const SharedInput& input_;
  Communicator& communicator_;
  const TaskRunner& runner_;
  Schedule schedule_;
  PerPart<PartState> states_;
  const AllParts parts_;
  Links links_;
  Asked asked_;
  Mending mending_;
  double all_work_ = 0;
  std::vector<int> percents_;  // of the steps that are about to run
};

std::uint32_t only_region_of(const volume::Complex& complex) {
  return complex.regions.size() == 1 ? complex.regions[0] : kNone;
}

}  // namespace

std::optional<FilledParts> fill_in_parts(const volume::FillingInput& input, const SharedWork& work) {
  Trace* const trace = input.options.trace;
  const TaskRunner& runner = work.runner();
  lattice::LatticeRequest lattice{&input.tree,  input.complex.tri_to_sides, {},
                                  &input.sizes, input.options.lattice,      input.attempt};
  for (const Vec3& x : input.complex.points) lattice.box.add(x);
  std::optional<TraceSpan> span(std::in_place, trace, "cells", runner.threads(), lattice::LatticeCells::kSubtrees);
  lattice::LatticeCells cells(lattice, work);
  const std::size_t parts = count_parts(estimate_volume(cells), input.options.tets_per_part);
  span.reset();
  if (parts <= 1) return std::nullopt;
  Decomposition decomposition(cells, parts, work, trace);
  if (work.rank_count() > 1) cells.keep(decomposition.keep_cells_of(work.ranks().parts_of_rank(parts)));
  span.emplace(trace, "surface of parts", runner.threads(), PartSurface::pieces(input.complex));
  const PartSurface surface(input.complex, input.sizes, decomposition, kShellReach, work);
  span.emplace(trace, "index of triangles");
  const tets::TrianglesByVertex triangles(input.complex.tri_to_vert, input.complex.points.size());
  span.reset();
  give_back_where_shared(work.rank_count());
  const SharedInput shared{input, cells, decomposition, surface, triangles, lattice.box, only_region_of(input.complex)};
  return Filler(shared, work.ranks(), runner, trace).run();
}

}  // namespace tetloom::parts
