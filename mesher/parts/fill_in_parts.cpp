#include "mesher/parts/fill_in_parts.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/codec.hpp"
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

  void optimize() {
    std::vector<Step> steps;
    const auto inside = [&](PartState& s, PartTask& t) {
      append_shell(input_, s, mending_.removed);
      for (const std::uint32_t c : s.recovered) add_recovered(s, t.part(), mending_.recovered[c], input_.only_region);
      name_regions(input_, s);
      if (s.fault.any()) return;
      optimize_inside(input_, s, t.part(), t.runner());
      send_poor(input_, s, t);
    };
    steps.push_back(step("optimize", 22, Sends::Messages, inside));
    for (std::size_t round = 0; round < kStripRounds; ++round) {
      steps.push_back(step("share", 1, Sends::Messages, [&](PartState& s, PartTask& t) { send_shared(input_, s, t); }));
      steps.push_back(
          step("send strips", 1, Sends::Messages, [&, round](PartState& s, PartTask& t) { send_strips(s, round, t); }));
      const auto take = [&, is_last = round + 1 == kStripRounds](PartState& s, PartTask& t) {
        take_strips(input_, s, t);
        is_last ? send_borders(input_, s, t) : send_poor(input_, s, t);
      };
      steps.push_back(step("strips", 3, Sends::Messages, take));
    }
    const auto finish = [&](PartState& s, PartTask& t) {
      take_borders(s, t);
      finish_part(input_, s, t.part(), t.runner());
    };
    steps.push_back(step("finish", 8, Sends::Nothing, finish));
    run_steps(steps);
    if (!all_faces_met(parts_)) parts_.set_fault("the faces of parts do not fit together");
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
    result.tri_to_vert = input_.filling.complex.tri_to_vert;
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

std::optional<FilledParts> fill_in_parts(const volume::FillingInput& input, Communicator& communicator,
                                         const TaskRunner& runner) {
  Trace* const trace = input.options.trace;
  lattice::LatticeRequest lattice{&input.tree,  input.complex.tri_to_sides, {},
                                  &input.sizes, input.options.lattice,      input.attempt};
  for (const Vec3& x : input.complex.points) lattice.box.add(x);
  std::optional<lattice::LatticeCells> cells;
  std::optional<Decomposition> decomposition;
  std::optional<PartSurface> surface;
  std::optional<tets::TriangleIndex> triangles;
  run_on_all(communicator, [&] {
    {
      const TraceSpan span(trace, "cells", runner.threads(), lattice::LatticeCells::kSubtrees);
      cells.emplace(lattice, runner);
    }
    const std::size_t parts = count_parts(estimate_volume(*cells), input.options.tets_per_part);
    if (parts > 1) decomposition.emplace(*cells, parts, runner, trace);
  });
  if (!decomposition) return std::nullopt;
  run_on_all(communicator, [&] {
    const TraceSpan span(trace, "surface of parts", runner.threads(), PartSurface::pieces(input.complex));
    surface.emplace(input.complex, input.sizes, *decomposition, kShellReach, runner);
  });
  run_on_all(communicator, [&] {
    const TraceSpan span(trace, "index of triangles");
    triangles.emplace(input.complex.tri_to_vert, input.complex.points.size());
  });
  const SharedInput shared{
      input, *cells, *decomposition, *surface, *triangles, lattice.box, only_region_of(input.complex)};
  return Filler(shared, communicator, runner, trace).run();
}

}  // namespace tetloom::parts
