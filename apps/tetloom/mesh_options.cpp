#include "apps/tetloom/mesh_options.hpp"

#include <cmath>
#include <exception>

#include "apps/tetloom/option_values.hpp"
#include "apps/tetloom/quantities.hpp"
#include "mesher/tets/quality_goals.hpp"
#include "tetloom/io.hpp"

namespace tetloom::app {
namespace {

constexpr double kDefaultCurvature = 24;
constexpr const char* kRun = "Run";
constexpr const char* kLayers = "Boundary layers";

constexpr const char* kMeshExamples = R"(
Examples:
  tetloom mesh part.step -o part.vtu                        a size that suits most models
  tetloom mesh part.step -o part.msh --size 2 --curvature 24
  tetloom mesh part.step -o part.vtu --relative-size 0.01 --sizes sizes.json --report report.json
  tetloom mesh assembly.step -o assembly.vtu --imprint      touching solids share their faces
  tetloom mesh part.step -o parts.pvtu --parts 64           in parts, a file each
  tetloom mesh scan.stl -o surface.stl --surface-only --size 0.5

The file of --sizes gives the size of single entities, by tag or by name, and of points:
  {"entities": [{"dim": 2, "tag": 17, "size": 0.5}, {"name": "flange", "size": 1}],
   "points": [{"point": [0, 0, 10], "size": 0.1}]}
'tetloom info part.step' shows the tags and names.

Exit status: 0 done, 2 wrong usage, 3 input unreadable or unsuitable, 4 the geometry cannot be meshed,
5 cancelled, 6 out of memory or disk.)";

QualityGoals make_goals(const RawMeshOptions& raw) {
  QualityGoals goals;
  goals.dihedral = raw.min_dihedral.value_or(goals.dihedral);
  goals.mean_ratio = raw.min_mean_ratio.value_or(goals.mean_ratio);
  goals.rounds = raw.rounds.value_or(goals.rounds);
  try {
    check_goals(goals);
  } catch (const Error& error) {
    throw UsageError(std::string("--min-dihedral, --min-mean-ratio, --rounds: ") + error.what());
  }
  return goals;
}

double metres_of(const std::string& unit) {
  if (unit == "m") return 1;
  if (unit == "cm") return 1e-2;
  if (unit == "mm") return 1e-3;
  if (unit == "um") return 1e-6;
  if (unit == "km") return 1e3;
  if (unit == "in") return 0.0254;
  if (unit == "ft") return 0.3048;
  return 0;
}

WriteOptions make_write_options(const RawMeshOptions& raw) {
  const WriteOptions options{raw.msh_version == "2.2", raw.ascii};
  require(!options.text || options.msh_2_2, "--ascii needs --msh-version 2.2");
  require(!options.msh_2_2 || std::filesystem::path(raw.output).extension() == ".msh",
          "--msh-version needs an output that ends in .msh");
  return options;
}

void set_groups(const RawMeshOptions& raw, MeshCommand& command) {
  try {
    for (const std::string& text : raw.groups) command.groups.push_back(parse_group(text));
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
  command.groups_file = raw.groups_file;
}

void set_order(const RawMeshOptions& raw, MeshCommand& command) {
  MeshOptions& options = command.options;
  options.order = raw.order.value_or(1);
  options.min_scaled_jacobian = raw.min_scaled_jacobian.value_or(options.min_scaled_jacobian);
  require(options.min_scaled_jacobian >= 0 && options.min_scaled_jacobian <= 0.9,
          "--min-scaled-jacobian must lie between 0 and 0.9, not be " + format_number(options.min_scaled_jacobian));
  require(!raw.min_scaled_jacobian || options.order == 2, "--min-scaled-jacobian needs --order 2");
  require(options.order == 1 || !command.in_parts, "--order 2 is for meshes in one file, not in parts");
  require(options.order == 1 || holds_second_order(command.output),
          "the format of '" + command.output.string() + "' holds no mesh of second order");
}

void set_far_field(const RawMeshOptions& raw, MeshCommand& command) {
  require(!raw.far_field || (*raw.far_field > 1 && std::isfinite(*raw.far_field)),
          "--far-field must be greater than 1");
  command.far_field = raw.far_field.value_or(0);
  // Around solids that touch there is the skin of all together.
  if (command.far_field > 0 && command.read.heal) command.read.imprint = true;
}

void set_layers(const RawMeshOptions& raw, MeshCommand& command) {
  const bool has_numbers =
      raw.first_height || raw.growth || raw.layer_count || raw.layer_thickness || raw.fan_angle || raw.all_tets;
  require(!raw.layers.empty() || !has_numbers,
          "--first-height, --growth, --layer-count, --layer-thickness, --fan-angle and --all-tets need --layers");
  if (raw.layers.empty()) return;
  WallLayers common;
  common.first_height = raw.first_height.value_or(0);
  common.growth = raw.growth.value_or(common.growth);
  common.count = raw.layer_count.value_or(0);
  common.thickness = raw.layer_thickness.value_or(0);
  require(!raw.first_height || *raw.first_height > 0, "--first-height must be positive");
  require(common.growth >= 1 && common.growth <= 10, "--growth must lie between 1 and 10");
  require(common.count >= 0 && common.count <= 1000, "--layer-count must be a number up to 1000");
  require(!raw.layer_thickness || *raw.layer_thickness > 0, "--layer-thickness must be positive");
  require(!raw.fan_angle || *raw.fan_angle == 0 || (*raw.fan_angle >= 45 && *raw.fan_angle <= 180),
          "--fan-angle must lie between 45 and 180 degrees, or be 0");
  require(raw.layers.ends_with(".json") || raw.first_height, "--layers needs --first-height, or a file");
  require(!command.options.surface_only, "--layers needs volumes, and --surface-only makes none");
  require(command.options.order == 1 || !raw.all_tets, "--all-tets needs --order 1");
  try {
    command.layers = parse_layers(raw.layers, common);
  } catch (const Error& error) {
    throw UsageError(error.what());
  }
  command.layers.all_tets = command.layers.all_tets || raw.all_tets;
  if (raw.fan_angle) command.layers.fan_angle = raw.fan_angle;
  command.layers.has_far_field = command.far_field > 0;
}

double refinement_factor(const std::string& text) {
  if (text.empty()) return MeshOptions{}.most_refinement;
  std::size_t used = 0;
  double factor = 0;
  try {
    factor = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  require(used == text.size() && factor >= 1,
          "--allow-surface-refinement must be a number of at least 1, or inf, not '" + text + "'");
  return factor;
}

SizeOptions make_size_options(const RawMeshOptions& raw) {
  SizeOptions sizes;
  const bool any_size = raw.size || raw.relative_size;
  sizes.size = positive("--size", raw.size, 0);
  sizes.relative_size = positive("--relative-size", raw.relative_size, any_size ? 0 : 1.0 / 40);
  require(sizes.relative_size <= 1, "--relative-size is a share of the bounding box's diagonal, so at most 1, not " +
                                        format_number(sizes.relative_size));
  sizes.min_size = positive("--min-size", raw.min_size, 0);
  sizes.curvature = not_negative("--curvature", raw.curvature, any_size ? 0 : kDefaultCurvature);
  sizes.proximity = not_negative("--proximity", raw.proximity, 0);
  sizes.gradation = positive("--gradation", raw.gradation, sizes.gradation);
  return sizes;
}

void check_files(const MeshCommand& command) {
  require(!command.input.empty(), "INPUT must not be empty");
  require(is_writable_mesh_format(command.output) || is_piece_list(command.output),
          "cannot tell the format of the output '" + command.output.string() + "' from its extension; known are " +
              writable_mesh_extensions() + ", .pvtu");
  require(!would_replace(command.output, command.input), "the output would replace the input");
  require(!same_file(command.input, command.report), "the report would replace the input");
  require(!would_replace(command.output, command.report), "the report would replace the output");
}

void add_size_options(CLI::App& mesh, RawMeshOptions& raw) {
  const std::string group = "Sizes (model length units)";
  CLI::Option* size = mesh.add_option("--size", raw.size, "Target edge length")->type_name("H")->group(group);
  mesh.add_option("--relative-size", raw.relative_size,
                  "Target edge length as a share of the bounding box's diagonal; without any size: 1/40, and "
                  "--curvature 24")
      ->type_name("R")
      ->group(group)
      ->excludes(size);
  mesh.add_option("--min-size", raw.min_size, "Floor for sizes from curvature and proximity; default: target / 10")
      ->type_name("H")
      ->group(group);
  mesh.add_option("--curvature", raw.curvature, "At least N edges per full turn; 0: off")->type_name("N")->group(group);
  mesh.add_option("--proximity", raw.proximity, "At least N edges across gaps and walls; 0: off")
      ->type_name("N")
      ->group(group);
  mesh.add_option("--gradation", raw.gradation, "Largest growth of the size per unit of distance; default: 0.3")
      ->type_name("G")
      ->group(group);
  mesh.add_option("--sizes", raw.sizes_file, "Sizes of single entities and points (see below)")
      ->type_name("FILE.json")
      ->group(group);
}

void add_goal_options(CLI::App& mesh, RawMeshOptions& raw) {
  const std::string group = "Goals for the tetrahedra (what stays below is reported)";
  mesh.add_option("--min-dihedral", raw.min_dihedral, "Smallest dihedral angle, 0 to 60; default: 15")
      ->type_name("DEG")
      ->group(group);
  mesh.add_option("--min-mean-ratio", raw.min_mean_ratio, "Mean ratio, 0 to 0.9; default: 0.5")
      ->type_name("Q")
      ->group(group);
  mesh.add_option("--rounds", raw.rounds, "At most N rounds of repairs, four times as many of the surface; default: 2")
      ->type_name("N")
      ->group(group);
}

void add_surface_options(CLI::App& mesh, RawMeshOptions& raw) {
  mesh.add_flag("--surface-only", raw.surface_only, "Mesh the surfaces and fill no volume")->group(kRun);
  CLI::Option* refine =
      mesh.add_option(
              "--allow-surface-refinement", raw.refinement,
              "Smaller sizes where walls, faces or edges are too narrow for those asked for, and around wires, up to "
              "FACTOR times the elements or 20,000 of them (inf: whatever it takes); default: 2")
          ->type_name("FACTOR")
          ->expected(0, 1)
          ->default_str("2")
          ->group(kRun);
  mesh.add_flag("--no-surface-refinement", raw.no_refinement, "Keep the sizes also there")
      ->excludes(refine)
      ->group(kRun);
  CLI::Option* keep = mesh.add_flag("--keep-small-features", raw.keep_small_features,
                                    "Mesh edges, faces and steps of the model however small they are");
  mesh.add_option("--small-feature", raw.small_feature,
                  "Eliminate from the mesh what is smaller than TOL; default: a tenth of the size asked for there")
      ->type_name("TOL")
      ->excludes(keep)
      ->group(kRun);
  keep->group(kRun);
  mesh.add_flag("--keep-surface", raw.keep_surface,
                "Keep the surface mesh as it is while the volume is filled, also beside poor tetrahedra")
      ->group(kRun);
}

void add_layer_options(CLI::App& mesh, RawMeshOptions& raw) {
  mesh.add_option("--layers", raw.layers,
                  "Boundary layers on these faces: tags (3,7-9) or names with * and ?, '*' for all faces of the "
                  "boundary, !NAME for all but those; or a file that ends in .json (see the reference)")
      ->type_name("WALLS")
      ->group(kLayers);
  mesh.add_option("--first-height", raw.first_height, "Height of the first layer")->type_name("H")->group(kLayers);
  mesh.add_option("--growth", raw.growth, "Of the heights from layer to layer; default: 1.2")
      ->type_name("G")
      ->group(kLayers);
  mesh.add_option("--layer-count", raw.layer_count,
                  "Layers; default: as many as it takes for the last to be 0.8 of the size at its place")
      ->type_name("N")
      ->group(kLayers);
  mesh.add_option("--layer-thickness", raw.layer_thickness, "Of all layers together at most")
      ->type_name("T")
      ->group(kLayers);
  mesh.add_option("--fan-angle", raw.fan_angle,
                  "Fans of layers at convex edges where normals turn by more than that; default: 50, none: 0")
      ->type_name("DEG")
      ->group(kLayers);
  mesh.add_flag("--all-tets", raw.all_tets, "Split the prisms and pyramids of layers into tetrahedra")->group(kLayers);
}

void add_volume_options(CLI::App& mesh, RawMeshOptions& raw) {
  mesh.add_option("--far-field", raw.far_field,
                  "Put the model into a box FACTOR times as large and mesh the space between them")
      ->type_name("FACTOR")
      ->group(kRun);
  mesh.add_flag("--keep-going", raw.keep_going,
                "Write the solids that can be meshed where others cannot; the exit status is 4 all the same")
      ->group(kRun);
  mesh.add_option("--lattice", raw.lattice,
                  "The lattice inside: bcc (the default), or a15, of fewer tetrahedra that are nearer to regular")
      ->check(CLI::IsMember({"bcc", "a15"}))
      ->type_name("KIND")
      ->group(kRun);
  mesh.add_option("--order", raw.order, "2: elements have mid nodes, on the curves and faces of the model; default: 1")
      ->check(CLI::IsMember({1, 2}))
      ->type_name("P")
      ->group(kRun);
  mesh.add_option("--min-scaled-jacobian", raw.min_scaled_jacobian,
                  "With --order 2: the least Jacobian of a cell over that of the straight one; mid nodes leave the "
                  "model where it would be less; 0 to 0.9, default: 0.1")
      ->type_name("Q")
      ->group(kRun);
}

void add_file_options(CLI::App& mesh, RawMeshOptions& raw) {
  mesh.add_option("--unit", raw.unit,
                  "The unit of the output's lengths; default: the model's. Sizes are in the model's unit")
      ->check(CLI::IsMember({"m", "cm", "mm", "um", "km", "in", "ft"}))
      ->type_name("U")
      ->group(kRun);
  mesh.add_option("--group", raw.groups,
                  "Model entities that files have under one NAME: regions, faces, edges or vertices, by tags (3,7-9), "
                  "names with * and ?, #rrggbb or, of faces, the direction of normals (+z); several times")
      ->type_name("NAME=faces:ITEMS")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
      ->group(kRun);
  mesh.add_option("--groups", raw.groups_file, "The same in a file (see the reference)")
      ->type_name("FILE.json")
      ->group(kRun);
  mesh.add_option("--msh-version", raw.msh_version, "Of .msh: 4.1 (the default), or 2.2, which more programs read")
      ->check(CLI::IsMember({"4.1", "2.2"}))
      ->type_name("V")
      ->group(kRun);
  mesh.add_flag("--ascii", raw.ascii, "Write .msh of version 2.2 as text")->group(kRun);
}

void add_run_options(CLI::App& mesh, RawMeshOptions& raw) {
  mesh.add_option("--threads", raw.threads, "Default: all cores; the mesh does not depend on it")
      ->type_name("T")
      ->group(kRun);
  mesh.add_option("--parts", raw.parts,
                  "Deal the mesh to P parts: .pvtu (a file per part), .foam (a folder per processor) or .msh (one "
                  "file); .pvtu without it: the parts in which volumes were filled")
      ->type_name("P")
      ->group(kRun);
  mesh.add_option(
          "--tets-per-part", raw.tets_per_part,
          "Volumes are filled in parts of about so many tetrahedra, inf: in one; default: about .4 s of work, and "
          "at most 2.5e5. The mesh depends on it, where parts meet")
      ->type_name("N")
      ->group(kRun);
  mesh.add_option("--max-memory", raw.max_memory,
                  "Refuse what is estimated to need more, such as 8G; default: what the machine has free")
      ->type_name("BYTES")
      ->group(kRun);
  mesh.add_flag("--tetgen", raw.tetgen, "Fill volumes by TetGen alone, to compare");
  mesh.add_option("--worker", raw.worker, "The tetloom-tetgen to use; default: beside tetloom, then in PATH")
      ->type_name("FILE")
      ->group(kRun);
  mesh.add_option("--report", raw.report, "Write a report, for failures too")->type_name("R.json")->group(kRun);
  mesh.add_flag("--quiet", raw.quiet, "Print errors only")->group(kRun);
}

}  // namespace

CLI::App* add_mesh_command(CLI::App& app, RawMeshOptions& raw) {
  CLI::App* mesh = app.add_subcommand("mesh", "Mesh a CAD model (STEP, IGES, BREP) or a facet model (STL, OBJ)");
  mesh->add_option("INPUT", raw.input, "The model; its format follows from the extension")->required();
  mesh->add_option("-o,--output", raw.output, "The mesh: " + writable_mesh_extensions() + ", .pvtu (in parts)")
      ->required()
      ->type_name("OUT");
  add_size_options(*mesh, raw);
  add_goal_options(*mesh, raw);
  add_reading_options(*mesh, raw.reading);
  add_surface_options(*mesh, raw);
  add_layer_options(*mesh, raw);
  add_volume_options(*mesh, raw);
  add_file_options(*mesh, raw);
  add_run_options(*mesh, raw);
  mesh->footer(kMeshExamples);
  return mesh;
}

MeshCommand make_mesh_command(const RawMeshOptions& raw) {
  MeshCommand command;
  command.input = raw.input;
  command.output = raw.output;
  command.sizes_file = raw.sizes_file;
  command.report = raw.report;
  command.quiet = raw.quiet;
  check_files(command);
  command.write = make_write_options(raw);
  command.metres_per_unit = metres_of(raw.unit);
  command.read = make_read_options(raw.reading);
  command.options.sizes = make_size_options(raw);
  // An STL file holds triangles alone: to fill the volume for it would be wasted.
  command.options.surface_only = raw.surface_only || lower_extension(command.output) == ".stl";
  command.options.refine_surface = !raw.no_refinement;
  command.options.most_refinement = refinement_factor(raw.refinement);
  command.options.keep_small_features = raw.keep_small_features;
  command.options.small_feature = positive("--small-feature", raw.small_feature, 0);
  command.options.improve_surface = !raw.keep_surface;
  command.options.keep_going = raw.keep_going;
  command.options.goals = make_goals(raw);
  command.options.lattice = raw.lattice == "a15" ? LatticeKind::A15 : LatticeKind::Bcc;
  if (raw.tets_per_part) {
    require(*raw.tets_per_part >= kFewestTetsPerPart, "--tets-per-part must be at least 1000");
    command.options.tets_per_part = *raw.tets_per_part;
  }
  command.options.threads = count_between("--threads", raw.threads, kMostThreads);
  command.options.parts = count_between("--parts", raw.parts, kMostParts);
  command.in_parts = is_in_parts(command.output, raw.parts);
  require(!command.in_parts || !command.options.surface_only,
          "only meshes of volumes can be dealt to parts, and --surface-only makes none");
  set_order(raw, command);
  set_groups(raw, command);
  set_far_field(raw, command);
  set_layers(raw, command);
  command.options.volume_worker = raw.worker;
  command.options.worker_only = raw.tetgen;
  if (!raw.max_memory.empty()) {
    const std::optional<std::uint64_t> bytes = parse_bytes(raw.max_memory);
    require(bytes.has_value(),
            "--max-memory must be a number of bytes such as 8G or 500M, not '" + raw.max_memory + "'");
    command.options.max_memory = *bytes;
  }
  return command;
}

}  // namespace tetloom::app
