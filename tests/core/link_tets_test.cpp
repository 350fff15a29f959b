// Tets given by their vertices become a mesh, or a fault says why they cannot.
#include "core/tets/link_tets.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "tests/support/tet_fixtures.hpp"

using namespace tetloom;
using namespace tetloom::tets;
using namespace tetloom::tet_tests;

namespace {

using TetVerts = std::array<std::uint32_t, 4>;

const std::vector<Vec3> kPoints{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 1}, {0.1, 0.1, 2}};
const TetVerts kBelow{0, 1, 2, 3}, kAbove{1, 2, 3, 4};

TetMesh points_only() {
  TetMesh mesh;
  mesh.points = GrowingArray<Vec3>(std::span(kPoints));
  return mesh;
}

Fault fault_of(const std::vector<TetVerts>& tets, const std::vector<TriangleVerts>& triangles = {}) {
  TetMesh mesh = points_only();
  return link_tets(mesh, tets, triangles, TaskRunner(1));
}

std::string message_of(const std::vector<TetVerts>& tets, const std::vector<TriangleVerts>& triangles = {}) {
  return fault_of(tets, triangles).message;
}

}  // namespace

TEST_CASE("tets turned and numbered at random are linked as they were") {
  const unsigned seed = 20240612;
  CAPTURE(seed);
  std::mt19937 random(seed);
  const TetMesh expected = make_shaken_grid(12, 2, 0.3, seed).mesh;
  std::vector<TetVerts> tets;
  for (std::size_t t = 0; t < expected.size(); ++t) {
    TetVerts& tet = tets.emplace_back();
    std::copy_n(expected.to_vert.begin() + t * 4, 4, tet.begin());
    std::shuffle(tet.begin(), tet.end(), random);
  }
  std::vector<TriangleVerts> surface = fixed_faces(expected);
  surface.erase(std::unique(surface.begin(), surface.end()), surface.end());
  for (TriangleVerts& triangle : surface) std::shuffle(triangle.begin(), triangle.end(), random);
  const int threads = GENERATE(1, 4);
  CAPTURE(threads);
  TetMesh mesh;
  mesh.points = expected.points;
  REQUIRE(!link_tets(mesh, tets, surface, TaskRunner(threads)).any());
  CHECK(find_fault(mesh).empty());
  CHECK(fixed_faces(mesh) == fixed_faces(expected));
  const auto count_hull = [](const TetMesh& m) { return std::ranges::count(m.to_neighbor, FaceCode()); };
  CHECK(count_hull(mesh) == count_hull(expected));
}

TEST_CASE("tets that make no mesh are a fault") {
  CHECK(message_of({kBelow, kAbove}).empty());
  CHECK(message_of({kBelow, {0, 1, 2, 2}}) == "a tetrahedron has no volume");
  CHECK(message_of({kBelow, kAbove, {1, 2, 3, 5}}) == "more than two tetrahedra share a face");
  CHECK(message_of({kAbove, {1, 2, 3, 5}}) == "two tetrahedra lie on one side of a face");
}

TEST_CASE("of many faults the first is told, on any number of threads") {
  const TetMesh grid = make_shaken_grid(12, 1, 0.3, 5).mesh;
  std::vector<TetVerts> tets(grid.size());
  for (std::size_t t = 0; t < tets.size(); ++t) std::copy_n(grid.to_vert.begin() + t * 4, 4, tets[t].begin());
  const auto fault_of_grid = [&](int threads) {
    TetMesh mesh;
    mesh.points = grid.points;
    return link_tets(mesh, tets, {}, TaskRunner(threads));
  };
  for (const std::size_t t : {9000u, 5000u, 7000u}) tets.push_back(tets[t]);
  const Vec3 there = fault_of_grid(1).point;
  for (int i = 0; i < 5; ++i) {
    const Fault fault = fault_of_grid(4);
    CHECK(fault.message == "more than two tetrahedra share a face");
    CHECK(fault.point == there);
  }
  for (const std::size_t t : {8000u, 6000u}) tets[t][3] = tets[t][2];
  for (const int threads : {1, 4}) {
    const Fault fault = fault_of_grid(threads);
    CHECK(fault.message == "a tetrahedron has no volume");
    CHECK(fault.point == grid.points[tets[6000][0]]);
  }
}

TEST_CASE("triangles that are no faces of the tets are named") {
  const Fault fault = fault_of({kBelow, kAbove}, {{1, 3, 2}, {0, 1, 4}, {0, 2, 1}, {2, 3, 5}});
  CHECK(fault.message == "2 surface triangles are not faces of the mesh");
  CHECK(fault.triangles == std::vector<std::uint32_t>{1, 3});
  CHECK(distance(fault.point, Vec3{2, 1, 1} / 3.0) < 1e-12);
}
