// The generated CAD models are what they claim to be.
#include <catch2/catch.hpp>

#include "tests/apps/command_process.hpp"

using namespace tetloom::test;

namespace {

nlohmann::json info(const TestFolder& folder, const std::string& path) {
  REQUIRE(run_tetloom({"info", path, "--report", folder / "info.json", "--quiet"}).status == 0);
  return read_json(folder / "info.json")["model"];
}

}  // namespace

TEST_CASE("each demo model has the faces and the volume that it should have") {
  const TestFolder folder;
  const auto part = info(folder, demo_model("part"));
  CHECK(part["counts"]["regions"] == 1);
  CHECK(part["counts"]["faces"] > 30);
  CHECK(part["regions"][0]["volume"].get<double>() == Approx(184760).epsilon(0.01));
  const auto plate = info(folder, demo_model("plate"));
  // 30 holes with two rims each, top and bottom, four sides, four rounded corners.
  CHECK(plate["counts"]["faces"] == 30 * 3 + 10);
  const auto spline = info(folder, demo_model("spline"));
  CHECK(spline["counts"]["faces"] == 22);
  CHECK(spline["regions"][0]["volume"].get<double>() == Approx(807467).epsilon(0.01));
}

TEST_CASE("a generator asked for what it cannot make says so") {
  const TestFolder folder;
  CHECK(run_process({TETLOOM_DEMO_MODEL}).status == 2);
  CHECK(run_process({TETLOOM_DEMO_MODEL, "horse", folder / "x.step"}).status == 2);
  CHECK(run_process({TETLOOM_DEMO_MODEL, "plate", folder / "x.step", "0"}).status == 1);
  CHECK(run_process({TETLOOM_DEMO_MODEL, "spline", folder / "x.step", "2", "1"}).status == 1);
  CHECK(run_process({TETLOOM_DEMO_MODEL, "part", folder / "no such folder/x.step"}).status == 1);
  CHECK(folder.files().empty());
}
