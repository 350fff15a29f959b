// Tets take the place of others: links, hull and fixed faces are those that the vertices ask for.
#include "core/tets/cavity_filling.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "core/tets/edge_ring.hpp"
#include "tests/support/tet_fixtures.hpp"

using namespace tetloom;
using namespace tetloom::tets;
using namespace tetloom::tet_tests;

namespace {

using TetVerts = std::array<std::uint32_t, 4>;

TetVerts verts_of_tet(const TetMesh& mesh, std::uint32_t tet) {
  TetVerts verts;
  std::copy_n(mesh.to_vert.begin() + tet * std::size_t{4}, 4, verts.begin());
  return verts;
}

void write(TetMesh& mesh, std::uint32_t tet, const TetVerts& verts) {
  std::copy(verts.begin(), verts.end(), mesh.to_vert.begin() + tet * std::size_t{4});
  mesh.to_fixed[tet] = 0;
}

std::uint32_t append_tet(TetMesh& mesh, std::uint32_t region) {
  mesh.to_vert.resize(mesh.to_vert.size() + 4, kNone);
  mesh.to_neighbor.resize(mesh.to_neighbor.size() + 4);
  mesh.to_region.push_back(region);
  mesh.to_fixed.push_back(0);
  return static_cast<std::uint32_t>(mesh.size() - 1);
}

/// Some tets that hang together.
std::vector<std::uint32_t> pick_cavity(const TetMesh& mesh, std::size_t count, std::mt19937& random) {
  std::vector<std::uint32_t> tets{static_cast<std::uint32_t>(random() % mesh.size())};
  while (tets.size() < count) {
    const FaceCode behind = mesh.to_neighbor[tets[random() % tets.size()] * 4 + random() % 4];
    if (behind.valid() && std::find(tets.begin(), tets.end(), behind.tet()) == tets.end()) tets.push_back(behind.tet());
  }
  return tets;
}

/// The same tet with its corners in another order.
TetVerts turned(TetVerts v, std::mt19937& random) {
  for (int i = 0; i < 3; ++i) {
    std::shuffle(v.begin(), v.begin() + 2, random);
    std::rotate(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(random() % 4), v.end());
  }
  return v;
}

EdgeRing ring_of(std::uint32_t count) {
  EdgeRing ring;
  ring.a = count, ring.b = count + 1, ring.count = static_cast<int>(count);
  for (std::uint32_t i = 0; i < count; ++i) ring.verts[i] = ring.tets[i] = i;
  return ring;
}

}  // namespace

TEST_CASE("tets that are made anew in other places and orders are linked and fixed as they were") {
  const unsigned seed = 20261123;
  CAPTURE(seed);
  std::mt19937 random(seed);
  const TetMesh before = make_shaken_grid(5, 2, 0.3, seed).mesh;
  TetMesh mesh = before;
  CavityFilling filling;
  for (int trial = 0; trial < 300; ++trial) {
    CAPTURE(trial);
    const std::vector<std::uint32_t> old = pick_cavity(mesh, 1 + random() % 40, random);
    std::vector<std::pair<TetVerts, std::uint32_t>> made;
    for (const std::uint32_t tet : old) {
      TetVerts verts = turned(verts_of_tet(mesh, tet), random);
      const auto at = [&](std::size_t i) { return mesh.points[verts[i]]; };
      if (orient3d(at(0), at(1), at(2), at(3)) < 0) std::swap(verts[0], verts[1]);
      made.emplace_back(verts, mesh.to_region[tet]);
    }
    std::shuffle(made.begin(), made.end(), random);
    filling.open(mesh, old, made.size());
    for (std::size_t i = 0; i < old.size(); ++i)
      write(mesh, old[i], made[i].first), mesh.to_region[old[i]] = made[i].second;
    REQUIRE(filling.close(mesh, old));
    REQUIRE(find_fault(mesh).empty());
    REQUIRE(fixed_faces(mesh) == fixed_faces(before));
  }
  CHECK(tets_of(mesh) == tets_of(before));
}

TEST_CASE("the tets over a triangulation of a ring fill what the edge leaves") {
  const std::uint32_t count = GENERATE(3u, 4u, 7u);
  CAPTURE(count);
  TetMesh mesh = make_ring(count, 1);
  const double volume = volume_of_region(mesh, 0);
  const auto hull = fixed_faces(mesh);
  const EdgeRing ring = ring_of(count);
  CavityFilling filling;
  filling.open(mesh, ring.old(), 2 * (count - 2));
  std::vector<std::uint32_t> ids(ring.old().begin(), ring.old().end());
  while (ids.size() < 2 * (count - 2)) ids.push_back(append_tet(mesh, 0));
  for (std::size_t i = 2 * (count - 2); i < ids.size(); ++i) mesh.to_vert[ids[i] * std::size_t{4}] = kNone;
  ids.resize(2 * (count - 2));
  for (std::uint8_t t = 0; t + 2u < count; ++t) {
    const auto [at_b, at_a] = tets_over(ring, {0, static_cast<std::uint8_t>(t + 1), static_cast<std::uint8_t>(t + 2)});
    write(mesh, ids[2u * t], at_b), write(mesh, ids[2u * t + 1], at_a);
  }
  REQUIRE(filling.close(mesh, ids));
  CHECK(find_fault(mesh).empty());
  CHECK(fixed_faces(mesh) == hull);
  CHECK(volume_of_region(mesh, 0) == Approx(volume));
}

