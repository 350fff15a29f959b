#include "bench/support/category_panel.hpp"

#include <catch2/catch.hpp>

using namespace tetloom::bench;

TEST_CASE("columns and contenders come in the order in which they first appear") {
  const Panel panel = draw_categories("speed", "model", "tets", {{"b", "one", 1}, {"b", "two", 2}, {"a", "two", 3}});
  REQUIRE(panel.x.ticks.size() == 4);
  CHECK((panel.x.ticks[1].label == "b" && panel.x.ticks[2].label == "a"));
  REQUIRE(panel.series.size() == 2);
  CHECK((panel.series[0].name == "one" && panel.series[0].points.size() == 1));
  REQUIRE(panel.series[1].points.size() == 2);
  CHECK((panel.series[1].points[1].x == 2 && panel.series[1].points[1].y == 3));
  CHECK_FALSE(render_svg({"figure", {}, {panel}, 0}).empty());
}
