// The size field meets what is asked of it: sizes, gradation, callback, and the same tree for any number of threads.
#include <catch2/catch.hpp>

#include <chrono>
#include <cmath>
#include <iostream>

#include "mesher/sizing/source_tree.hpp"
#include "tests/mesher/size_field_fixture.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/simulated_ranks.hpp"

namespace tetloom {
namespace {

using test_sizes::build;
using test_sizes::RandomPoints;
using test_sizes::unit_box;
using test_sizes::values_of;

const Box3 kUnitBox{{0, 0, 0}, {1, 1, 1}};

ModelEntity face(std::size_t i) { return ModelFaceId(i); }

}  // namespace

TEST_CASE("a model with one size has a uniform field of exactly that size") {
  const auto model = unit_box();
  CHECK(build(*model, {.size = 0.123}).size_at({5, 5, 5}) == 0.123);
  CHECK(build(*model, {.size = 0.123}).is_uniform());
  CHECK(build(*model, {.relative_size = 0.01}).largest() == 0.01 * model->bounding_box().diagonal());
  CHECK(build(*model, {}).largest() == Approx(std::sqrt(3.0) / 40));
  SECTION("curvature and proximity add nothing to a thick box") {
    const SizeField field = build(*model, {.size = 0.2, .curvature = 24, .proximity = 3});
    CHECK(field.is_uniform());
    CHECK(field.size_at({0.5, 0.5, 0.5}) == 0.2);
  }
  SECTION("a wish for more than the global size is overruled by it") {
    const SizeOptions options{.size = 0.1, .entity_sizes = {{face(0), 0.3}}, .point_sizes = {{{0, 0, 0}, 0.1}}};
    CHECK(build(*model, options).is_uniform());
  }
}

TEST_CASE("the global size is exact wherever nothing smaller reaches") {
  const auto model = test_models::make_box({0, 0, 0}, {10, 10, 10});
  const double global = 0.73, small = 0.05, gradation = 0.3;
  const SizeField field = build(*model, {.size = global, .gradation = gradation, .point_sizes = {{{1, 2, 1}, small}}});
  const double reach = small + (global - small) / gradation;
  RandomPoints random(model->bounding_box(), 1);
  int exact = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 x = random.point();
    if (distance(x, {1, 2, 1}) < reach + 3 * global) continue;
    REQUIRE(field.size_at(x) == global);
    ++exact;
  }
  CHECK(exact > 1000);
  CHECK(field.size_at({1, 2, 1}) == Approx(small).epsilon(0.05));
}

TEST_CASE("sizes of entities hold on the entity and its closure") {
  const auto model = unit_box();
  const double small = 0.02;
  SECTION("vertex") {
    const SizeField field = build(*model, {.size = 0.2, .entity_sizes = {{ModelVertexId(std::size_t{7}), small}}});
    CHECK(field.size_at({1, 1, 1}) == Approx(small).epsilon(0.03));
    CHECK(field.size_at({0, 0, 0}) == 0.2);
  }
  SECTION("edge") {
    const SizeField field = build(*model, {.size = 0.2, .entity_sizes = {{ModelEdgeId(std::size_t{0}), small}}});
    const auto edge = model->edge_geometry(ModelEdgeId(std::size_t{0}));
    for (double t = 0; t <= 1; t += 1.0 / 64) CHECK(field.size_at(edge->evaluate(t)) == Approx(small).epsilon(0.05));
  }
  SECTION("face") {
    const SizeField field = build(*model, {.size = 0.2, .entity_sizes = {{face(0), small}}});
    RandomPoints random(kUnitBox, 2);
    for (int i = 0; i < 1000; ++i) {
      Vec3 x = random.point();
      x.x = 0;
      REQUIRE(field.size_at(x) == Approx(small).epsilon(0.05));
    }
    CHECK(field.size_at({1, 0.5, 0.5}) == 0.2);
  }
  SECTION("the smaller of two wishes wins") {
    const SizeField field = build(*model, {.size = 0.2, .entity_sizes = {{face(0), 0.1}, {face(0), small}}});
    CHECK(field.size_at({0, 0.5, 0.5}) == Approx(small).epsilon(0.05));
  }
}

