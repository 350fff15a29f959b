#include "apps/tetloom/adapt_options.hpp"

#include <algorithm>
#include <cmath>

#include "apps/tetloom/adapt_input.hpp"
#include "apps/tetloom/option_values.hpp"
#include "apps/tetloom/quantities.hpp"
#include "tetloom/io.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::app {
namespace {

constexpr const char* kFormats = ".mesh, .meshb, .msh, .vtu, .pvtu (in parts)";

constexpr const char* kAdaptExamples = R"(
Examples:
  tetloom adapt cube.meshb -o fine.meshb --metric metric.sol
  tetloom adapt flow.vtu -o next.vtu --hessian mach --complexity 1e5 --norm 2 --transfer mach,density
  tetloom adapt part.vtu -o next.vtu --metric-field size --model part.step --report report.json
  mpirun --bind-to none -n 4 tetloom adapt flow.vtu -o next.pvtu --hessian mach --complexity 1e6 --parts 64

A metric gives at every point of MESH a size, or a symmetric tensor M: an edge e has the length sqrt(e.Me), and 1 is
what it shall be. Fields of a .mesh or .meshb lie beside it, in the .sol or .solb of the same name, as solution_1,
solution_2 ... on points and on tets. Without --model the surface keeps its shape: only what lies in planes and on straight edges changes.

Exit status: 0 done, 2 wrong usage, 3 input unreadable or unsuitable, 4 the result is not valid, 5 cancelled,
6 out of memory or disk.)";

bool is_format(const std::filesystem::path& path) {
  const std::string extension = lower_extension(path);
  return extension == ".mesh" || extension == ".meshb" || extension == ".msh" || extension == ".vtu" ||
         is_piece_list(path);
}

void check_files(const AdaptCommand& command) {
  require(!command.input.empty(), "MESH must not be empty");
  require(is_format(command.output), "cannot tell the format of the output '" + command.output.string() +
                                         "' from its extension; known are " + kFormats);
  for (const auto& [path, what] :
       {std::pair(&command.input, "input"), {&command.model, "model"}, {&command.metric_file, "metric"}}) {
    require(!would_replace(command.output, *path), std::string("the output would replace the ") + what);
    require(!same_file(*path, command.report), std::string("the report would replace the ") + what);
  }
  require(!would_replace(command.output, command.report), "the report would replace the output");
  if (!has_fields_beside(command.output) || command.options.transfer.empty()) return;
  const std::filesystem::path fields = fields_beside(command.output);
  require(!same_file(fields, command.metric_file), "the fields beside the output would replace the metric");
  require(!same_file(fields, command.report), "the report would replace the fields beside the output");
  require(!has_fields_beside(command.input) || !same_file(fields, fields_beside(command.input)),
          "the fields beside the output would replace those beside the input");
}

void set_metric(const RawAdapt& raw, AdaptCommand& command) {
  const int sources = !raw.metric.empty() + !raw.metric_field.empty() + !raw.hessian.empty();
  require(sources == 1, "give the metric by one of --metric, --metric-field and --hessian");
  command.metric_file = raw.metric;
  command.metric_field = raw.metric_field;
  command.hessian_field = raw.hessian;
  require(raw.metric.empty() || is_solution_extension(command.metric_file),
          "--metric must be a .sol or .solb file, not '" + raw.metric + "'");
  require(raw.hessian.empty() == !raw.complexity, "--hessian and --complexity go together");
  require(!raw.norm || !raw.hessian.empty(), "--norm goes with --hessian");
  command.hessian.complexity = positive("--complexity", raw.complexity, 0);
  command.hessian.norm = raw.norm.value_or(command.hessian.norm);
  require(command.hessian.norm >= 1, "--norm must be at least 1, or inf, not " + format_number(command.hessian.norm));
}

void set_bounds(const RawAdapt& raw, AdaptCommand& command) {
  adapt::MetricBounds& bounds = command.hessian.bounds;
  bounds.h_min = positive("--h-min", raw.h_min, bounds.h_min);
  bounds.h_max = positive("--h-max", raw.h_max, bounds.h_max);
  require(bounds.h_min <= bounds.h_max, "--h-min must not be larger than --h-max");
  bounds.max_aspect = positive("--max-aspect", raw.max_aspect, bounds.max_aspect);
  require(bounds.max_aspect >= 1, "--max-aspect must be at least 1, not " + format_number(bounds.max_aspect));
  command.hessian.gradation = not_negative("--gradation", raw.gradation, 0);
  require(command.hessian.gradation == 0 || command.hessian.gradation > 1,
          "--gradation is a factor above 1, or 0 (off), not " + format_number(command.hessian.gradation));
}

void set_adaptation(const RawAdapt& raw, AdaptCommand& command) {
  AdaptOptions& options = command.options;
  options.quality_floor = not_negative("--quality-floor", raw.quality_floor, options.quality_floor);
  require(options.quality_floor < 1, "--quality-floor must be below 1, not " + format_number(options.quality_floor));
  options.transfer = raw.transfer;
  for (const std::string& name : raw.transfer)
    require(std::count(raw.transfer.begin(), raw.transfer.end(), name) == 1,
            "--transfer names '" + name + "' more than once");
  require(!raw.transfer_order || !raw.transfer.empty(), "--transfer-order goes with --transfer");
  require(!raw.transfer_order || *raw.transfer_order == 1 || *raw.transfer_order == 2,
          "--transfer-order must be 1 or 2");
  if (raw.transfer_order == 1) options.cell_reconstruction = adapt::CellReconstruction::Constant;
  options.threads = count_between("--threads", raw.threads, kMostThreads);
  options.parts = count_between("--parts", raw.parts, kMostParts);
  command.in_parts = is_in_parts(command.output, raw.parts);
  if (raw.tets_per_part) {
    require(*raw.tets_per_part >= kFewestTetsPerPart, "--tets-per-part must be at least 1000");
    options.tets_per_part = *raw.tets_per_part;
  }
}

