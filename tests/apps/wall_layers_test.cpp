// --layers: walls by tags, names and files.
#include <catch2/catch.hpp>
#include <fstream>

#include "apps/tetloom/wall_layers.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/mesh.hpp"

using namespace tetloom;
using namespace tetloom::app;
using test::error_of;

namespace {

WallLayers common() {
  WallLayers layers;
  layers.first_height = 0.1;
  layers.count = 4;
  return layers;
}

std::vector<std::uint32_t> tags_of(const std::string& text) {
  std::vector<std::uint32_t> tags;
  const auto box = test_models::make_box({0, 0, 0}, {1, 1, 1});
  for (const WallLayers& wall : find_wall_layers(parse_layers(text, common()), *box).walls)
    tags.push_back(wall.face.tag());
  return tags;
}

}  // namespace

TEST_CASE("walls are named by tags, ranges, everything, and everything but some") {
  CHECK(tags_of("2,4-5") == std::vector<std::uint32_t>{2, 4, 5});
  CHECK(tags_of("*").size() == 6);
  CHECK(tags_of("*,!1,!6") == std::vector<std::uint32_t>{2, 3, 4, 5});
  CHECK(error_of([] { tags_of("7"); }).message.find("'7'") != std::string::npos);
  CHECK(error_of([] { tags_of("wall*"); }).code == ErrorCode::InvalidArgument);
  CHECK(error_of([] { tags_of("1,!1"); }).code == ErrorCode::InvalidArgument);
  CHECK(error_of([] { tags_of("!1"); }).code == ErrorCode::InvalidArgument);
  CHECK(error_of([] { tags_of(""); }).code == ErrorCode::InvalidArgument);
  CHECK(error_of([] { tags_of("1,,2"); }).code == ErrorCode::InvalidArgument);
}

TEST_CASE("walls of a model without regions are refused with a face and a place") {
  const auto plate = test_models::make_plate(1, 1);
  REQUIRE(plate->topology().region_count() == 0);
  MeshOptions options;
  options.layers = find_wall_layers(parse_layers("*", common()), *plate);
  const Diagnostic error = error_of([&] { static_cast<void>(make_mesh(*plate, options)); });
  CHECK(error.code == ErrorCode::InvalidArgument);
  CHECK_FALSE(error.entities.empty());
  CHECK(error.point);
}

TEST_CASE("a file of walls has settings for each entry, the last one of a face holds") {
  const test::TemporaryFolder folder;
  const std::string path = (folder.path() / "walls.json").string();
  const auto read = [&](const std::string& text) {
    std::ofstream(path) << text;
    const auto box = test_models::make_box({0, 0, 0}, {1, 1, 1});
    return find_wall_layers(parse_layers(path, common()), *box);
  };
  const LayerOptions options = read(R"({"all_tets": true, "fan_angle": 90, "walls": [{"faces": ["*"], "growth": 1.5},
      {"faces": [3], "first_height": 0.2, "count": 0, "thickness": 2, "side": "back"}]})");
  CHECK(options.all_tets);
  CHECK(options.fan_angle == 90);
  REQUIRE(options.walls.size() == 6);
  CHECK(options.walls[0].growth == 1.5);
  CHECK(options.walls[0].first_height == 0.1);
  CHECK(options.walls[2].first_height == 0.2);
  CHECK(options.walls[2].growth == 1.2);
  CHECK(options.walls[2].count == 0);
  CHECK_FALSE(options.walls[2].in_front);
  for (const char* text :
       {"", "{", "[]", "{}", R"({"walls": []})", R"({"walls": [{}]})", R"({"walls": [{"faces": []}]})",
        R"({"walls": [{"faces": [1], "first_hight": 1}]})", R"({"walls": [{"faces": [1], "side": "left"}]})",
        R"({"walls": [{"faces": [1], "count": -1}]})", R"({"walls": [{"faces": [1], "count": 1.5}]})",
        R"({"walls": [{"faces": [1]}], "all_tets": 1})", R"({"walls": [{"faces": [1]}], "fan_angle": "65"})",
        R"({"walls": [{"faces": [1], "y_plus": 1}]})", R"({"walls": [{"faces": [99]}]})"})
    CHECK(error_of([&] { read(text); }).code == ErrorCode::InvalidArgument);
}

TEST_CASE("wall units become a height") {
  // Air along a plate of a metre at 33 m/s: y+ = 1 lies about 11 micrometres above it.
  CHECK(height_of({1, 33, 1.2, 1.8e-5, 1}) == Approx(1.1e-5).epsilon(0.1));
}