TEST_CASE("the size of a region holds in its interior and not in its neighbour") {
  const std::shared_ptr<const GeometricModel> a = test_models::make_box({0, 0, 0}, {1, 1, 1}),
                                              b = test_models::make_sphere({3, 0.5, 0.5}, 1);
  const std::array bodies{a, b};
  const auto model = test_models::combine(bodies);
  const double small = 0.04;
  const SizeField field = build(*model, {.size = 0.2, .entity_sizes = {{ModelRegionId(std::size_t{1}), small}}});
  RandomPoints random({{2, -0.5, -0.5}, {4, 1.5, 1.5}}, 3);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 x = random.point();
    if (distance(x, {3, 0.5, 0.5}) > 0.99) continue;
    REQUIRE(field.size_at(x) == Approx(small).epsilon(0.05));
  }
  CHECK(field.size_at({0.5, 0.5, 0.5}) == 0.2);
  CHECK(field.size_at({3, 0.5, 0.5}) == static_cast<float>(small / 0.2) * 0.2);
  CHECK(field.leaf_count() < 100000);  // the interior is not cut
}

TEST_CASE("point sizes and refinements are met, below every floor") {
  const auto model = unit_box();
  const Vec3 place{0.3, 0.4, 0.5};
  const std::vector<SizeRefinement> refinements{{{place, place, place}, 1e-4}};
  const SizeField field =
      build(*model, {.size = 0.2, .min_size = 0.1, .point_sizes = {{{0.8, 0.8, 0.8}, 3e-3}}}, 2, refinements);
  CHECK(field.size_at({0.3, 0.4, 0.5}) == Approx(1e-4).epsilon(0.05));
  CHECK(field.size_at({0.8, 0.8, 0.8}) == Approx(3e-3).epsilon(0.05));
  SECTION("also when the point lies outside of the model") {
    const SizeField outside = build(*model, {.size = 0.2, .point_sizes = {{{-0.1, 0.5, 0.5}, 0.01}}});
    CHECK(outside.size_at({0, 0.5, 0.5}) == Approx(0.01 + 0.3 * (0.1 - 0.0095)).epsilon(0.05));
  }
  SECTION("and a point a billion times smaller than the model costs little") {
    const SizeField tiny = build(*model, {.size = 0.2, .point_sizes = {{{0.3, 0.4, 0.5}, 1e-10}}});
    CHECK(tiny.size_at({0.3, 0.4, 0.5}) == Approx(1e-10).epsilon(0.05));
    CHECK(tiny.leaf_count() < 100000);
  }
}

TEST_CASE("the field grows at most by the gradation and answers little more than the exact field") {
  const unsigned seed = 5;
  INFO("seed " << seed);
  const auto model = unit_box();
  RandomPoints random(kUnitBox, seed);
  for (const double gradation : {0.1, 0.3, 0.7, 5.0}) {
    INFO("gradation " << gradation);
    SizeOptions options{.size = 0.2, .gradation = gradation};
    std::vector<SizeSource> sources;
    for (int i = 0; i < 10; ++i) {
      const PointSize wish{random.point(), 0.005 + 0.02 * random.unit()};
      options.point_sizes.push_back(wish);
      sources.push_back({wish.point, wish.point, wish.point, wish.size});
    }
    const SizeField field = build(*model, options);
    const double slope = std::min(gradation, 1.0);
    const SourceTree exact(sources, slope, TaskRunner(1));
    for (int i = 0; i < 20000; ++i) {
      const Vec3 x = random.point();
      const double size = field.size_at(x);
      std::uint32_t winner = SourceTree::kNoSource;
      REQUIRE(size <= 1.1 * exact.size_at(x, 0.2, winner));
      REQUIRE(size >= 0.8 * exact.size_at(x, 0.2, winner));
      const double step = size * (0.5 + 3 * random.unit());
      const Vec3 y = x + step * random.direction();
      if (kUnitBox.contains(y)) REQUIRE(std::abs(field.size_at(y) - size) <= 1.25 * slope * step);
    }
  }
}

