#include "bench/support/prediction.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace tetloom;
using namespace tetloom::bench;

namespace {

constexpr MessageCosts kFree{0, HUGE_VAL};
constexpr int kWorkers[] = {1, 2, 4, 64};

}  // namespace

TEST_CASE("what was not recorded of a stage stays serial") {
  RecordedStage stage{{}, 5};
  for (std::uint32_t part = 0; part < 4; ++part)
    stage.records.push_back({PartId(part), 0, "step", 0.5 + part, 1.5 + part});
  CHECK(stage.serial_seconds() == Approx(1));
  const auto predictions = predict(stage, kWorkers, kFree);
  REQUIRE(predictions.size() == 4);
  const double seconds[] = {5, 3, 2, 2};
  for (std::size_t i = 0; i < 4; ++i) {
    CAPTURE(i);
    CHECK(predictions[i].workers == kWorkers[i]);
    CHECK(predictions[i].seconds == Approx(seconds[i]));
    CHECK(predictions[i].speedup == Approx(5 / seconds[i]));
    CHECK(predictions[i].utilization == Approx(5 / (seconds[i] * kWorkers[i])));
  }
}

TEST_CASE("a stage without records is as fast on any number of workers") {
  for (const Prediction& one : predict({{}, 3}, kWorkers, kFree)) CHECK((one.seconds == 3 && one.speedup == 1));
  for (const Prediction& one : predict({{}, 0}, kWorkers, kFree)) CHECK((one.seconds == 0 && one.speedup == 1));
}

TEST_CASE("a prediction says that it is one, and of what") {
  const std::string text = describe_prediction({5e-6, 2e9});
  for (const char* part : {"not a measurement", "5 us", "2 GB/s", "serial"})
    CHECK(text.find(part) != std::string::npos);
}
