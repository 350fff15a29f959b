// The command line and the file of --sizes, without a process.
#include <catch2/catch.hpp>

#include "apps/tetloom/entity_sizes.hpp"
#include "apps/tetloom/options.hpp"
#include "apps/tetloom/quantities.hpp"

using namespace tetloom;
using namespace tetloom::app;

namespace {

Command parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "tetloom");
  return parse_command_line(static_cast<int>(arguments.size()), arguments.data());
}

MeshCommand parse_mesh(std::vector<const char*> more) {
  std::vector<const char*> arguments{"mesh", "in.step", "-o", "out.vtu"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return std::get<MeshCommand>(parse(arguments));
}

/// Topology and names, and no shape.
class NamedModel : public GeometricModel {
 public:
  NamedModel() {
    topology_.vertex_count = 2;
    topology_.face_to_loops.resize(3);
    topology_.region_to_faces.resize(1);
    attributes_[0].resize(2);
    attributes_[2].resize(3);
    attributes_[3].resize(1);
    attributes_[2][0].name = "flange";
    attributes_[2][2].name = "flange";
    attributes_[3][0].name = "steel body";
  }
  Vec3 vertex_point(ModelVertexId) const override { return {}; }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId) const override { return nullptr; }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId) const override { return nullptr; }
  double area(ModelFaceId) const override { return 0; }
  double volume(ModelRegionId) const override { return 0; }
};

SizeOptions sizes_for_named_model(const std::string& json) {
  SizeOptions options;
  apply_sizes(parse_sizes(json, "sizes.json"), NamedModel(), options);
  return options;
}

}  // namespace

TEST_CASE("without any size the target is a fortieth of the diagonal, with curvature") {
  const MeshCommand command = parse_mesh({});
  CHECK(command.options.sizes.relative_size == 1.0 / 40);
  CHECK(command.options.sizes.size == 0);
  CHECK(command.options.sizes.curvature == 24);
  CHECK(parse_mesh({"--curvature", "0"}).options.sizes.curvature == 0);
}

TEST_CASE("a size given turns the default curvature off") {
  CHECK(parse_mesh({"--size", "2"}).options.sizes.curvature == 0);
  CHECK(parse_mesh({"--size", "2"}).options.sizes.relative_size == 0);
  CHECK(parse_mesh({"--relative-size", "0.01"}).options.sizes.curvature == 0);
  CHECK(parse_mesh({"--size", "2", "--curvature", "12"}).options.sizes.curvature == 12);
}

TEST_CASE("every option of mesh reaches its place") {
  const MeshCommand c = parse_mesh({"--size",
                                    "2",
                                    "--min-size",
                                    "0.5",
                                    "--proximity",
                                    "3",
                                    "--gradation",
                                    "0.2",
                                    "--sizes",
                                    "s.json",
                                    "--threads",
                                    "3",
                                    "--report",
                                    "r.json",
                                    "--surface-only",
                                    "--no-surface-refinement",
                                    "--keep-surface",
                                    "--imprint",
                                    "--no-heal",
                                    "--feature-angle",
                                    "30",
                                    "--max-memory",
                                    "2G",
                                    "--min-dihedral",
                                    "20",
                                    "--min-mean-ratio",
                                    "0.6",
                                    "--rounds",
                                    "5",
                                    "--lattice",
                                    "a15",
                                    "--quiet",
                                    "--worker",
                                    "w"});
  CHECK(c.input == "in.step");
  CHECK(c.output == "out.vtu");
  CHECK(c.sizes_file == "s.json");
  CHECK(c.report == "r.json");
  CHECK(c.options.sizes.size == 2);
  CHECK(c.options.sizes.min_size == 0.5);
  CHECK(c.options.sizes.proximity == 3);
  CHECK(c.options.sizes.gradation == 0.2);
  CHECK(c.options.goals.dihedral == 20);
  CHECK(c.options.goals.mean_ratio == 0.6);
  CHECK(c.options.goals.rounds == 5);
  CHECK(c.options.lattice == LatticeKind::A15);
  CHECK(c.options.threads == 3);
  CHECK(c.options.parts == 0);
  CHECK_FALSE(c.in_parts);
  CHECK(c.options.surface_only);
  CHECK_FALSE(c.options.refine_surface);
  CHECK_FALSE(c.options.improve_surface);
  CHECK(c.options.max_memory == std::uint64_t{2} << 30);
  CHECK(c.options.volume_worker == "w");
  CHECK(c.read.imprint);
  CHECK_FALSE(c.read.heal);
  CHECK(c.read.feature_angle == Approx(0.5235987756));
  CHECK(c.quiet);
}

