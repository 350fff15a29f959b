// The command line of `adapt`, without a process.
#include <catch2/catch.hpp>
#include <cmath>

#include "apps/tetloom/options.hpp"

using namespace tetloom;
using namespace tetloom::app;

namespace {

AdaptCommand parse_adapt(const std::vector<const char*>& more, const char* input = "in.mesh",
                         const char* output = "out.mesh") {
  std::vector<const char*> arguments{"tetloom", "adapt", input, "-o", output};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return std::get<AdaptCommand>(parse_command_line(static_cast<int>(arguments.size()), arguments.data()));
}

}  // namespace

TEST_CASE("options of adapt are read") {
  const AdaptCommand plain = parse_adapt({"--metric", "a.sol"});
  CHECK(plain.metric_file == "a.sol");
  CHECK(plain.options.transfer.empty());
  CHECK(plain.options.quality_floor == AdaptOptions().quality_floor);
  CHECK(plain.hessian.gradation == 0);
  CHECK(plain.hessian.bounds.h_max == HUGE_VAL);
  CHECK(plain.model.empty());
  const AdaptCommand all = parse_adapt({"--hessian",
                                        "heat",
                                        "--complexity",
                                        "1e4",
                                        "--norm",
                                        "inf",
                                        "--h-min",
                                        "0.1",
                                        "--h-max",
                                        "2",
                                        "--max-aspect",
                                        "100",
                                        "--gradation",
                                        "1.5",
                                        "--transfer",
                                        "a,b",
                                        "--quality-floor",
                                        "0.2",
                                        "--tets-per-part",
                                        "5000",
                                        "--threads",
                                        "3",
                                        "--model",
                                        "m.step",
                                        "--curvature",
                                        "24",
                                        "--quiet",
                                        "--transfer-order",
                                        "1"});
  CHECK(all.hessian_field == "heat");
  CHECK(all.hessian.complexity == 1e4);
  CHECK(std::isinf(all.hessian.norm));
  CHECK(all.hessian.bounds.h_min == 0.1);
  CHECK(all.hessian.bounds.h_max == 2);
  CHECK(all.hessian.bounds.max_aspect == 100);
  CHECK(all.hessian.gradation == 1.5);
  CHECK(all.options.transfer == std::vector<std::string>{"a", "b"});
  CHECK(plain.options.cell_reconstruction == adapt::CellReconstruction::Linear);
  CHECK(all.options.cell_reconstruction == adapt::CellReconstruction::Constant);
  CHECK(all.options.quality_floor == 0.2);
  CHECK(all.options.tets_per_part == 5000);
  CHECK(all.options.threads == 3);
  CHECK(all.model == "m.step");
  CHECK(all.curvature == 24);
  CHECK(all.quiet);
}

TEST_CASE("adapt writes parts to a list of pieces, and where they are asked for") {
  CHECK_FALSE(parse_adapt({"--metric", "a.sol"}).in_parts);
  const AdaptCommand list = parse_adapt({"--metric", "a.sol"}, "in.pvtu", "out.pvtu");
  CHECK(list.in_parts);
  CHECK(list.options.parts == 0);
  const AdaptCommand file = parse_adapt({"--metric", "a.sol", "--parts", "7"}, "in.mesh", "out.msh");
  CHECK(file.in_parts);
  CHECK(file.options.parts == 7);
  CHECK_THROWS_AS(parse_adapt({"--metric", "a.sol", "--parts", "7"}), UsageError);
  CHECK_THROWS_AS(parse_adapt({"--metric", "a.sol", "--parts", "0"}, "in.mesh", "out.pvtu"), UsageError);
  CHECK_THROWS_AS(parse_adapt({"--metric", "out/a.sol"}, "in.mesh", "out.pvtu"), UsageError);
  CHECK_THROWS_AS(parse_adapt({"--metric", "a.sol", "--report", "out/r.json"}, "in.mesh", "out.pvtu"), UsageError);
  CHECK_THROWS_AS(parse_adapt({"--metric", "a.sol"}, "out/in.mesh", "out.pvtu"), UsageError);
}

TEST_CASE("wrong options of adapt are refused") {
  const std::vector<std::vector<const char*>> wrong{
      {},
      {"--metric", "a.sol", "--metric-field", "size"},
      {"--metric", "a.txt"},
      {"--hessian", "heat"},
      {"--complexity", "100", "--metric-field", "size"},
      {"--hessian", "heat", "--complexity", "0"},
      {"--hessian", "heat", "--complexity", "nan"},
      {"--hessian", "heat", "--complexity", "inf"},
      {"--hessian", "heat", "--complexity", "10", "--norm", "0.5"},
      {"--hessian", "heat", "--complexity", "10", "--norm", "nan"},
      {"--metric-field", "size", "--norm", "2"},
      {"--metric-field", "size", "--h-min", "-1"},
      {"--metric-field", "size", "--h-min", "2", "--h-max", "1"},
      {"--metric-field", "size", "--max-aspect", "0.5"},
      {"--metric-field", "size", "--gradation", "1"},
      {"--metric-field", "size", "--gradation", "-2"},
      {"--metric-field", "size", "--quality-floor", "1"},
      {"--metric-field", "size", "--quality-floor", "-0.5"},
      {"--metric-field", "size", "--threads", "0"},
      {"--metric-field", "size", "--tets-per-part", "10"},
      {"--metric-field", "size", "--curvature", "24"},
      {"--metric-field", "size", "--no-heal"},
      {"--metric-field", "size", "--fill-holes", "1"},
      {"--metric-field", "size", "--model", "m.step", "--feature-angle", "0"},
      {"--metric-field", "size", "--transfer", "a,b,a"},
      {"--metric-field", "size", "--transfer", "a", "--transfer-order", "3"},
      {"--metric-field", "size", "--transfer-order", "2"},
      {"--metric-field", ""},
      {"--metric-field", "size", "--report", "in.mesh"},
      {"--metric-field", "size", "--report", "out.mesh"},
      {"--metric-field", "size", "--model", "out.mesh"},
      {"--metric", "out.sol", "--transfer", "solution_1"},
      {"--metric-field", "size", "--transfer", "solution_1", "--report", "out.sol"},
  };
  for (const auto& more : wrong) {
    CAPTURE(more);
    CHECK_THROWS_AS(parse_adapt(more), UsageError);
  }
  const std::vector<const char*> right{"--metric-field", "size"};
  CHECK_THROWS_AS(parse_adapt(right, "in.mesh", "in.mesh"), UsageError);
  CHECK_THROWS_AS(parse_adapt(right, "in.mesh", "out.stl"), UsageError);
  CHECK_THROWS_AS(parse_adapt(right, "in.mesh", "out"), UsageError);
  CHECK_THROWS_AS(parse_adapt({"--metric-field", "size", "--transfer", "a"}, "in.mesh", "./in.meshb/../in.mesh"),
                  UsageError);
  CHECK_NOTHROW(parse_adapt(right));
}
