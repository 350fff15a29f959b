#include "apps/tetloom/run.hpp"

#include <algorithm>
#include <exception>
#include <initializer_list>
#include <optional>
#include <utility>

#include "apps/tetloom/console.hpp"
#include "core/io/atomic_file.hpp"
#include "tetloom/io.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::app {

Run::Run(RunSetup setup)
    : setup_(std::move(setup)),
      report_(fresh_report()),
      display_(stderr, ProgressDisplay::style_for(stderr, setup_.quiet || !speaks())),
      interruption_([this] { leave(); }) {}

RunReport Run::fresh_report() const {
  RunReport report;
  report.input = setup_.input.string();
  report.threads = setup_.threads;
  report.parts = setup_.parts;
  return report;
}

Host Run::host() {
  return {[this](const ProgressEvent& event) {
            clock_.enter(event.stage);
            display_.update(event);
            return true;
          },
          &cancel()};
}

void Run::begin(Stage stage) {
  cancel().check();
  clock_.enter(stage);
  display_.update({stage, {}, 0, 0});
}

void Run::begin_together(Stage stage) {
  run_on_all(ranks(), [&] { begin(stage); });
}

ExitStatus Run::execute(const std::function<void(Run&)>& body) {
  carry_out(body);
  display_.finish();
  if (report_.status != ExitStatus::Done) note_seconds(report_.seconds);
  if (!speaks()) return report_.status;
  print_diagnostics();
  write_report_file();
  if (!setup_.quiet) print(stdout, text_);
  return report_.status;
}

// A place where nothing can be written is found before the work, not after it.
void Run::probe_outputs() const {
  std::error_code ignored;
  const bool is_folder =
      std::filesystem::is_directory(setup_.output, ignored) && is_writable_mesh_format(setup_.output);
  if (!setup_.output.empty()) AtomicFile probe(is_folder ? setup_.output / "probe" : setup_.output);
  if (!setup_.report.empty()) AtomicFile probe(setup_.report);
}

void Run::carry_out(const std::function<void(Run&)>& body) {
  const std::optional<Diagnostic> failure = failure_of([&] {
    const SharedWork work(1, {.cancel = &cancel()}, setup_.ranks);
    ranks_ = &work.ranks();
    work.together([&] {
      run_on_first(ranks(), [&] { probe_outputs(); });
      body(*this);
    });
  });
  if (failure) add_failure(report_, *failure);
}

// Of the stages so far, with the one that did not end, which has not been counted.
void Run::note_seconds(RunSeconds& seconds) const {
  const auto note = [&](double& of, std::initializer_list<Stage> stages) {
    double sum = 0;
    for (const Stage stage : stages) sum += clock_.seconds(stage);
    of = std::max(of, sum);
  };
  note(seconds.read, {Stage::Read});
  note(seconds.size_field, {Stage::SizeField});
  note(seconds.surface, {Stage::Edges, Stage::Faces, Stage::Intersections});
  note(seconds.layers, {Stage::Layers});
  note(seconds.volume, {Stage::Volume});
  note(seconds.second_order, {Stage::SecondOrder});
  note(seconds.check, {Stage::Check});
  note(seconds.write, {Stage::Write});
}

void Run::print_diagnostics() const {
  if (!setup_.quiet) {
    for (const Diagnostic& warning : report_.warnings) print(stderr, render_diagnostic("tetloom: warning", warning));
  }
  for (const Diagnostic& error : report_.errors) {
    const bool cancelled = error.code == ErrorCode::Cancelled;
    print(stderr, cancelled ? "tetloom: cancelled\n" : render_diagnostic("tetloom: error", error));
  }
}

void Run::write_report_file() {
  if (setup_.report.empty()) return;
  try {
    write_report(report_, setup_.report);
  } catch (const Error& error) {
    const bool known = !report_.errors.empty() && report_.errors.back().message == error.diagnostic().message;
    add_failure(report_, error.diagnostic());
    if (!known) print(stderr, render_diagnostic("tetloom: error", error.diagnostic()));
  }
}

// Runs in the thread of the interruption, while the main thread may be anywhere: so nothing of report_ that it could be
// changing right now is used.
void Run::leave() {
  if (!setup_.output.empty()) remove_temporaries_of(setup_.output);
  if (!setup_.report.empty() && speaks()) {
    remove_temporaries_of(setup_.report);
    RunReport report = fresh_report();
    report.start = report_.start;
    note_seconds(report.seconds);
    add_failure(report, {ErrorCode::Cancelled, "cancelled by the host", {}, {}, {}});
    try {
      write_report(report, setup_.report);
    } catch (const std::exception&) {
      // There is nobody left to tell.
    }
  }
  display_.finish();
  if (speaks()) print(stderr, "tetloom: cancelled\n");
}

}  // namespace tetloom::app