TEST_CASE("solids that touch are fused where the space around them is meshed, unless the geometry is to stay") {
  CHECK_FALSE(parse_mesh({}).read.imprint);
  CHECK(parse_mesh({"--far-field", "3"}).read.imprint);
  CHECK_FALSE(parse_mesh({"--far-field", "3", "--no-heal"}).read.imprint);
  CHECK(parse_mesh({"--far-field", "3", "--no-heal", "--imprint"}).read.imprint);
}

TEST_CASE("the unit and the form of the output reach their places, or are refused where they make no sense") {
  CHECK(parse_mesh({"--unit", "in"}).metres_per_unit == 0.0254);
  CHECK(parse_mesh({}).metres_per_unit == 0);
  CHECK_THROWS_AS(parse_mesh({"--unit", "furlong"}), UsageError);
  CHECK_THROWS_AS(parse_mesh({"--msh-version", "2.2"}), UsageError);  // the output is no .msh
  CHECK_THROWS_AS(parse_mesh({"--ascii"}), UsageError);
  const auto parts = std::get<MeshCommand>(
      parse({"mesh", "a.step", "-o", "b.foam", "--parts", "4", "--unit", "m", "--group", "load=faces:3"}));
  CHECK(parts.in_parts);
  CHECK(parts.metres_per_unit == 1);
  CHECK(parts.groups.size() == 1);
  CHECK_FALSE(std::get<MeshCommand>(parse({"mesh", "a.step", "-o", "b.foam"})).in_parts);
  const auto msh = std::get<MeshCommand>(parse({"mesh", "a.step", "-o", "b.msh", "--msh-version", "2.2", "--ascii"}));
  CHECK(msh.write.msh_2_2);
  CHECK(msh.write.text);
}

TEST_CASE("an STL output asks for the surface alone") {
  CHECK(std::get<MeshCommand>(parse({"mesh", "in.step", "-o", "out.STL"})).options.surface_only);
  CHECK_FALSE(std::get<MeshCommand>(parse({"mesh", "in.step", "-o", "out.msh"})).options.surface_only);
}

