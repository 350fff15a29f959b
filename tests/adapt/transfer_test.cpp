// Values on tets, from one mesh to another.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "adapt/transfer/cell_transfer.hpp"
#include "adapt/transfer/overlaps.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

constexpr TetVerts kFirst{0, 1, 2, 3}, kSecond{4, 5, 6, 7};

ClippedTet clip(const Corners& tet, const Corners& by) {
  std::vector<Vec3> points(by.begin(), by.end());
  FaceValues values;
  for (std::size_t face = 0; face < 4; ++face) values[face] = face_values(points, kFirst, face, tet);
  return clip_tet(values);
}

Corners unit_tet(double scale = 1, const Vec3& at = {}) {
  return {at, at + Vec3{scale, 0, 0}, at + Vec3{0, scale, 0}, at + Vec3{0, 0, scale}};
}

Corners random_tet(RandomTensors& random) {
  for (;;) {
    Corners x{random.vector(), random.vector(), random.vector(), random.vector()};
    if (volume_of(x) < 0) std::swap(x[0], x[1]);
    if (volume_of(x) > 0.01) return x;
  }
}

/// The unit cube in n³ cubes with points inside shaken, and what `map` makes of it.
template <class Map>
Mesh mapped_cube(int n, unsigned seed, const Map& map, bool two_regions = false) {
  test::BoxSpec spec{n, n, n, two_regions, seed, 0.15};
  spec.h = 1.0 / n;
  Mesh mesh = test::make_tet_box(spec);
  for (Vec3& x : mesh.points) x = map(x);
  return mesh;
}

Mesh cube(int n, unsigned seed, bool two_regions = false) {
  return mapped_cube(
      n, seed, [](const Vec3& x) { return x; }, two_regions);
}

/// Thinner by `aspect` in one direction, then turned so that no axis is special.
auto thin_and_turned(double aspect) {
  const auto basis = RandomTensors(7).basis();
  return [=](const Vec3& x) { return x.x * basis[0] + x.y * basis[1] + x.z / aspect * basis[2]; };
}

struct Transfer {
  Transfer(const Mesh& from_mesh, const Mesh& to_mesh, int threads = 1)
      : from(from_mesh), to(to_mesh), runner(threads), background(tets_of(from), {}, runner) {}

  std::vector<double> operator()(const std::vector<double>& values, adapt::CellReconstruction shape,
                                 std::size_t components = 1) const {
    return put_right(values, means(values, shape, components, 0, to.tet_to_vert.size()), components);
  }

  // Of some of the new tets, before integrals are put right.
  std::vector<double> means(const std::vector<double>& values, adapt::CellReconstruction shape, std::size_t components,
                            std::size_t begin, std::size_t end) const {
    const CellValues cells{values, components};
    const std::size_t count = from.tet_to_vert.size();
    std::vector<Vec3> slopes;
    if (shape == adapt::CellReconstruction::Linear)
      slopes = limited_slopes({tets_of(from), background.links(), from.tet_to_entity, 0, count}, cells, runner);
    const OldTets old(background, from.tet_to_entity, cells, slopes);
    const SumsByRegion before = sum_cells({tets_of(from), from.tet_to_entity}, cells, runner);
    const TetsInRegions tets{{to.points, std::span(to.tet_to_vert).subspan(begin, end - begin)},
                             std::span(to.tet_to_entity).subspan(begin, end - begin)};
    const auto places = background.locate(to.points, runner);
    std::vector<double> made((end - begin) * components);
    const auto no_tile = [](std::size_t) { return 0u; };
    look_up_all(nullptr, end - begin, 100, runner, no_tile, [&] {
      return [&, averager = CellAverager(old, before, tets, places, runner)](std::size_t tet) mutable {
        averager.put_means(tet, &made[tet * components]);
      };
    });
    return made;
  }

  std::vector<double> put_right(const std::vector<double>& values, std::vector<double> made,
                                std::size_t components) const {
    const SumsByRegion before = sum_cells({tets_of(from), from.tet_to_entity}, {values, components}, runner);
    const SumsByRegion after = sum_cells({tets_of(to), to.tet_to_entity}, {made, components}, runner);
    put_right_cells(before, after, to.tet_to_entity, made, runner);
    return made;
  }

  const Mesh &from, &to;
  TaskRunner runner;
  BackgroundMesh background;
};

