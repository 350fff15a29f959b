#include "adapt/metric/background.hpp"
#include "tetloom/tasks.hpp"

#include <catch2/catch.hpp>

#include "tests/adapt/box_mesh.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/support/block_loops.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

Vec3 point_at(const BackgroundMesh& background, const BackgroundPlace& place) {
  const TetVerts& tet = background.mesh().tets[place.tet];
  Vec3 sum;
  for (std::size_t i = 0; i < 4; ++i) sum += place.weights[i] * background.mesh().points[tet[i]];
  return sum;
}

bool is_sound(const BackgroundPlace& place) {
  double sum = 0;
  for (const double w : place.weights) {
    if (!(w >= 0)) return false;
    sum += w;
  }
  return std::abs(sum - 1) < 1e-12;
}

BackgroundMesh background_of(const BoxMesh& mesh) { return {mesh.view(), {}, TaskRunner(1)}; }

/// The distance from x to the nearest of all boundary faces.
double brute_distance(const BoxMesh& mesh, const std::vector<FaceCode>& links, const Vec3& x) {
  double best = HUGE_VAL;
  for (const FaceCode face : tets::FaceRange(0, links.size() / 4)) {
    if (links[face.index()].valid()) continue;
    const TetVerts& tet = mesh.tets[face.tet()];
    const auto& f = kFaceVerts[face.side()];
    best = std::min(
        best, closest_on_triangle(x, mesh.points[tet[f[0]]], mesh.points[tet[f[1]]], mesh.points[tet[f[2]]]).distance2);
  }
  return std::sqrt(best);
}

/// A U: a box with a slot from above.
bool in_u(const Vec3& p) { return std::abs(p.x - 0.5) > 0.17 || p.y < 0.25; }

}  // namespace

TEST_CASE("tets are linked across their common faces", "[background]") {
  const BoxMesh mesh = make_box_mesh(4);
  const auto links = link_tets(mesh.view(), test::BackwardsLoop());
  std::size_t open = 0;
  for (const FaceCode face : tets::FaceRange(0, links.size() / 4)) {
    const FaceCode behind = links[face.index()];
    if (!behind.valid()) {
      ++open;
      continue;
    }
    REQUIRE(links[behind.index()] == face);
    std::array<std::uint32_t, 3> a, b;
    for (std::size_t i = 0; i < 3; ++i) {
      a[i] = mesh.tets[face.tet()][kFaceVerts[face.side()][i]];
      b[i] = mesh.tets[behind.tet()][kFaceVerts[behind.side()][i]];
    }
    std::sort(a.begin(), a.end()), std::sort(b.begin(), b.end());
    CHECK(a == b);
  }
  CHECK(open == 6 * 4 * 4 * 2);
  // Three tets at one face: two of them are linked.
  const std::vector<Vec3> points(6);
  const std::vector<TetVerts> fan{{0, 1, 2, 3}, {0, 1, 2, 4}, {0, 1, 2, 5}};
  CHECK(link_tets({points, fan})[3] == FaceCode(1, 3));
  CHECK_FALSE(link_tets({points, fan})[11].valid());
}

TEST_CASE("the closest point of a triangle is found for all kinds of places", "[background]") {
  const Vec3 a{0, 0, 0}, b{2, 0, 0}, c{0, 2, 0};
  const auto check = [&](const Vec3& x, std::array<double, 3> weights, double distance) {
    const TrianglePoint found = closest_on_triangle(x, a, b, c);
    for (std::size_t i = 0; i < 3; ++i) CHECK(found.weights[i] == Approx(weights[i]).margin(1e-15));
    CHECK(std::sqrt(found.distance2) == Approx(distance).margin(1e-15));
  };
  check({0.5, 0.5, 3}, {0.5, 0.25, 0.25}, 3);
  check({-1, -1, 0}, {1, 0, 0}, std::sqrt(2.0));
  check({5, 0, 4}, {0, 1, 0}, 5);
  check({1, -3, 4}, {0.5, 0.5, 0}, 5);
  check({2, 2, 0}, {0, 0.5, 0.5}, std::sqrt(2.0));
  const TrianglePoint flat = closest_on_triangle({1, 1, 0}, a, b, {1, 0, 0});
  CHECK(flat.distance2 == 1);
}