TEST_CASE("a list of pieces, and a number of parts, ask for parts") {
  const auto parse_output = [](const char* output, std::vector<const char*> more = {}) {
    std::vector<const char*> arguments{"mesh", "in.step", "-o", output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return std::get<MeshCommand>(parse(arguments));
  };
  CHECK(parse_output("out.pvtu").in_parts);
  CHECK(parse_output("out.pvtu").options.parts == 0);
  CHECK(parse_output("out.PVTU", {"--parts", "4"}).options.parts == 4);
  CHECK(parse_output("out.msh", {"--parts", "4"}).in_parts);
  CHECK_FALSE(parse_output("out.msh").in_parts);
  CHECK_THROWS_WITH(parse_output("out.vtu", {"--parts", "4"}), Catch::Contains("--parts"));
  CHECK_THROWS_WITH(parse_output("out.stl", {"--parts", "4"}), Catch::Contains("--parts"));
  CHECK_THROWS_WITH(parse_output("out.pvtu", {"--surface-only"}), Catch::Contains("--surface-only"));
  CHECK_THROWS_WITH(parse_output("out.pvtu", {"--report", "out/r.json"}), Catch::Contains("replace the output"));
}

TEST_CASE("values that make no sense are refused") {
  const std::vector<std::vector<const char*>> wrong{{"--size", "0"},
                                                    {"--size", "-1"},
                                                    {"--size", "nan"},
                                                    {"--size", "inf"},
                                                    {"--size", "two"},
                                                    {"--size", "1e999"},
                                                    {"--relative-size", "2"},
                                                    {"--relative-size", "0"},
                                                    {"--min-size", "-0.1"},
                                                    {"--curvature", "-1"},
                                                    {"--curvature", "nan"},
                                                    {"--proximity", "-2"},
                                                    {"--gradation", "0"},
                                                    {"--min-dihedral", "61"},
                                                    {"--min-dihedral", "-1"},
                                                    {"--min-dihedral", "nan"},
                                                    {"--min-mean-ratio", "1"},
                                                    {"--min-mean-ratio", "-0.1"},
                                                    {"--rounds", "-1"},
                                                    {"--rounds", "101"},
                                                    {"--rounds", "0.5"},
                                                    {"--lattice", "fcc"},
                                                    {"--threads", "0"},
                                                    {"--threads", "-1"},
                                                    {"--threads", "99999999999"},
                                                    {"--threads", "1.5"},
                                                    {"--parts", "0"},
                                                    {"--feature-angle", "0"},
                                                    {"--feature-angle", "181"},
                                                    {"--feature-angle", "nan"},
                                                    {"--max-memory", "lots"},
                                                    {"--max-memory", "0"},
                                                    {"--no-such-option"},
                                                    {"extra"},
                                                    {"--size"}};
  for (const auto& arguments : wrong) {
    CAPTURE(arguments);
    CHECK_THROWS_AS(parse_mesh(arguments), UsageError);
  }
  CHECK_THROWS_WITH(parse_mesh({"--size", "1", "--relative-size", "0.1"}), Catch::Contains("--relative-size"));
  CHECK_THROWS_WITH(parse_mesh({"--min-dihedral", "70"}), Catch::Contains("--min-dihedral") && Catch::Contains("60"));
}

TEST_CASE("the angle of fans lies between 45 and 180 degrees, or is 0, and needs layers") {
  const auto parse_angle = [](const char* angle) {
    return parse_mesh({"--layers", "*", "--first-height", "1", "--fan-angle", angle}).layers.fan_angle;
  };
  CHECK(parse_angle("0") == 0);
  CHECK(parse_angle("60") == 60);
  CHECK_FALSE(parse_mesh({"--layers", "*", "--first-height", "1"}).layers.fan_angle);
  for (const char* angle : {"-1", "44", "181", "nan", "wide"}) CHECK_THROWS_AS(parse_angle(angle), UsageError);
  CHECK_THROWS_WITH(parse_mesh({"--fan-angle", "60"}), Catch::Contains("need --layers"));
}

TEST_CASE("a command line without what it needs is refused") {
  CHECK_THROWS_AS(parse({}), UsageError);
  CHECK_THROWS_AS(parse({"dance"}), UsageError);
  CHECK_THROWS_AS(parse({"mesh"}), UsageError);
  CHECK_THROWS_AS(parse({"mesh", "in.step"}), UsageError);
  CHECK_THROWS_AS(parse({"info"}), UsageError);
  CHECK_THROWS_WITH(parse({"mesh", "in.step", "-o", "out.docx"}),
                    Catch::Contains("out.docx") && Catch::Contains(".vtu"));
  CHECK_THROWS_WITH(parse({"mesh", "in.step", "-o", "out"}), Catch::Contains("extension"));
  CHECK_THROWS_WITH(parse({"mesh", "a.stl", "-o", "./a.stl"}), Catch::Contains("replace the input"));
  CHECK_THROWS_WITH(parse({"mesh", "a.stl", "-o", "b.stl", "--report", "b.stl"}),
                    Catch::Contains("replace the output"));
  CHECK_THROWS_WITH(parse({"check", "a.vtu", "--report", "a.vtu"}), Catch::Contains("replace the input"));
  CHECK_THROWS_WITH(parse({"check", "a.vtu", "--threads", "0"}), Catch::Contains("--threads"));
}

TEST_CASE("meshes are looked at on all cores, or on as many threads as are asked for") {
  CHECK(std::get<CheckCommand>(parse({"check", "a.vtu"})).threads == 0);
  CHECK(std::get<CheckCommand>(parse({"check", "a.vtu", "--threads", "3"})).threads == 3);
  CHECK(std::get<InfoCommand>(parse({"info", "a.vtu", "--threads", "3"})).threads == 3);
}

TEST_CASE("help and version are printed and done") {
  CHECK_THAT(std::get<Printout>(parse({"--version"})).text, Catch::StartsWith("tetloom "));
  CHECK_THAT(std::get<Printout>(parse({"--help"})).text, Catch::Contains("mesh") && Catch::Contains("Examples"));
  CHECK_THAT(std::get<Printout>(parse({"mesh", "--help"})).text,
             Catch::Contains("--relative-size") && Catch::Contains("Exit status"));
}

TEST_CASE("the report is found on a command line that cannot be parsed") {
  const auto find = [](std::vector<const char*> a) {
    return find_report_argument(static_cast<int>(a.size()), a.data());
  };
  CHECK(find({"tetloom", "mesh", "--nonsense", "--report", "r.json"}) == "r.json");
  CHECK(find({"tetloom", "mesh", "--report=r.json", "--nonsense"}) == "r.json");
  CHECK_FALSE(find({"tetloom", "mesh", "--report"}).has_value());
  CHECK_FALSE(find({"tetloom", "--report="}).has_value());
}

TEST_CASE("bytes are read with their suffix") {
  CHECK(parse_bytes("4096") == 4096);
  CHECK(parse_bytes("8G") == std::uint64_t{8} << 30);
  CHECK(parse_bytes("1.5 GiB") == std::uint64_t{3} << 29);
  CHECK(parse_bytes("500MB") == std::uint64_t{500} << 20);
  CHECK(parse_bytes("2k") == 2048);
  for (const char* wrong : {"", "G", "-1G", "8X", "8GG", "nan", "inf", "0", "1e30", "99999999T", "0.1"}) {
    CAPTURE(wrong);
    CHECK_FALSE(parse_bytes(wrong).has_value());
  }
}

TEST_CASE("numbers are shown the way people write them") {
  CHECK(format_count(0) == "0");
  CHECK(format_count(999) == "999");
  CHECK(format_count(1234567) == "1,234,567");
  CHECK(format_short(12) == "12");
  CHECK(format_short(12345) == "12.3k");
  CHECK(format_short(999999) == "1.00M");
  CHECK(format_seconds(0.123) == "0.12 s");
  CHECK(format_seconds(200) == "3 min 20 s");
  CHECK(format_seconds(7500) == "2 h 5 min");
  CHECK(format_bytes(1.5 * (1 << 30)) == "1.5 GiB");
  CHECK(format_share(0.9561) == "95.6 %");
  CHECK(format_share(0.0001) == "0.010 %");
  CHECK(format_share(1) == "100.0 %");
}

TEST_CASE("sizes of entities are found by tag and by name") {
  const SizeOptions options = sizes_for_named_model(
      R"({"entities": [{"dim": 0, "tag": 2, "size": 0.5}, {"name": "flange", "size": 1},
                       {"dim": 3, "name": "steel body", "size": 2}],
          "points": [{"point": [1, 2, 3], "size": 0.1}]})");
  REQUIRE(options.entity_sizes.size() == 4);
  CHECK(options.entity_sizes[0].entity == ModelEntity(0, 1));
  CHECK(options.entity_sizes[0].size == 0.5);
  CHECK(options.entity_sizes[1].entity == ModelEntity(2, 0));
  CHECK(options.entity_sizes[2].entity == ModelEntity(2, 2));
  CHECK(options.entity_sizes[3].entity == ModelEntity(3, 0));
  REQUIRE(options.point_sizes.size() == 1);
  CHECK(options.point_sizes[0].point == Vec3{1, 2, 3});
}