TEST_CASE("nearest sources are found as by brute force") {
  const unsigned seed = 6;
  INFO("seed " << seed);
  RandomPoints random(kUnitBox, seed);
  std::vector<SizeSource> sources;
  for (int i = 0; i < 300; ++i) {
    SizeSource source{random.point(), {}, {}, 0.01 + 0.05 * random.unit()};
    source.b = i % 3 == 0 ? source.a : source.a + 0.1 * random.direction();
    source.c = i % 3 <= 1 ? source.b : source.a + 0.1 * random.direction();
    sources.push_back(source);
  }
  const SourceTree tree(sources, 0.3, TaskRunner(2));
  std::uint32_t seeded = SourceTree::kNoSource;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x = random.point();
    double expected = 1;
    for (const SizeSource& s : sources)
      expected = std::min(expected, SourceTree({s}, 0.3, TaskRunner(1)).size_at(x, 1, seeded = SourceTree::kNoSource));
    std::uint32_t winner = i % 2 == 0 ? SourceTree::kNoSource : static_cast<std::uint32_t>(i % 300);
    REQUIRE(tree.size_at(x, 1, winner) == Approx(expected).epsilon(1e-12));
    REQUIRE(tree.source_size(winner) <= expected);
    REQUIRE(tree.size_at(x, 0.9 * expected, winner) == 0.9 * expected);
  }
}

TEST_CASE("a callback is followed where it varies and spread by the gradation") {
  const auto model = unit_box();
  SECTION("a smooth one") {
    SizeOptions options{.size = 0.3};
    options.callback = [](const Vec3& x) { return 0.01 + 0.2 * norm2(x - Vec3{0.5, 0.5, 0.5}); };
    options.gradation = 1;
    const SizeField field = build(*model, options);
    RandomPoints random(kUnitBox, 7);
    for (int i = 0; i < 5000; ++i) {
      const Vec3 x = random.point();
      REQUIRE(field.size_at(x) == Approx(options.callback(x)).epsilon(0.12));
    }
  }
  SECTION("one with a jump") {
    SizeOptions options{.size = 0.3, .gradation = 0.3};
    const Vec3 center{0.4, 0.5, 0.6};
    options.callback = [&](const Vec3& x) { return distance(x, center) < 0.2 ? 0.02 : -1.0; };
    const SizeField field = build(*model, options);
    CHECK(field.size_at(center) == Approx(0.02).epsilon(0.01));
    CHECK(field.size_at(center + Vec3{0.1, 0, 0}) == Approx(0.02).epsilon(0.01));
    RandomPoints random(kUnitBox, 8);
    for (int i = 0; i < 5000; ++i) {
      const Vec3 x = random.point();
      const double beyond = std::max(0.0, distance(x, center) - 0.2);
      REQUIRE(field.size_at(x) <= 1.25 * (0.02 + 0.3 * beyond));
      REQUIRE(field.size_at(x) >= std::min(0.3, 0.015 + 0.2 * beyond));
    }
  }
  SECTION("one that wishes nothing") {
    SizeOptions options{.size = 0.3};
    options.callback = [](const Vec3&) { return std::nan(""); };
    const SizeField field = build(*model, options);
    CHECK(field.size_at({0.2, 0.3, 0.4}) == 0.3);
  }
  SECTION("one that throws reaches the caller") {
    SizeOptions options{.size = 0.3};
    options.callback = [](const Vec3&) -> double { throw std::runtime_error("from the host"); };
    CHECK_THROWS_WITH(build(*model, options), "from the host");
  }
}

TEST_CASE("the field is the same, bit for bit, for any number of threads") {
  const auto torus = test_models::make_torus(3, 1);
  SizeOptions options{.size = 0.5, .curvature = 24, .proximity = 5};
  options.point_sizes = {{{3, 0, 0}, 0.02}};
  options.entity_sizes = {{ModelRegionId(std::size_t{0}), 0.3}};
  SECTION("from sources") {}
  SECTION("with a callback") {
    options.callback = [](const Vec3& x) { return 0.1 + 0.3 * std::abs(std::sin(3 * x.x)); };
  }
  const std::vector<Vec3> reference = values_of(build(*torus, options, 1));
  for (const int threads : {2, 3, 8}) CHECK(values_of(build(*torus, options, threads)) == reference);
}

