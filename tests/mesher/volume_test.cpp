// Filling of volumes through the worker: shapes, sizes, bad surfaces, independence of the threads.
#include <algorithm>
#include <chrono>
#include <ctime>
#include <numbers>
#include <thread>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/filled_surface.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

struct Statistics {
  double mean_length = 0, in_band = 0, median_quality = 0, lowest_quality = 0;
};

Statistics measure(const Surface& surface, const VolumeMesh& mesh, double size) {
  const auto points = all_points(surface, mesh);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  std::vector<double> qualities;
  for (const auto& t : mesh.tet_to_vert) {
    double squares = 0;
    for (int i = 0; i < 4; ++i) {
      for (int j = i + 1; j < 4; ++j) {
        edges.insert(std::minmax(t[i], t[j]));
        squares += norm2(points[t[i]] - points[t[j]]);
      }
    }
    qualities.push_back(12 * std::pow(3 * volume_of(points, t), 2.0 / 3) / squares);
  }
  std::sort(qualities.begin(), qualities.end());
  Statistics result{0, 0, qualities[qualities.size() / 2], qualities[0]};
  for (const auto& [a, b] : edges) {
    const double length = distance(points[a], points[b]) / size;
    result.mean_length += length / double(edges.size());
    result.in_band += (length > std::numbers::sqrt2 / 2 && length < std::numbers::sqrt2) / double(edges.size());
  }
  return result;
}

}  // namespace

TEST_CASE("a cube is filled to the size asked for") {
  const Surface cube = cube_surface(12);
  const VolumeMesh mesh = fill(cube, 1.0 / 12);
  CHECK(mesh.errors.empty());
  CHECK(mesh.warnings.empty());
  const auto volumes = check_filling(cube, mesh);
  REQUIRE(volumes.size() == 1);
  CHECK(volumes.at(0) == Approx(1).epsilon(1e-12));
  const Statistics statistics = measure(cube, mesh, 1.0 / 12);
  CHECK(statistics.mean_length == Approx(1.05).margin(0.07));  // the surface's own diagonals are sqrt(2) h
  CHECK(statistics.in_band > 0.9);
  CHECK(statistics.median_quality > 0.88);
  CHECK(statistics.lowest_quality > 0.2);
}

TEST_CASE("what cannot fit in memory is refused before any work, with the numbers") {
  const Surface cube = cube_surface(4);
  const SizeField sizes = SizeField::uniform(1e-4);
  const MeshEstimate estimate = estimate_filling(cube.input(sizes));
  CHECK(estimate.tets == Approx(9.3e12).epsilon(0.01));
  VolumeOptions options{TETLOOM_WORKER};
  options.max_memory = 1'000'000'000;
  try {
    fill_volume(cube.input(sizes), options, TaskRunner(1));
    FAIL("it was not refused");
  } catch (const Error& error) {
    CHECK(error.code() == ErrorCode::OutOfMemory);
    CHECK(std::string(error.what()).find("1 GB") != std::string::npos);
  }
}