/// The values of `field` in the centres.
template <class Field>
std::vector<double> sampled(const Mesh& mesh, const Field& field) {
  std::vector<double> values;
  for (std::uint32_t tet = 0; tet < mesh.tet_to_vert.size(); ++tet)
    values.push_back(field(center_of(corners_of(tets_of(mesh), tet))));
  return values;
}

double integral(const Mesh& mesh, const std::vector<double>& values, std::uint32_t region = kNone) {
  double sum = 0;
  for (std::uint32_t tet = 0; tet < values.size(); ++tet)
    if (region == kNone || mesh.tet_to_entity[tet] == region)
      sum += values[tet] * volume_of(corners_of(tets_of(mesh), tet));
  return sum;
}

double largest(const std::vector<double>& values) { return *std::max_element(values.begin(), values.end()); }
double smallest(const std::vector<double>& values) { return *std::min_element(values.begin(), values.end()); }

}  // namespace

TEST_CASE("a tet is clipped by another one", "[transfer]") {
  SECTION("by itself") {
    const ClippedTet same = clip(unit_tet(), unit_tet());
    CHECK(same.share == Approx(1).epsilon(1e-15));
    for (const double m : same.moment) CHECK(m == Approx(0.25).epsilon(1e-15));
    for (const bool crossed : same.crossed) CHECK_FALSE(crossed);
  }
  SECTION("by a larger one that holds it") {
    const ClippedTet inside = clip(unit_tet(0.1, {0.2, 0.2, 0.2}), unit_tet());
    CHECK(inside.share == Approx(1).epsilon(1e-15));
    for (const bool crossed : inside.crossed) CHECK_FALSE(crossed);
  }
  SECTION("by a smaller one inside") {
    const ClippedTet whole = clip(unit_tet(), unit_tet(0.5, {0.1, 0.1, 0.1}));
    CHECK(whole.share == Approx(0.125).epsilon(1e-14));
    CHECK(whole.moment[1] == Approx(0.125 * (0.1 + 0.125)).epsilon(1e-14));
    for (const bool crossed : whole.crossed) CHECK(crossed);
  }
  SECTION("by its half") {
    Corners half = unit_tet();
    half[3] = {0, 0, 0.5};
    const ClippedTet clipped = clip(unit_tet(), half);
    CHECK(clipped.share == Approx(0.5).epsilon(1e-15));
    CHECK((clipped.crossed[0] && !clipped.crossed[1] && !clipped.crossed[2] && !clipped.crossed[3]));
  }
  SECTION("by one beside it, with a face, an edge or a corner in common") {
    const auto [a, b, c, d] = unit_tet();
    CHECK(clip(unit_tet(), {a, c, b, Vec3{0.2, 0.2, -1}}).share == 0);
    CHECK(clip(unit_tet(), {a, b, Vec3{0, -1, 0}, Vec3{0, 0, -1}}).share == 0);
    CHECK(clip(unit_tet(), {a, Vec3{-1, 0, 0}, Vec3{0, 0, -1}, Vec3{0, -1, 0}}).share == 0);
    CHECK(clip(unit_tet(), unit_tet(1, {5, 5, 5})).share == 0);
  }
}

TEST_CASE("two tets have the same in common, whichever is clipped", "[transfer]") {
  RandomTensors random(3);
  const double aspect = GENERATE(1.0, 1e4);
  const auto squeeze = thin_and_turned(aspect);
  std::size_t common = 0;
  for (int i = 0; i < 5000; ++i) {
    Corners a = random_tet(random), b = random_tet(random);
    if (i % 3 == 0) b[0] = a[1];  // points in common, and faces
    if (i % 6 == 0) b[1] = a[2], b[2] = a[3];
    for (Corners* x : {&a, &b})
      for (Vec3& p : *x) p = squeeze(p);
    if (volume_of(b) < 0) std::swap(b[0], b[1]);
    if (volume_of(b) < 0.001 / aspect) continue;
    const ClippedTet of_a = clip(a, b), of_b = clip(b, a);
    CAPTURE(i);
    CHECK(of_a.share * volume_of(a) == Approx(of_b.share * volume_of(b)).epsilon(1e-9).margin(1e-11 / aspect));
    Vec3 center_of_a, center_of_b;
    for (std::size_t k = 0; k < 4; ++k)
      center_of_a += volume_of(a) * of_a.moment[k] * a[k], center_of_b += volume_of(b) * of_b.moment[k] * b[k];
    CHECK(distance(center_of_a, center_of_b) < 1e-10 / aspect);
    CHECK((of_a.share > -1e-14 && of_a.share < 1 + 1e-14));
    common += of_a.share > 0.01;
  }
  CHECK(common > 500);
}

