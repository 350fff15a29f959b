// The Delaunay kernel: empty spheres, one result whatever the order, degenerate point sets, bad luck.
#include <algorithm>
#include <catch2/catch.hpp>
#include <functional>
#include <numeric>
#include <random>
#include <set>

#include "core/predicates/predicates.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/locate.hpp"
#include "tests/mesher/delaunay_oracle.hpp"
#include "tests/support/tet_fixtures.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {
namespace {

using oracle_tests::random_points;
using Tet = std::array<std::uint32_t, 4>;

std::vector<std::uint32_t> all_ids(std::size_t count) {
  std::vector<std::uint32_t> ids(count);
  std::iota(ids.begin(), ids.end(), 0u);
  return ids;
}

struct Tetrahedralised {
  TetMesh mesh;
  DelaunayResult result;
};

Tetrahedralised tetrahedralise(const std::vector<Vec3>& points) {
  Tetrahedralised made;
  made.mesh.points = GrowingArray<Vec3>(std::span(points));
  made.result = make_delaunay(made.mesh, all_ids(points.size()), TaskRunner(1));
  return made;
}

// By the lemma of Delaunay, empty spheres across all faces make all spheres empty.
std::size_t count_conflicts(const TetMesh& mesh) {
  std::size_t conflicts = 0;
  for (const FaceCode face : mesh.faces()) {
    const FaceCode behind = mesh.behind(face);
    if (!behind.valid()) continue;
    const std::uint32_t t = face.tet();
    conflicts += insphere(mesh.point_of(t, 0), mesh.point_of(t, 1), mesh.point_of(t, 2), mesh.point_of(t, 3),
                          mesh.points[mesh.apex(behind)]) > 0;
  }
  return conflicts;
}

double volume_of(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a) / 6;
}

void check_delaunay(const std::vector<Vec3>& points) {
  const Tetrahedralised made = tetrahedralise(points);
  const TetMesh& mesh = made.mesh;
  REQUIRE(find_fault(mesh) == "");
  CHECK(count_conflicts(mesh) == 0);
  const std::uint32_t o = made.result.first_outer;
  double volume = 0;
  std::set<std::uint32_t> used;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    volume += volume_of(mesh.point_of(t, 0), mesh.point_of(t, 1), mesh.point_of(t, 2), mesh.point_of(t, 3));
    for (int i = 0; i < 4; ++i) used.insert(mesh.to_vert[std::size_t{t} * 4 + i]);
  }
  CHECK(volume ==
        Approx(volume_of(mesh.points[o], mesh.points[o + 1], mesh.points[o + 2], mesh.points[o + 3])).epsilon(1e-10));
  CHECK(used.size() == points.size() + 4 - made.result.duplicates.size());
}

// Radius of the sphere around a tet.
double radius_of(const TetMesh& mesh, std::uint32_t t) {
  const Vec3 a = mesh.point_of(t, 0), p = mesh.point_of(t, 1) - a, q = mesh.point_of(t, 2) - a,
             r = mesh.point_of(t, 3) - a;
  const Vec3 center = norm2(p) * cross(q, r) + norm2(q) * cross(r, p) + norm2(r) * cross(p, q);
  return norm(center) / (2 * std::abs(dot(p, cross(q, r))));
}

// The tets among the given points, by their ids, whatever the order of corners and tets; without those whose spheres
// reach towards the outer points, which do not turn with the others.
std::set<Tet> tets_of(const std::vector<Vec3>& points) {
  const Tetrahedralised made = tetrahedralise(points);
  Box3 box;
  for (const Vec3& x : points) box.add(x);
  std::set<Tet> tets;
  for (std::uint32_t t = 0; t < made.mesh.size(); ++t) {
    if (radius_of(made.mesh, t) > box.hi.x - box.lo.x) continue;
    Tet tet;
    for (std::size_t i = 0; i < 4; ++i) tet[i] = made.mesh.to_vert[std::size_t{t} * 4 + i];
    std::sort(tet.begin(), tet.end());
    if (tet[3] < points.size()) tets.insert(tet);
  }
  return tets;
}