TEST_CASE("points inside a mesh are located from any hint", "[background]") {
  const unsigned seed = 21;
  CAPTURE(seed);
  RandomTensors random(seed);
  for (const double stretch : {1., 1e-4}) {
    CAPTURE(stretch);
    BoxMesh mesh = make_box_mesh(8, 0.2, 5);
    for (Vec3& p : mesh.points) p.z *= stretch;
    const BackgroundMesh background = background_of(mesh);
    for (int i = 0; i < 3000; ++i) {
      const Vec3 x{random.uniform(0, 1), random.uniform(0, 1), stretch * random.uniform(0, 1)};
      const auto hint = static_cast<BackgroundTet>(random.uniform(0, 1) * static_cast<double>(mesh.tets.size()));
      for (const BackgroundTet from : {kNoTet, hint}) {
        const BackgroundPlace place = background.locate(x, from);
        CHECK(is_sound(place));
        const Vec3 e = point_at(background, place) - x;
        CHECK(std::abs(e.x) + std::abs(e.y) + std::abs(e.z) / stretch < 1e-10);
      }
    }
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
      CHECK(distance(point_at(background, background.locate(mesh.points[v], 0)), mesh.points[v]) < 1e-12);
  }
}

TEST_CASE("points in a mesh that is not convex are located across its gaps", "[background]") {
  const unsigned seed = 22;
  CAPTURE(seed);
  RandomTensors random(seed);
  const BoxMesh mesh = make_box_mesh(12, 0, 1, in_u);
  const BackgroundMesh background = background_of(mesh);
  const auto links = link_tets(mesh.view());
  int inside = 0, outside = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 x{random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2), random.uniform(-0.2, 1.2)};
    const auto hint = static_cast<BackgroundTet>(random.uniform(0, 1) * static_cast<double>(mesh.tets.size()));
    const bool in_box = std::min({x.x, x.y, x.z}) >= 0 && std::max({x.x, x.y, x.z}) <= 1;
    const bool is_in = in_box && in_u({(std::floor(x.x * 12) + 0.5) / 12, (std::floor(x.y * 12) + 0.5) / 12, 0});
    const BackgroundPlace place = background.locate(x, i % 3 == 0 ? kNoTet : hint);
    CHECK(is_sound(place));
    const double off = distance(point_at(background, place), x);
    CAPTURE(x.x, x.y, x.z, is_in);
    const double expected = is_in ? 0 : brute_distance(mesh, links, x);
    CHECK(off == Approx(expected).margin(1e-12));
    ++(is_in ? inside : outside);
  }
  CHECK(inside > 300);
  CHECK(outside > 300);
}

TEST_CASE("points in meshes of several pieces, and far away, have a place", "[background]") {
  // Two single tets.
  const BoxMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {5, 0, 0}, {6, 0, 0}, {5, 1, 0}, {5, 0, 1}},
                     {{0, 1, 2, 3}, {4, 5, 6, 7}}};
  const BackgroundMesh background = background_of(mesh);
  CHECK(background.locate({5.1, 0.1, 0.1}, 0).tet == 1);
  CHECK(background.locate({0.1, 0.1, 0.1}, 1).tet == 0);
  CHECK(distance(point_at(background, background.locate({1e9, 0, 0}, 0)), {6, 0, 0}) < 1e-12);
  for (const double far : {1e160, -1e300, 1e-300}) {
    const BackgroundPlace place = background.locate({far, far, -far});
    CHECK(place.tet < 2);
    CHECK(is_sound(place));
  }
}

TEST_CASE("linear fields are interpolated exactly and metrics by their logarithms", "[background]") {
  const unsigned seed = 23;
  CAPTURE(seed);
  RandomTensors random(seed);
  const BoxMesh mesh = make_box_mesh(7, 0.2);
  const Tensor l0 = random.tensor(), lx = random.tensor(), ly = random.tensor(), lz = random.tensor();
  const auto log_at = [&](const Vec3& p) { return l0 + p.x * lx + p.y * ly + p.z * lz; };
  const auto linear = [](const Vec3& p) { return 3 + 2 * p.x - p.y + 0.5 * p.z; };
  MetricField metric;
  MeshField field{"u", 2, {}};
  for (const Vec3& p : mesh.points) {
    metric.logs.push_back(log_at(p));
    field.values.push_back(linear(p));
    field.values.push_back(-linear(p));
  }
  const BackgroundMesh background(mesh.view(), metric, TaskRunner(2));
  std::vector<Vec3> points;
  for (int i = 0; i < 10000; ++i) points.push_back(0.5 * (random.vector() + Vec3{1, 1, 1}));
  const auto places = background.locate(points);
  double error = 0, metric_error = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    error = std::max(error, std::abs(background.value_at(field, 0, places[i]) - linear(points[i])));
    error = std::max(error, std::abs(background.value_at(field, 1, places[i]) + linear(points[i])));
    metric_error = std::max(metric_error, largest_entry(background.log_metric_at(places[i]) - log_at(points[i])));
  }
  CHECK(error < 1e-13);
  CHECK(metric_error < 1e-13);

  const auto other = background.locate(points, test::ThreadsLoop(3));
  const bool same = std::equal(places.begin(), places.end(), other.begin(),
                               [](const auto& a, const auto& b) { return a.tet == b.tet && a.weights == b.weights; });
  CHECK(same);
}