TEST_CASE("overlaps fill every new tet and every old one", "[transfer]") {
  const double aspect = GENERATE(1.0, 1e2, 1e4);
  CAPTURE(aspect);
  const auto squeeze = thin_and_turned(aspect);
  // The second one is thin in another direction, so that its tets go across many of the first.
  const auto swapped = [&](const Vec3& x) { return squeeze({x.z, x.x, x.y}); };
  const auto [n, m] = GENERATE(std::pair(5, 7), std::pair(7, 4), std::pair(4, 4));
  const Mesh from = mapped_cube(n, 1, squeeze), to = mapped_cube(m, n == m ? 1 : 2, swapped);
  const BackgroundMesh background(tets_of(from), {}, TaskRunner(1));
  const std::vector<double> zeros(from.tet_to_vert.size(), 0);
  const OldTets old(background, from.tet_to_entity, {zeros, 1});
  OverlapFinder finder(old);
  std::vector<double> filled(from.tet_to_vert.size(), 0);
  for (std::uint32_t tet = 0; tet < to.tet_to_vert.size(); ++tet) {
    const auto overlaps = finder.find(tets_of(to), to.tet_to_vert[tet], 0, {kNoTet, kNoTet, kNoTet, kNoTet});
    CHECK(finder.covered() == Approx(1).epsilon(1e-9));
    std::array<double, 4> moments{};
    for (const Overlap& overlap : overlaps) {
      filled[overlap.tet] += overlap.share * volume_of(corners_of(tets_of(to), tet));
      for (std::size_t i = 0; i < 4; ++i) moments[i] += overlap.moment[i];
    }
    for (const double moment : moments) CHECK(moment == Approx(0.25).epsilon(1e-9));
  }
  for (std::uint32_t tet = 0; tet < filled.size(); ++tet)
    CHECK(filled[tet] == Approx(volume_of(corners_of(tets_of(from), tet))).epsilon(1e-7));
}

TEST_CASE("overlaps are those of all pairs", "[transfer]") {
  const Mesh from = cube(4, 1, true), to = cube(6, 2, true);
  const BackgroundMesh background(tets_of(from), {}, TaskRunner(1));
  const std::vector<double> zeros(from.tet_to_vert.size(), 0);
  const OldTets old(background, from.tet_to_entity, {zeros, 1});
  OverlapFinder finder(old);
  for (std::uint32_t tet = 0; tet < to.tet_to_vert.size(); tet += 7) {
    const std::uint32_t region = to.tet_to_entity[tet];
    std::vector<BackgroundTet> found, all;
    for (const Overlap& overlap :
         finder.find(tets_of(to), to.tet_to_vert[tet], region, {kNoTet, kNoTet, kNoTet, kNoTet}))
      if (overlap.share > 1e-12) found.push_back(overlap.tet);
    for (std::uint32_t other = 0; other < from.tet_to_vert.size(); ++other) {
      if (from.tet_to_entity[other] != region) continue;
      const double share = clip(corners_of(tets_of(to), tet), corners_of(tets_of(from), other)).share;
      if (share > 1e-12) all.push_back(other);
    }
    std::sort(found.begin(), found.end());
    CHECK(found == all);
  }
}

TEST_CASE("a tet outside of its region as it was has the value of the nearest tet", "[transfer]") {
  const Mesh from = cube(2, 0, true);
  // All of it in the other half of the cube, and outside of it.
  for (const double x : {0.75, 1.5}) {
    const std::vector<Vec3> points{{x, 0.4, 0.4}, {x + 0.1, 0.4, 0.4}, {x, 0.5, 0.4}, {x, 0.4, 0.5}};
    const std::vector<TetVerts> tets{kFirst};
    const BackgroundMesh background(tets_of(from), {}, TaskRunner(1));
    const std::vector<double> zeros(from.tet_to_vert.size(), 0);
    const OldTets old(background, from.tet_to_entity, {zeros, 1});
    OverlapFinder finder(old);
    CHECK(finder.find({points, tets}, kFirst, 0, {kNoTet, kNoTet, kNoTet, kNoTet}).empty());
    const BackgroundTet nearest = finder.nearest(0);
    REQUIRE(nearest != kNoTet);
    CHECK(from.tet_to_entity[nearest] == 0);
    CHECK(finder.nearest(7) == kNoTet);
  }
}