std::vector<Vec3> cubic_lattice(int n) {
  std::vector<Vec3> points;
  for (int i = 0; i < n * n * n; ++i) points.push_back({double(i % n), double(i / n % n), double(i / n / n)});
  return points;
}

std::vector<Vec3> on_sphere(std::size_t count) {
  std::vector<Vec3> points = random_points(count, 5);
  for (Vec3& x : points) x = normalized(x - Vec3{0.5, 0.5, 0.5});
  return points;
}

}  // namespace

TEST_CASE("spheres of tetrahedra of random points are empty") { check_delaunay(random_points(5000, 1)); }

TEST_CASE("points of a lattice, all cospherical and coplanar, are tetrahedralised without flat tets") {
  check_delaunay(cubic_lattice(9));
}

TEST_CASE("points on a sphere, on a plane and on a line are tetrahedralised") {
  check_delaunay(on_sphere(2000));
  std::vector<Vec3> plane = random_points(1000, 2), line = random_points(200, 3);
  for (Vec3& x : plane) x.z = 0.25;
  for (Vec3& x : line) x = {x.x, 0, 0};
  check_delaunay(plane);
  check_delaunay(line);
}

TEST_CASE("clusters of very different density are tetrahedralised") {
  std::vector<Vec3> points = random_points(2000, 4);
  for (std::size_t i = 0; i < 1000; ++i) points[i] = Vec3{0.3, 0.3, 0.3} + 1e-9 * points[i];
  check_delaunay(points);
}

TEST_CASE("no points, one and two leave only tets with the outer points") {
  for (std::size_t count = 0; count < 3; ++count) {
    check_delaunay(random_points(count, 6));
    CHECK(tets_of(random_points(count, 6)).empty());
  }
}

TEST_CASE("a point that lies on another one is told and left out") {
  std::vector<Vec3> points = random_points(500, 7);
  points.push_back(points[123]);
  points.push_back(points[7]);
  const Tetrahedralised made = tetrahedralise(points);
  REQUIRE(made.result.duplicates.size() == 2);
  for (const Duplicate& duplicate : made.result.duplicates) CHECK(points[duplicate.vert] == points[duplicate.kept]);
  check_delaunay(points);
}

TEST_CASE("turning, moving and scaling the points by exact steps changes no tet, degenerate or not") {
  for (const std::vector<Vec3>& points : {random_points(2000, 8), cubic_lattice(7)}) {
    const std::set<Tet> tets = tets_of(points);
    for (const auto& move : std::vector<std::function<Vec3(const Vec3&)>>{[](const Vec3& x) {
                                                                            return Vec3{x.y, x.z, x.x};
                                                                          },
                                                                          [](const Vec3& x) {
                                                                            return Vec3{-x.y, x.x, x.z};
                                                                          },
                                                                          [](const Vec3& x) { return 0x1p-20 * x; },
                                                                          [](const Vec3& x) { return 0x1p20 * x; }}) {
      std::vector<Vec3> moved;
      for (const Vec3& x : points) moved.push_back(move(x));
      CHECK((tets_of(moved) == tets));
    }
  }
}

TEST_CASE("only the points listed are inserted") {
  TetMesh mesh;
  const std::vector<Vec3> points = random_points(100, 9);
  mesh.points = GrowingArray<Vec3>(std::span(points));
  make_delaunay(mesh, std::vector<std::uint32_t>{3, 14, 15, 92, 65}, TaskRunner(1));
  CHECK(find_fault(mesh) == "");
  for (const std::uint32_t v : mesh.to_vert) CHECK((v >= 100 || v == 3 || v == 14 || v == 15 || v == 92 || v == 65));
}