TEST_CASE("tets that leave a side of the cavity open do not fit") {
  TetMesh mesh = make_ring(5, 1);
  const EdgeRing ring = ring_of(5);
  CavityFilling filling;
  filling.open(mesh, ring.old(), 4);
  const auto [at_b, at_a] = tets_over(ring, {0, 1, 2});
  write(mesh, 0, at_b), write(mesh, 1, at_a);
  CHECK_FALSE(filling.close(mesh, std::array{0u, 1u}));
}

TEST_CASE("a triangle of the hull passes to the tet behind one that goes") {
  // Two tets, of which the upper has the hull's triangles (0, 1, 2): it goes, and they give way to the lower one's
  // face.
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 0.3, 1}, {0.3, 0.3, -1}};
  TetMesh mesh = make_tets(points, {{0, 1, 2, 3}, {0, 2, 1, 4}});
  CavityFilling filling;
  filling.open(mesh, std::array{0u}, 0);
  const std::array<TriangleVerts, 3> before{{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}}};
  const std::array<TriangleVerts, 1> after{{{0, 1, 2}}};
  filling.swap_surface(before, after);
  mesh.to_vert[0] = kNone;
  REQUIRE(filling.close(mesh, {}));
  CHECK(find_fault(mesh).empty());
  CHECK(mesh.is_fixed({1, 3}));
  CHECK_FALSE(mesh.behind({1, 3}).valid());
}

TEST_CASE("a surface inside of a cavity gives way to another one, fixed on both sides") {
  // Four tets around the edge 4-5, whose ring is 0 1 2 3: the surface through 0, 2 and the edge turns to 1, 3 and it.
  TetMesh mesh = make_ring(4, 1);
  for (const auto& [tet, behind] : {std::pair(0u, 3u), std::pair(2u, 1u)})
    for (const FaceCode face : FaceCode::of(tet))
      if (mesh.behind(face).tet() == behind) fix_face(mesh, face);
  const std::array<TriangleVerts, 2> before{{{4, 5, 0}, {4, 5, 2}}}, after{{{4, 5, 1}, {4, 5, 3}}};
  REQUIRE(find_fault(mesh).empty());
  const EdgeRing ring = ring_of(4);
  CavityFilling filling;
  filling.open(mesh, ring.old(), 4);
  filling.swap_surface(before, after);
  std::vector<TetVerts> made;
  for (const std::uint32_t tet : ring.old()) made.push_back(verts_of_tet(mesh, tet));
  // The same tets are made again.
  for (const std::uint32_t tet : ring.old()) write(mesh, tet, made[tet]);
  REQUIRE(filling.close(mesh, ring.old()));
  CHECK(find_fault(mesh).empty());
  for (const TriangleVerts& triangle : after)
    CHECK(std::ranges::count(fixed_faces(mesh), std::array{triangle[2], 4u, 5u}) == 2);
}

TEST_CASE("what lies behind two tets between the same vertices meets where both go") {
  // Tets 0 and 1 have two faces in common, at the edge 0-1; behind their others are 2 and 3, 4 and 5.
  TetMesh mesh;
  mesh.points.resize(8);
  for (const TetVerts& tet :
       std::vector<TetVerts>{{0, 1, 2, 3}, {1, 0, 2, 3}, {4, 0, 2, 3}, {5, 1, 2, 3}, {6, 0, 2, 3}, {7, 1, 2, 3}})
    write(mesh, append_tet(mesh, 0), tet);
  for (const auto& [one, other] : {std::pair(2u, 6u), {3u, 7u}, {1u, 8u}, {0u, 12u}, {4u, 16u}, {5u, 20u}})
    link_sides(mesh, FaceCode::at(one), FaceCode::at(other));
  fix_face(mesh, {5, 0});
  CavityFilling filling;
  filling.open(mesh, std::array{0u, 1u}, 0);
  REQUIRE(filling.close(mesh, {}));
  const FaceCode behind_first(2, 0), behind_second(4, 0), fixed_first(3, 0), fixed_second(5, 0);
  CHECK(mesh.behind(behind_first) == behind_second);
  CHECK(mesh.behind(behind_second) == behind_first);
  CHECK(mesh.behind(fixed_first) == fixed_second);
  CHECK(mesh.behind(fixed_second) == fixed_first);
  CHECK((mesh.is_fixed(fixed_first) && mesh.is_fixed(fixed_second)));
  CHECK_FALSE((mesh.is_fixed(behind_first) || mesh.is_fixed(behind_second)));
}