void set_model(const RawAdapt& raw, AdaptCommand& command) {
  command.model = raw.model;
  require(!raw.model.empty() || raw.reading == RawReading{},
          "--imprint, --no-heal, --feature-angle and --fill-holes go with --model");
  require(!raw.model.empty() || !raw.curvature, "--curvature goes with --model");
  command.read = make_read_options(raw.reading);
  command.curvature = not_negative("--curvature", raw.curvature, 0);
}

void add_metric_options(CLI::App& adapt, RawAdapt& raw) {
  const std::string group = "Metric (one of the first three)";
  adapt.add_option("--metric", raw.metric, "From a file: sizes or tensors at the points of MESH")
      ->type_name("FILE.sol|.solb")
      ->group(group);
  adapt.add_option("--metric-field", raw.metric_field, "From a field on the points of MESH: 1, 6 or 9 components")
      ->type_name("NAME")
      ->group(group);
  adapt.add_option("--hessian", raw.hessian, "From the second derivatives of a scalar field on the points of MESH")
      ->type_name("NAME")
      ->group(group);
  adapt.add_option("--complexity", raw.complexity, "With --hessian: about a twelfth to an eighth of the tets wanted")
      ->type_name("C")
      ->group(group);
  adapt.add_option("--norm", raw.norm, "With --hessian: the error is small in the norm L^P, 1 to inf; default: 2")
      ->type_name("P")
      ->group(group);
  adapt.add_option("--h-min", raw.h_min, "No size below")->type_name("H")->group(group);
  adapt.add_option("--h-max", raw.h_max, "No size above")->type_name("H")->group(group);
  adapt.add_option("--max-aspect", raw.max_aspect, "Largest size by smallest, at one place")
      ->type_name("A")
      ->group(group);
  adapt.add_option("--gradation", raw.gradation, "Sizes grow by at most this factor over an edge; default: as given")
      ->type_name("G")
      ->group(group);
  adapt.add_option("--curvature", raw.curvature, "With --model: at least N edges per full turn; default: off")
      ->type_name("N")
      ->group(group);
}

void add_model_options(CLI::App& adapt, RawAdapt& raw) {
  const std::string group = "Model";
  adapt.add_option("--model", raw.model, "The model that MESH was made from: its surface is followed")
      ->type_name("CAD")
      ->group(group);
  add_reading_options(adapt, raw.reading);
}

}  // namespace

CLI::App* add_adapt_command(CLI::App& app, RawAdapt& raw) {
  CLI::App* adapt = app.add_subcommand("adapt", "Change a mesh of tetrahedra until its edges fit a metric");
  adapt->add_option("MESH", raw.input, std::string("The mesh: ") + kFormats)->required();
  adapt->add_option("-o,--output", raw.output, std::string("The mesh afterwards: ") + kFormats)
      ->required()
      ->type_name("OUT");
  add_metric_options(*adapt, raw);
  add_model_options(*adapt, raw);
  const std::string group = "Run";
  adapt->add_option("--transfer", raw.transfer, "Fields on points and cells to carry over, separated by commas")
      ->delimiter(',')
      ->type_name("NAMES")
      ->group(group);
  adapt
      ->add_option("--transfer-order", raw.transfer_order,
                   "Fields on cells are constant in each of them (1), or linear without new extremes (2, the default)")
      ->type_name("1|2")
      ->group(group);
  adapt
      ->add_option("--quality-floor", raw.quality_floor,
                   "No collapse, swap or motion makes a tet worse than this mean ratio; default: 0.1")
      ->type_name("Q")
      ->group(group);
  adapt->add_option("--threads", raw.threads, "Default: all cores; the mesh does not depend on it")
      ->type_name("T")
      ->group(group);
  adapt
      ->add_option("--parts", raw.parts,
                   "Deal the mesh to P parts: .pvtu (a file per part) or .msh (one file); .pvtu without it: as many as "
                   "it was adapted in")
      ->type_name("P")
      ->group(group);
  adapt->add_option("--tets-per-part", raw.tets_per_part, "Adapted in parts of about so many tetrahedra")
      ->type_name("N")
      ->group(group);
  adapt->add_option("--report", raw.report, "Write a report, for failures too")->type_name("R.json")->group(group);
  adapt->add_flag("--quiet", raw.quiet, "Print errors only")->group(group);
  adapt->footer(kAdaptExamples);
  return adapt;
}

AdaptCommand make_adapt_command(const RawAdapt& raw) {
  AdaptCommand command;
  command.input = raw.input;
  command.output = raw.output;
  command.report = raw.report;
  command.quiet = raw.quiet;
  set_metric(raw, command);
  set_bounds(raw, command);
  set_adaptation(raw, command);
  set_model(raw, command);
  check_files(command);
  return command;
}

}  // namespace tetloom::app