TEST_CASE("sizes for what the model does not have name all of it") {
  CHECK_THROWS_WITH(
      sizes_for_named_model(R"({"entities": [{"name": "flnge", "size": 1}, {"dim": 2, "tag": 9, "size": 1},
                                                           {"dim": 0, "name": "flange", "size": 1}]})"),
      Catch::Contains("'flnge' (did you mean 'flange'?)") && Catch::Contains("face 9 (the model has 3)") &&
          Catch::Contains("vertex named 'flange'"));
}

TEST_CASE("a file of sizes that is wrong says where") {
  CHECK_THROWS_WITH(sizes_for_named_model("{\n\"entities\": [\n}"),
                    Catch::Contains("sizes.json") && Catch::Contains("line 3"));
  CHECK_THROWS_WITH(sizes_for_named_model("[]"), Catch::Contains("must be an object"));
  CHECK_THROWS_WITH(sizes_for_named_model(R"({"entitys": []})"), Catch::Contains("unknown key 'entitys'"));
  const std::vector<std::pair<const char*, const char*>> wrong{
      {R"({"dim": 2, "tag": 1})", "has no 'size'"},
      {R"({"dim": 2, "tag": 1, "size": 0})", "must be positive"},
      {R"({"dim": 2, "tag": 1, "size": "big"})", "must be a number"},
      {R"({"dim": 2, "tag": 1, "size": 1e999})", ""},
      {R"({"dim": 2, "tag": 0, "size": 1})", "'tag'"},
      {R"({"dim": 4, "tag": 1, "size": 1})", "'dim'"},
      {R"({"dim": 2, "tag": 1.5, "size": 1})", "'tag'"},
      {R"({"tag": 1, "size": 1})", "needs a 'dim'"},
      {R"({"dim": 2, "size": 1})", "either a 'tag' or a 'name'"},
      {R"({"dim": 2, "tag": 1, "name": "x", "size": 1})", "either a 'tag' or a 'name'"},
      {R"({"name": "", "size": 1})", "not empty"},
      {R"({"name": "x", "size": 1, "colour": 1})", "unknown key 'colour'"},
      {R"(7)", "must be an object"}};
  for (const auto& [entry, message] : wrong) {
    CAPTURE(entry);
    CHECK_THROWS_WITH(sizes_for_named_model(std::string("{\"entities\": [") + entry + "]}"), Catch::Contains(message));
  }
  CHECK_THROWS_WITH(sizes_for_named_model(R"({"points": [{"point": [1, 2], "size": 1}]})"),
                    Catch::Contains("points[0]") && Catch::Contains("three numbers"));
}