TEST_CASE("without a worker everything but its last resort works") {
  const Surface ball = ball_surface(3, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
  const SizeField sizes = SizeField::uniform(0.2);
  const VolumeMesh mesh = fill_volume(ball.input(sizes), {}, TaskRunner(1));
  CHECK(mesh.errors.empty());
  CHECK(mesh.figures.worker_complexes == 0);
  CHECK(mesh.figures.shell_tets > 0);
  check_filling(ball, mesh);
}

TEST_CASE("scaling a surface by powers of two changes nothing but the coordinates") {
  const Surface ball = ball_surface(4, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
  const SizeField sizes = SizeField::uniform(0.1);
  const VolumeMesh mesh = fill_volume(ball.input(sizes), {}, TaskRunner(1));
  for (const double scale : {0x1p-20, 0x1p20}) {
    Surface scaled = ball;
    for (Vec3& x : scaled.points) x = scale * x;
    const SizeField other = SizeField::uniform(0.1 * scale);
    const VolumeMesh again = fill_volume(scaled.input(other), {}, TaskRunner(2));
    CHECK((again.tet_to_vert == mesh.tet_to_vert));
    REQUIRE(again.new_points.size() == mesh.new_points.size());
    for (std::size_t i = 0; i < mesh.new_points.size(); ++i) REQUIRE(again.new_points[i] == scale * mesh.new_points[i]);
  }
}

TEST_CASE("a coarse cube without room for interior points is filled") {
  const Surface cube = cube_surface(1);
  const VolumeMesh mesh = fill(cube, 1);
  CHECK(check_filling(cube, mesh).at(0) == Approx(1));
}

TEST_CASE("an L, a ring and a spherical ball are filled") {
  const Surface l = voxel_surface({2, 2, 1}, 4, [](int i, int j, int) { return i == 1 && j == 1 ? kOutside : 0u; });
  CHECK(check_filling(l, fill(l, 0.25)).at(0) == Approx(3));
  const Surface ring = voxel_surface({3, 3, 1}, 3, [](int i, int j, int) { return i == 1 && j == 1 ? kOutside : 0u; });
  CHECK(check_filling(ring, fill(ring, 0.33)).at(0) == Approx(8));
  const Surface ball = ball_surface(4, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
  const VolumeMesh filled = fill(ball, 0.1);
  CHECK(check_filling(ball, filled).at(0) == Approx(4 * std::numbers::pi / 3).epsilon(0.01));
  CHECK(filled.new_points.size() > 1000);
}

TEST_CASE("regions that share faces are filled together and stay apart") {
  const Surface pair = voxel_surface({3, 1, 1}, 4, [](int i, int, int) { return i == 0 ? 4u : 2u; });
  const VolumeMesh mesh = fill(pair, 0.25);
  CHECK(mesh.errors.empty());
  const auto volumes = check_filling(pair, mesh);
  REQUIRE(volumes.size() == 2);
  CHECK(volumes.at(4) == Approx(1));
  CHECK(volumes.at(2) == Approx(2));
}

TEST_CASE("a void stays empty, a region inside another is filled") {
  const auto hollow = [](std::uint32_t core) {
    return [core](int i, int j, int k) { return i == 1 && j == 1 && k == 1 ? core : 0u; };
  };
  const Surface with_void = voxel_surface({3, 3, 3}, 2, hollow(kOutside));
  const auto empty_core = check_filling(with_void, fill(with_void, 0.5));
  REQUIRE(empty_core.size() == 1);
  CHECK(empty_core.at(0) == Approx(26));
  const Surface nested = voxel_surface({3, 3, 3}, 2, hollow(1));
  const auto full_core = check_filling(nested, fill(nested, 0.5));
  REQUIRE(full_core.size() == 2);
  CHECK(full_core.at(1) == Approx(1));
}

TEST_CASE("regions that touch without sharing triangles are independent") {
  // Two cubes with a common square whose points exist twice, and a ball that penetrates both: nothing of one complex
  // may disturb another.
  Surface surface = cube_surface(3);
  Surface shifted = voxel_surface({1, 1, 1}, 4, [](int, int, int) { return 1u; });
  for (Vec3& p : shifted.points) p.x += 1;
  surface.append(shifted);
  surface.append(ball_surface(2, {1, 0.5, 0.5}, 2, [](const Vec3&) { return 0.4; }));
  const VolumeMesh mesh = fill(surface, 0.3);
  CHECK(mesh.errors.empty());
  const auto volumes = check_filling(surface, mesh);
  REQUIRE(volumes.size() == 3);
  CHECK(volumes.at(0) == Approx(1));
  CHECK(volumes.at(1) == Approx(1));
}

TEST_CASE("a sheet inside a region is kept, a sheet outside of all is ignored") {
  Surface surface = cube_surface(4);
  const auto offset = static_cast<std::uint32_t>(surface.points.size());
  for (const double y : {0.3, 0.7}) {
    for (const double x : {0.3, 0.7}) surface.points.push_back({x, y, 0.5});
  }
  surface.add({offset, offset + 1, offset + 3}, 0, 0, 7);
  surface.add({offset, offset + 3, offset + 2}, 0, 0, 7);
  const VolumeMesh mesh = fill(surface, 0.25);
  CHECK(mesh.errors.empty());
  CHECK(check_filling(surface, mesh).at(0) == Approx(1));
  surface.tri_to_sides[surface.tri_to_sides.size() - 2] = surface.tri_to_sides.back() = {};
  CHECK(fill(surface, 0.25).errors.empty());
}

TEST_CASE("a size field coarser than the surface is followed inside") {
  const Surface cube = cube_surface(20);
  const SizeField sizes = SizeField::uniform(0.2);  // four times the surface's own edges
  const VolumeMesh mesh = fill_volume(cube.input(sizes), {TETLOOM_WORKER}, TaskRunner(2));
  CHECK(mesh.errors.empty());
  check_filling(cube, mesh);
  CHECK(mesh.new_points.size() < 2500);  // of 9000 at the size of the surface: quality needs a transition
  CHECK(mesh.new_points.size() > 30);
}

TEST_CASE("the mesh does not depend on the number of threads") {
  Surface surface = cube_surface(5);
  for (std::uint32_t i = 1; i < 6; ++i) {
    surface.append(ball_surface(3, {3.0 * i, 0, 0}, i, [&](const Vec3& d) { return 1 + 0.1 * i * d.x * d.y; }));
  }
  const VolumeMesh one = fill(surface, 0.2, 1), many = fill(surface, 0.2, 4);
  CHECK(one.new_points == many.new_points);
  CHECK(one.tet_to_vert == many.tet_to_vert);
  CHECK(one.tet_to_region == many.tet_to_region);
  CHECK(check_filling(surface, one).size() == 6);
}

TEST_CASE("200 random star-shaped bodies are filled") {
  const unsigned seed = 4711;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  for (int body = 0; body < 200; ++body) {
    CAPTURE(body);
    std::uniform_real_distribution<double> radius(body % 2 == 0 ? 0.8 : 0.3, 1);
    const int levels = 1 + body % 3;
    const Surface surface = ball_surface(levels, {10.0 * body, 0, 1e3}, 0, [&](const Vec3&) { return radius(engine); });
    const VolumeMesh mesh = fill(surface, 0.5);
    for (const auto& error : mesh.errors) UNSCOPED_INFO(error.message);
    REQUIRE(mesh.errors.empty());
    double expected = 0;
    for (const auto& [a, b, c] : surface.tri_to_vert) {
      const Vec3 o{10.0 * body, 0, 1e3};
      expected += dot(surface.points[a] - o, cross(surface.points[b] - o, surface.points[c] - o)) / 6;
    }
    CHECK(check_filling(surface, mesh).at(0) == Approx(expected).epsilon(1e-9));
  }
}

TEST_CASE("what TetGen fills is finished as everything else: optimised, and with a surface that may change") {
  const Surface cube = cube_surface(6);
  const SizeField sizes = SizeField::uniform(1.0 / 6);
  VolumeOptions options{TETLOOM_WORKER, true};
  const VolumeMesh mesh = fill_volume(cube.input(sizes), options, TaskRunner(1));
  REQUIRE(mesh.errors.empty());
  CHECK(mesh.figures.worker_complexes == 1);
  CHECK(mesh.figures.core_tets + mesh.figures.shell_tets == 0);
  CHECK(mesh.figures.optimizer.tets == mesh.tet_to_vert.size());
  CHECK(mesh.figures.optimizer.vertices_moved > 0);
  CHECK(mesh.moved_points.empty());
  CHECK(check_filling(cube, mesh).at(0) == Approx(1));
  CHECK(measure(cube, mesh, 1.0 / 6).lowest_quality == Approx(mesh.figures.optimizer.least).epsilon(1e-3));

  Surface needles = cube;  // edges inside of a face that a swap betters: long diagonals
  for (Vec3& x : needles.points) x.x *= 4;
  const VolumeMesh kept = fill_volume(needles.input(sizes), options, TaskRunner(1));
  options.improve_surface = true;
  const VolumeMesh improved = fill_volume(needles.input(sizes), options, TaskRunner(1));
  REQUIRE(improved.errors.empty());
  CHECK(kept.changed_triangles.empty());
  CHECK(improved.changed_triangles.size() > 0);
  CHECK(improved.figures.optimizer.edges_swapped > 0);
  Surface changed = needles;
  for (const ChangedTriangle& one : improved.changed_triangles) changed.tri_to_vert[one.triangle] = one.verts;
  CHECK(check_filling(changed, improved).at(0) == Approx(4));
}

TEST_CASE("TetGen's tets are told apart by region, and those in voids are dropped") {
  const SizeField sizes = SizeField::uniform(0.5);
  for (const std::uint32_t core : {1u, kOutside}) {
    CAPTURE(core);
    const Surface surface = voxel_surface({3, 3, 3}, 2, [core](int i, int j, int k) {
      return i == 1 && j == 1 && k == 1 ? core : i == 0 ? 2u : 0u;
    });
    const VolumeMesh mesh = fill_volume(surface.input(sizes), {TETLOOM_WORKER, true}, TaskRunner(1));
    REQUIRE(mesh.errors.empty());
    const auto volumes = check_filling(surface, mesh);
    CHECK(volumes.size() == (core == kOutside ? 2 : 3));
    CHECK(volumes.at(0) == Approx(17));
    CHECK(volumes.at(2) == Approx(9));
  }
}
