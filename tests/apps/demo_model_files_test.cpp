// What the generator of demo models writes.
#include <catch2/catch.hpp>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "tests/apps/command_process.hpp"

using namespace tetloom::test;

namespace {

std::string read_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string make(const TestFolder& folder, const std::string& model, const std::string& file) {
  REQUIRE(run_process({TETLOOM_DEMO_MODEL, model, folder / file}).status == 0);
  return read_text(folder / file);
}

std::size_t count_of(const std::string& what, const std::string& text) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("every demo model of the list is written, and the same bytes each time") {
  const TestFolder folder;
  const ProcessResult list = run_process({TETLOOM_DEMO_MODEL, "list"});
  REQUIRE(list.status == 0);
  std::istringstream names(list.out);
  std::vector<std::string> models;
  for (std::string name; names >> name;) models.push_back(name);
  CHECK(models == std::vector<std::string>{"machined-part", "assembly", "filleted-plate", "spline-block", "sphere",
                                           "hollow-sphere", "manifold"});
  for (const std::string& model : models) {
    CAPTURE(model);
    const std::string first = make(folder, model, "first.step");
    CHECK(first.starts_with("ISO-10303-21;"));
    // Several times, because what depends on addresses differs in some runs only.
    bool all_same = true;
    for (int run = 0; run < 4; ++run) all_same = all_same && first == make(folder, model, "again.step");
    CHECK(all_same);
  }
}

TEST_CASE("all faces of the spline block lie on B-spline surfaces, of the machined part only one") {
  const TestFolder folder;
  const std::string spline = make(folder, "spline-block", "spline.step");
  CHECK(count_of("ADVANCED_FACE(", spline) == 22);
  CHECK(count_of("B_SPLINE_SURFACE_WITH_KNOTS(", spline) == 22);
  for (const char* other : {"PLANE(", "CYLINDRICAL_SURFACE(", "TOROIDAL_SURFACE(", "SURFACE_OF_REVOLUTION("}) {
    CHECK(count_of(other, spline) == 0);
  }
  CHECK(count_of("B_SPLINE_SURFACE_WITH_KNOTS(", make(folder, "machined-part", "part.step")) == 1);
}

TEST_CASE("the solids of the demo assembly have names and colours, and share faces once they are imprinted") {
  const TestFolder folder;
  make(folder, "assembly", "assembly.step");
  const auto shared_faces = [&](std::vector<std::string> extra) {
    std::vector<std::string> arguments{"info", folder / "assembly.step", "--report", folder / "info.json", "--quiet"};
    arguments.insert(arguments.end(), extra.begin(), extra.end());
    REQUIRE(run_tetloom(arguments).status == 0);
    const nlohmann::json model = read_json(folder / "info.json")["model"];
    std::vector<std::string> names;
    for (const auto& region : model["regions"]) {
      names.push_back(region["name"]);
      CHECK(region["color"].is_string());
    }
    CHECK(names == std::vector<std::string>{"steel body", "rubber seal"});
    std::size_t shared = 0;
    for (const auto& face : model["faces"]) shared += face["front"].is_null() || face["back"].is_null() ? 0 : 1;
    return shared;
  };
  CHECK(shared_faces({}) == 0);
  CHECK(shared_faces({"--imprint"}) == 2);
}
