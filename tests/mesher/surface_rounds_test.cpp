// When the surface is made once more, and what comes after its last round.
#include <catch2/catch.hpp>

#include "mesher/intersection/self_intersection.hpp"
#include "mesher/surface_rounds.hpp"

using namespace tetloom;

namespace {

SurfaceRound crossing(std::size_t crossings, std::size_t triangles) { return {triangles, crossings, 0, 0, false}; }
SurfaceRound narrow(std::size_t misfits) { return {1000, 0, 0, misfits, false}; }

/// Decides on rounds until something else than Refine comes; returns that.
template <class RoundAt>
NextStep end_of(SurfaceRounds& rounds, const RoundAt& round_at) {
  NextStep step = NextStep::Refine;
  while (step == NextStep::Refine) {
    REQUIRE(rounds.count() < 20);
    step = rounds.decide(round_at(rounds.count()));
  }
  return step;
}

}  // namespace

TEST_CASE("a surface that fits is accepted at once, one with sheets that cross is judged", "[surface_rounds]") {
  CHECK(SurfaceRounds(true).decide(narrow(0)) == NextStep::Accept);
  CHECK(SurfaceRounds(false).decide(narrow(0)) == NextStep::Accept);
  CHECK(SurfaceRounds(true).decide({1000, 0, 3, 0, false}) == NextStep::Judge);
  CHECK(SurfaceRounds(true).decide({1000, 0, 0, 0, true}) == NextStep::Refine);
}

TEST_CASE("without refinement there is one round, in which nothing narrow is looked for", "[surface_rounds]") {
  SurfaceRounds rounds(false);
  CHECK_FALSE(rounds.seeks_misfits());
  CHECK(rounds.decide(crossing(5, 1000)) == NextStep::Judge);
}

TEST_CASE("crossings that stay as many while triangles double are the model's", "[surface_rounds]") {
  SurfaceRounds rounds(true);
  std::size_t triangles = 1000;
  CHECK(end_of(rounds, [&](int) { return crossing(10, triangles *= 2); }) == NextStep::KeepFacets);
  CHECK(rounds.count() == 5);
}

TEST_CASE("crossings that become fewer are refined as long as there are rounds", "[surface_rounds]") {
  SurfaceRounds rounds(true);
  CHECK(end_of(rounds, [&](int round) {
          return crossing(static_cast<std::size_t>(100 - round), std::size_t{1000} << round);
        }) == NextStep::KeepFacets);
  CHECK(rounds.count() == 7);
}

TEST_CASE("another round is made where it costs hardly a triangle", "[surface_rounds]") {
  SurfaceRounds rounds(true);
  CHECK(end_of(rounds, [](int round) {  // what crosses ends in the last but one round
          return round < 5 ? crossing(2, 1000 + 10 * static_cast<std::size_t>(round)) : narrow(0);
        }) == NextStep::Accept);
  CHECK(rounds.count() == 6);
}

TEST_CASE("where more crossings were found than are told, they may still become fewer", "[surface_rounds]") {
  const std::size_t most = IntersectionSearch{}.most;
  SurfaceRounds rounds(true);
  CHECK(end_of(rounds, [&](int round) {
          return round < 5 ? crossing(most, std::size_t{1000} << round) : crossing(0, std::size_t{1000} << round);
        }) == NextStep::Accept);
  CHECK(rounds.count() == 6);
}

TEST_CASE("narrow places count in the first three rounds", "[surface_rounds]") {
  SurfaceRounds rounds(true);
  for (int round = 0; round < 3; ++round) {
    CHECK(rounds.seeks_misfits());
    CHECK(rounds.decide(narrow(9)) == NextStep::Refine);
  }
  CHECK_FALSE(rounds.seeks_misfits());
  CHECK(rounds.last().misfits == 9);
}

TEST_CASE("a surface that crosses after one that did not is given up late, not early", "[surface_rounds]") {
  SurfaceRounds rounds(true);
  CHECK(rounds.decide(narrow(4)) == NextStep::Refine);
  CHECK(rounds.decide(crossing(3, 1000)) == NextStep::Refine);
  CHECK(rounds.decide(narrow(4)) == NextStep::Refine);
  CHECK(rounds.decide(crossing(3, 2000)) == NextStep::AcceptBefore);
}