TEST_CASE("refinements that come in rounds give the field that they give at once") {
  const unsigned seed = 10;
  INFO("seed " << seed);
  const auto torus = test_models::make_torus(3, 1);
  SizeOptions options{.size = 0.5, .curvature = 24};
  SECTION("on top of curvature") {}
  SECTION("with a region of its own size") { options.entity_sizes = {{ModelRegionId(std::size_t{0}), 0.3}}; }
  SECTION("with a callback") {
    options.callback = [](const Vec3& x) { return 0.1 + 0.3 * std::abs(std::sin(3 * x.x)); };
  }
  RandomPoints random(torus->bounding_box(), seed);
  std::vector<SizeRefinement> refinements;
  const TaskRunner runner(2);
  // The cube of the tree is chosen by the first build.
  SizeFieldBuilder in_rounds(*torus, options, runner), at_once(*torus, options, runner);
  in_rounds.build(refinements);
  at_once.build(refinements);
  std::vector<Vec3> last;
  for (int round = 0; round < 3; ++round) {
    for (int i = 0; i < 10; ++i) {
      const double turn = 6.28 * random.unit();
      const Vec3 x = Vec3{3 * std::cos(turn), 3 * std::sin(turn), 0} + 0.8 * random.unit() * random.direction();
      refinements.push_back({{x, x, x + 0.1 * random.direction()}, 0.01 + 0.05 * random.unit()});
    }
    std::vector<SizeRefinement> not_taken = refinements;
    not_taken.resize(refinements.size() - 5);
    not_taken.push_back({refinements[0].corners, 0.01});
    in_rounds.build(not_taken);
    last = values_of(in_rounds.build(refinements).sizes);
  }
  CHECK(last == values_of(at_once.build(refinements).sizes));
  SECTION("and others than before are not taken for more of them") {
    refinements.erase(refinements.begin());
    const SizeField other = in_rounds.build(refinements).sizes;
    for (const SizeRefinement& wish : refinements) CHECK(other.size_at(wish.corners[0]) <= 1.1 * wish.size);
    CHECK(values_of(other) == values_of(build(*torus, options, 1, refinements)));
  }
}

TEST_CASE("ranks that remember shares of the field have that of one process, round after round") {
  const auto torus = test_models::make_torus(3, 1);
  SizeOptions options{.size = 0.5, .curvature = 24};
  SECTION("on top of curvature") {}
  SECTION("with a callback") {
    options.callback = [](const Vec3& x) { return 0.1 + 0.3 * std::abs(std::sin(3 * x.x)); };
  }
  const auto build_rounds = [&](const SharedWork& work) {
    RandomPoints random(torus->bounding_box(), 11);
    std::vector<SizeRefinement> refinements;
    SizeFieldBuilder builder(*torus, options, work);
    std::vector<Vec3> values;
    for (int round = 0; round < 3; ++round) {
      for (const Vec3& value : values_of(builder.build(refinements).sizes)) values.push_back(value);
      for (int i = 0; i < 10; ++i) {
        const Vec3 x = random.point();
        refinements.push_back({{x, x, x + 0.1 * random.direction()}, 0.01 + 0.05 * random.unit()});
      }
    }
    return values;
  };
  const std::vector<Vec3> alone = build_rounds(TaskRunner(1));
  for (const int ranks : test::kSanitized ? std::vector{3} : std::vector{2, 3, 5}) {
    std::vector<std::vector<Vec3>> found(static_cast<std::size_t>(ranks));
    on_simulated_ranks(ranks, [&](Communicator& communicator) {
      const SharedWork work(1, {}, &communicator);
      work.together([&] { found[static_cast<std::size_t>(communicator.rank())] = build_rounds(work); });
    });
    for (const std::vector<Vec3>& values : found) CHECK(values == alone);
  }
}

TEST_CASE("building a size field stops when it is cancelled") {
  CancelToken cancel;
  cancel.cancel();
  const TaskRunner runner(2, {.progress = {}, .cancel = &cancel});
  const auto torus = test_models::make_torus(3, 1);
  CHECK_THROWS_AS(build_size_field(*torus, {.size = 0.1, .curvature = 24}, {}, runner), Error);
}

TEST_CASE("a size field is read fast") {
  const auto sphere = test_models::make_sphere({0, 0, 0}, 1);
  const SizeField field = build(*sphere, {.size = 0.5, .min_size = 0.01, .curvature = 360});
  RandomPoints random(sphere->bounding_box(), 9);
  std::vector<Vec3> points;
  for (int i = 0; i < 200000; ++i) points.push_back(random.point());
  const auto start = std::chrono::steady_clock::now();
  double sum = 0;
  for (const Vec3& x : points) sum += field.size_at(x);
  const std::chrono::duration<double, std::nano> elapsed = std::chrono::steady_clock::now() - start;
  std::cout << "size field of " << field.leaf_count() << " leaves, " << field.memory() / 1000000
            << " MB: " << elapsed.count() / static_cast<double>(points.size()) << " ns per query\n";
  CHECK(sum > 0);
}

}  // namespace tetloom
