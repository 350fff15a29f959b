#include "apps/tetloom/options.hpp"

#include <CLI/CLI.hpp>
#include <sstream>

#include "apps/tetloom/adapt_options.hpp"
#include "apps/tetloom/mesh_options.hpp"
#include "apps/tetloom/option_values.hpp"
#include "apps/tetloom/reading_options.hpp"
#include "tetloom/io.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::app {
namespace {

constexpr const char* kMainExamples = R"(
Examples:
  tetloom info part.step
  tetloom mesh part.step -o part.vtu
  tetloom check part.vtu
  tetloom partition part.vtu --parts 64 -o part64.pvtu
  tetloom adapt part.vtu -o adapted.vtu --hessian temperature --complexity 1e5 --model part.step
'tetloom mesh --help' tells more.)";

struct RawPartition {
  std::string input, output, report, weights, method = "multilevel";
  std::optional<int> parts, threads;
  bool quiet = false;
};

struct RawInspection {
  std::string input, report;
  std::optional<int> threads;
  RawReading reading;
  bool quiet = false;
};

PartitionMethod method_named(const std::string& name) {
  for (const PartitionMethod method :
       {PartitionMethod::Multilevel, PartitionMethod::Rcb, PartitionMethod::Sfc, PartitionMethod::Scotch})
    if (name == to_string(method)) return method;
  throw UsageError("--method must be multilevel, rcb, sfc or scotch, not '" + name + "'");
}

PartitionCommand make_partition_command(const RawPartition& raw) {
  PartitionCommand command;
  command.input = raw.input;
  command.output = raw.output;
  command.report = raw.report;
  command.quiet = raw.quiet;
  require(!command.input.empty(), "MESH must not be empty");
  require(is_writable_parts_format(command.output), "cannot tell the format of the output '" + command.output.string() +
                                                        "' from its extension; known are .foam, .msh, .pvtu");
  require(!would_replace(command.output, command.input), "the output would replace the input");
  require(!same_file(command.input, command.report), "the report would replace the input");
  require(!would_replace(command.output, command.report), "the report would replace the output");
  command.threads = count_between("--threads", raw.threads, kMostThreads);
  command.balance.part_count = static_cast<std::size_t>(count_between("--parts", raw.parts, kMostParts));
  command.balance.method = method_named(raw.method);
  command.balance.weights = raw.weights;
  return command;
}

CLI::App* add_partition_command(CLI::App& app, RawPartition& raw) {
  CLI::App* partition =
      app.add_subcommand("partition", "Deal the cells of a mesh to parts, or of parts to other parts");
  partition->add_option("MESH", raw.input, "A mesh, or a partitioned mesh (.pvtu, .msh)")->required();
  partition->add_option("--parts", raw.parts, "How many parts")->required()->type_name("N");
  partition
      ->add_option("--method", raw.method,
                   "multilevel: by levels of clusters (default); rcb: cut by planes, then smoothed; sfc: along a "
                   "curve; scotch: fewest faces between parts")
      ->type_name("multilevel|rcb|sfc|scotch");
  partition->add_option("--weights", raw.weights, "Balance a field on cells instead of their number")
      ->type_name("FIELD");
  partition
      ->add_option("-o,--output", raw.output,
                   "The parts: .pvtu (a file per part), .foam (a folder per processor) or .msh (one file)")
      ->required()
      ->type_name("OUT");
  partition->add_option("--threads", raw.threads, "Default: all cores; the parts do not depend on it")->type_name("T");
  partition->add_option("--report", raw.report, "Write a report, for failures too")->type_name("R.json");
  partition->add_flag("--quiet", raw.quiet, "Print errors only");
  return partition;
}

CLI::App* add_inspection(CLI::App& app, const char* name, const char* description, RawInspection& raw) {
  CLI::App* command = app.add_subcommand(name, description);
  command->add_option("FILE", raw.input, "A model or a mesh")->required();
  command->add_option("--threads", raw.threads, "Default: all cores")->type_name("T");
  command->add_option("--report", raw.report, "Write what is found as JSON, for failures too")->type_name("R.json");
  command->add_flag("--quiet", raw.quiet, "Print errors only");
  return command;
}

/// CLI11 takes an empty text for an absent value; here it is a mistake, an unset variable of a script, say.
void refuse_empty_values(CLI::App& app) {
  const auto not_empty = [](const std::string& text) { return text.empty() ? "the value is empty" : ""; };
  for (CLI::Option* option : app.get_options()) {
    if (option->get_items_expected_max() > 0) option->check(not_empty, "");
  }
}

int threads_of(const RawInspection& raw) { return count_between("--threads", raw.threads, kMostThreads); }

void check_inspection(const RawInspection& raw) {
  require(!raw.input.empty(), "FILE must not be empty");
  require(!same_file(raw.input, raw.report), "the report would replace the input");
}

}  // namespace

Command parse_command_line(int argc, const char* const* argv) {
  CLI::App app("tetloom makes tetrahedral meshes of CAD geometry in parallel.", "tetloom");
  app.set_version_flag("--version", std::string("tetloom ") + TETLOOM_VERSION);
  app.require_subcommand(1);
  app.footer(kMainExamples);
  RawMeshOptions raw_mesh;
  RawInspection raw_info, raw_check;
  RawPartition raw_partition;
  const CLI::App* mesh = add_mesh_command(app, raw_mesh);
  CLI::App* info = add_inspection(app, "info", "Describe a model or a mesh", raw_info);
  add_reading_options(*info, raw_info.reading);
  add_inspection(app, "check", "Validate any mesh and measure its quality; exit status 4 when it is not valid",
                 raw_check);
  const CLI::App* partition = add_partition_command(app, raw_partition);
  RawAdapt raw_adapt;
  const CLI::App* adapt = add_adapt_command(app, raw_adapt);
  for (CLI::App* command : app.get_subcommands({})) refuse_empty_values(*command);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream out, ignored;
    if (app.exit(error, out, ignored) != 0) throw UsageError(error.what());
    return Printout{out.str()};
  }
  if (mesh->parsed()) return make_mesh_command(raw_mesh);
  if (partition->parsed()) return make_partition_command(raw_partition);
  if (adapt->parsed()) return make_adapt_command(raw_adapt);
  if (info->parsed()) {
    check_inspection(raw_info);
    return InfoCommand{raw_info.input, raw_info.report, make_read_options(raw_info.reading), threads_of(raw_info),
                       raw_info.quiet};
  }
  check_inspection(raw_check);
  return CheckCommand{raw_check.input, raw_check.report, threads_of(raw_check), raw_check.quiet};
}

std::optional<std::filesystem::path> find_report_argument(int argc, const char* const* argv) {
  static constexpr std::string_view option = "--report";
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == option && i + 1 < argc) return argv[i + 1];
    if (argument.starts_with(option) && argument.size() > option.size() + 1 && argument[option.size()] == '=') {
      return argument.substr(option.size() + 1);
    }
  }
  return std::nullopt;
}

}  // namespace tetloom::app