TEST_CASE("more points make the tets that all of them together make, wherever the outer points stand") {
  const auto points = random_points(400, 12);
  std::vector<Vec3> grid;  // many ties
  for (int i = 0; i < 512; ++i) grid.push_back(Vec3{i % 8 / 8., i / 8 % 8 / 8., i / 64 / 8.});
  for (const std::vector<Vec3>& all : {points, grid}) {
    std::vector<std::uint64_t> keys;
    for (std::size_t i = 0; i < all.size(); ++i) keys.push_back(i * 7 % all.size());
    const DelaunayFrame frame{{{-0.1, 0, 0}, {1.2, 1, 1.1}}, keys};
    TetMesh whole, grown;
    whole.points = GrowingArray<Vec3>(std::span(all));
    make_delaunay(whole, all_ids(all.size()), TaskRunner(1), frame);
    const std::size_t first = all.size() / 3;
    grown.points = GrowingArray<Vec3>(std::span(all).first(first));
    auto made = make_delaunay(grown, all_ids(first), TaskRunner(1), frame);
    for (const std::size_t end : {first + 1, first + 40, all.size()}) {
      const auto before = static_cast<std::uint32_t>(made.first_outer);
      grown.points.resize(before);
      std::fill(grown.to_fixed.begin(), grown.to_fixed.end(), std::uint8_t{5});
      grown.points.append(std::span(all).subspan(before, end - before));
      const std::vector<std::uint32_t> ids = all_ids(end);
      made = extend_delaunay(grown, before, std::span(ids).subspan(before), TaskRunner(1), frame);
      REQUIRE(find_fault(grown) == "");
    }
    CHECK((tet_tests::tets_of(grown) == tet_tests::tets_of(whole)));
  }
}

TEST_CASE("tetrahedralising ends when it is cancelled") {
  CancelToken cancel;
  cancel.cancel();
  TetMesh mesh;
  const std::vector<Vec3> points = random_points(100, 10);
  mesh.points = GrowingArray<Vec3>(std::span(points));
  const TaskRunner runner(1, {{}, &cancel});
  CHECK_THROWS_AS(make_delaunay(mesh, all_ids(100), runner), Error);
}

TEST_CASE("a walk ends in a tet that holds the point, wherever it starts") {
  const unsigned seed = 20261121;
  CAPTURE(seed);
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vec3> points(2000);
  for (Vec3& x : points) x = {uniform(random), uniform(random), uniform(random)};
  const Tetrahedralised made = tetrahedralise(points);
  const TetMesh& mesh = made.mesh;
  Walk walk;
  for (int i = 0; i < 2000; ++i) {
    if (i % 10 == 0) walk.restart(static_cast<std::uint32_t>(random() % mesh.size()));
    // Vertices, places on edges, and others.
    const Vec3 &a = points[random() % points.size()], &b = points[random() % points.size()];
    const Vec3 x = i % 3 == 0   ? a
                   : i % 3 == 1 ? 0.5 * (a + b)
                                : Vec3{uniform(random), uniform(random), uniform(random)};
    const std::uint32_t tet = walk.locate(mesh, x);
    for (const auto& face : kFaceVerts)
      REQUIRE(orient3d(mesh.point_of(tet, face[0]), mesh.point_of(tet, face[1]), mesh.point_of(tet, face[2]), x) <= 0);
  }
}

TEST_CASE("compacting drops dead tets and keeps the others joined") {
  Tetrahedralised made = tetrahedralise(random_points(50, 11));
  TetMesh& mesh = made.mesh;
  const std::size_t before = mesh.size();
  std::size_t killed = 0;
  for (std::uint32_t t = 0; t < mesh.size(); t += 3) {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const FaceCode behind = mesh.behind({t, i});
      if (behind.valid()) mesh.behind(behind) = {};
    }
    mesh.to_vert[std::size_t{t} * 4] = kNone;
    ++killed;
  }
  compact(mesh);
  CHECK(mesh.size() == before - killed);
  CHECK(find_fault(mesh) == "");
}

}  // namespace tetloom::tets