TEST_CASE("constants stay, and linear fields away from the surface", "[transfer]") {
  const double aspect = GENERATE(1.0, 1e4);
  const auto squeeze = thin_and_turned(aspect);
  const Mesh from = mapped_cube(9, 1, squeeze), to = mapped_cube(12, 2, squeeze);
  const Transfer transfer(from, to);
  const auto shape = GENERATE(adapt::CellReconstruction::Constant, adapt::CellReconstruction::Linear);
  for (const double value : transfer(std::vector<double>(from.tet_to_vert.size(), 3.7), shape))
    CHECK(value == Approx(3.7).epsilon(1e-13));

  const auto basis = RandomTensors(7).basis();
  const auto linear = [&](const Vec3& x) {
    return 1 + dot(x, basis[0]) - 2 * dot(x, basis[1]) + 3 * aspect * dot(x, basis[2]);
  };
  const std::vector<double> values = transfer(sampled(from, linear), adapt::CellReconstruction::Linear),
                            exact = sampled(to, linear);
  std::size_t inside = 0;
  double worst = 0;
  for (std::uint32_t tet = 0; tet < values.size(); ++tet) {
    const Vec3 x = center_of(corners_of(tets_of(to), tet));
    const Vec3 at{dot(x, basis[0]), dot(x, basis[1]), aspect * dot(x, basis[2])};
    if (std::min({at.x, at.y, at.z}) < 0.25 || std::max({at.x, at.y, at.z}) > 0.75) continue;
    ++inside;
    worst = std::max(worst, std::abs(values[tet] - exact[tet]));
  }
  CHECK(inside > 500);
  CHECK(worst < 1e-9);
}

TEST_CASE("regions do not mix, and each keeps its integral", "[transfer]") {
  const auto [n, m] = GENERATE(std::pair(6, 10), std::pair(10, 4));
  const Mesh from = cube(n, 1, true), to = cube(m, 2, true);
  const auto shape = GENERATE(adapt::CellReconstruction::Constant, adapt::CellReconstruction::Linear);
  std::vector<double> values = sampled(from, [](const Vec3& x) { return std::sin(5 * x.x + x.y * x.z); });
  std::vector<double> pairs;
  for (std::size_t tet = 0; tet < values.size(); ++tet) {
    if (from.tet_to_entity[tet] == 1) values[tet] += 1000;
    pairs.insert(pairs.end(), {values[tet], from.tet_to_entity[tet] == 1 ? -8.0 : 2.0});
  }
  const std::vector<double> result = Transfer(from, to)(pairs, shape, 2);
  std::vector<double> now;
  for (std::size_t tet = 0; tet < to.tet_to_vert.size(); ++tet) {
    const bool second = to.tet_to_entity[tet] == 1;
    now.push_back(result[2 * tet]);
    CHECK(result[2 * tet + 1] == Approx(second ? -8 : 2).epsilon(1e-13));
    CHECK(std::abs(result[2 * tet] - (second ? 1000 : 0)) <= 1 + 1e-9);
  }
  for (const std::uint32_t region : {0u, 1u})
    CHECK(integral(to, now, region) == Approx(integral(from, values, region)).epsilon(1e-13).margin(1e-14));
}

TEST_CASE("a jump stays within its bounds", "[transfer]") {
  const double aspect = GENERATE(1.0, 1e4);
  const auto squeeze = thin_and_turned(aspect);
  const Mesh from = mapped_cube(7, 1, squeeze), to = mapped_cube(9, 2, squeeze);
  const auto basis = RandomTensors(7).basis();
  const auto jump = [&](const Vec3& x) { return dot(x, basis[0]) + aspect * dot(x, basis[2]) > 0.8 ? 5.0 : -2.0; };
  const auto shape = GENERATE(adapt::CellReconstruction::Constant, adapt::CellReconstruction::Linear);
  const std::vector<double> before = sampled(from, jump), after = Transfer(from, to)(before, shape);
  CHECK(largest(after) <= 5 + 1e-12);
  CHECK(smallest(after) >= -2 - 1e-12);
  CHECK(largest(after) > 4.99);
  CHECK(smallest(after) < -1.99);
  CHECK(integral(to, after) == Approx(integral(from, before)).epsilon(1e-13));
}

TEST_CASE("linear functions in tets carry a smooth field further", "[transfer]") {
  const auto wave = [](const Vec3& x) { return std::sin(4 * x.x) * std::cos(3 * x.y) + x.z * x.z; };
  const auto error = [&](int n, adapt::CellReconstruction shape) {
    const Mesh from = cube(n, 1), to = cube(n + 1, 2);
    const std::vector<double> values = Transfer(from, to)(sampled(from, wave), shape), exact = sampled(to, wave);
    std::vector<double> off;
    for (std::size_t i = 0; i < values.size(); ++i) off.push_back(std::abs(values[i] - exact[i]));
    return integral(to, off);
  };
  CHECK(error(8, adapt::CellReconstruction::Linear) < 0.5 * error(8, adapt::CellReconstruction::Constant));
  CHECK(error(8, adapt::CellReconstruction::Linear) > 3.4 * error(16, adapt::CellReconstruction::Linear));
}

TEST_CASE("what a region loses or gains where it has changed is made up for", "[transfer]") {
  // The second cube bulges out on one side and in on another.
  const auto bulge = [](const Vec3& x) {
    const double at = 16 * x.x * (1 - x.x) * x.y * (1 - x.y);
    return Vec3{x.x, x.y, x.z + 0.1 * at * x.z - 0.06 * at * (1 - x.z)};
  };
  const Mesh from = cube(6, 1), to = mapped_cube(8, 2, bulge);
  const auto shape = GENERATE(adapt::CellReconstruction::Constant, adapt::CellReconstruction::Linear);
  const Transfer transfer(from, to);
  SECTION("by a factor where the sign is the same everywhere, and zeros stay") {
    const std::vector<double> before = sampled(from, [](const Vec3& x) { return x.x < 0.3 ? 0.0 : 1 + x.y; });
    const std::vector<double> after = transfer(before, shape);
    CHECK(integral(to, after) == Approx(integral(from, before)).epsilon(1e-13));
    CHECK(smallest(after) == 0);
    CHECK(largest(after) < 1.03 * largest(before));
  }
  SECTION("by a shift where it is not") {
    const std::vector<double> before = sampled(from, [](const Vec3& x) { return x.x - 0.5 + 0.01 * x.y; });
    const std::vector<double> after = transfer(before, shape);
    CHECK(std::abs(integral(to, after) - integral(from, before)) < 1e-15);
    CHECK(largest(after) < 0.55);
  }
  SECTION("of nothing at all") {
    for (const double value : transfer(std::vector<double>(from.tet_to_vert.size(), 0), shape)) CHECK(value == 0);
  }
}

TEST_CASE("transferred values do not depend on threads", "[transfer]") {
  const Mesh from = cube(8, 1, true), to = cube(11 + 1, 2, true);
  const std::vector<double> values = sampled(from, [](const Vec3& x) { return std::exp(x.x) * x.y - x.z; });
  CHECK(Transfer(from, to, 1)(values, adapt::CellReconstruction::Linear) ==
        Transfer(from, to, 4)(values, adapt::CellReconstruction::Linear));
}

TEST_CASE("means of any tets, put together and put right, are what all tets have at once", "[transfer]") {
  const Mesh from = cube(5, 1), to = cube(7, 2);
  const Transfer transfer(from, to);
  const std::vector<double> values = sampled(from, [](const Vec3& x) { return 1 + x.x * x.y - x.z; });
  const std::size_t half = to.tet_to_vert.size() / 2;
  const auto shape = adapt::CellReconstruction::Linear;
  std::vector<double> carried = transfer.means(values, shape, 1, 0, half);
  const std::vector<double> rest = transfer.means(values, shape, 1, half, to.tet_to_vert.size());
  carried.insert(carried.end(), rest.begin(), rest.end());
  CHECK(transfer.put_right(values, carried, 1) == transfer(values, shape));
}

TEST_CASE("a transfer can be cancelled", "[transfer]") {
  const Mesh from = cube(6, 1), to = cube(8, 2);
  const Transfer transfer(from, to);
  const auto places = transfer.background.locate(to.points);
  const std::vector<double> values(from.tet_to_vert.size(), 1);
  const OldTets old(transfer.background, from.tet_to_entity, {values, 1});
  const SumsByRegion before = sum_cells({tets_of(from), from.tet_to_entity}, {values, 1}, transfer.runner);
  CancelToken stop;
  stop.cancel();
  const TaskRunner runner(1, {nullptr, &stop});
  CellAverager averager(old, before, {tets_of(to), to.tet_to_entity}, places, runner);
  const auto average_all = [&] {
    double mean = 0;
    for (std::size_t tet = 0; tet < to.tet_to_vert.size(); ++tet) averager.put_means(tet, &mean);
  };
  CHECK_THROWS_AS(average_all(), Error);
}
