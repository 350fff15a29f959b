#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>
#include <set>

#include "core/mesh/siphash_detail.hpp"
#include "tests/core/mesh_fixtures.hpp"
#include "tetloom/check.hpp"
#include "tetloom/error.hpp"

using namespace tetloom;

namespace {

/// The same mesh with everything renumbered, and the vertices of every tet and triangle rotated.
Mesh renumbered(const Mesh& mesh, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<std::uint32_t> order(mesh.points.size());
  std::iota(order.begin(), order.end(), 0u);
  std::shuffle(order.begin(), order.end(), random);
  Mesh other = mesh;
  for (std::size_t i = 0; i < order.size(); ++i) {
    other.points[order[i]] = mesh.points[i];
    other.point_to_entity[order[i]] = mesh.point_to_entity[i];
  }
  const auto permute = [&](auto& elements, auto& entities) {
    for (auto& element : elements) {
      for (auto& v : element) v = order[v];
      if (element.size() == 3) std::rotate(element.begin(), element.begin() + random() % 3, element.end());
      if (element.size() == 4) std::swap(element[0], element[1]), std::swap(element[2], element[3]);
      if (element.size() == 4) std::rotate(element.begin() + 1, element.begin() + 1 + random() % 3, element.end());
    }
    std::vector<std::size_t> places(elements.size());
    std::iota(places.begin(), places.end(), 0u);
    std::shuffle(places.begin(), places.end(), random);
    auto old_elements = elements;
    auto old_entities = entities;
    for (std::size_t i = 0; i < places.size(); ++i) {
      elements[places[i]] = old_elements[i];
      entities[places[i]] = old_entities[i];
    }
  };
  permute(other.edge_to_vert, other.edge_to_entity);
  permute(other.tri_to_vert, other.tri_to_entity);
  permute(other.tet_to_vert, other.tet_to_entity);
  return other;
}

}  // namespace

TEST_CASE("the hash agrees with the published test vectors of SipHash-2-4-128") {
  constexpr std::uint64_t key0 = 0x0706050403020100, key1 = 0x0f0e0d0c0b0a0908;
  const detail::Hash128 empty = detail::siphash128({}, key0, key1);
  CHECK(empty.low == 0xe6a825ba047f81a3);
  CHECK(empty.high == 0x930255c71472f66d);
  const std::array<std::uint64_t, 1> word{0x0706050403020100};
  const detail::Hash128 eight = detail::siphash128(word, key0, key1);
  CHECK(eight.low == 0x61f55862baa9623b);
  CHECK(eight.high == 0xb49714f364e2830f);
}

TEST_CASE("the digest does not depend on the numbering of anything") {
  Mesh mesh = test::make_box(4, 3, 2, true);
  test::jitter(mesh, 0.1, 7);
  const std::string digest = mesh_digest(mesh);
  CHECK(digest.size() == 32);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    INFO("seed " << seed);
    CHECK(mesh_digest(renumbered(mesh, seed)) == digest);
  }
}

TEST_CASE("the digest of a mesh of tets stays what it has always been") {
  CHECK(mesh_digest(test::make_box(4, 3, 2, true)) == "d54f2f3307ec0665771587b5df410d51");
}

TEST_CASE("the digest takes -0 and +0 for the same") {
  Mesh mesh = test::make_box(2, 2, 2);
  const std::string digest = mesh_digest(mesh);
  mesh.points[0] = {-0.0, 0.0, -0.0};
  CHECK(mesh_digest(mesh) == digest);
}

TEST_CASE("names and face sides do not count for the digest") {
  Mesh mesh = test::make_box(2, 2, 2, true);
  const std::string digest = mesh_digest(mesh);
  test::decorate(mesh);
  mesh.face_to_sides.clear();
  CHECK(mesh_digest(mesh) == digest);
}

TEST_CASE("every change of a coordinate, a connection or a classification changes the digest") {
  const Mesh mesh = test::make_box(2, 2, 2, true);
  std::set<std::string> digests{mesh_digest(mesh)};
  const auto changed = [&](const auto& change) {
    Mesh other = mesh;
    change(other);
    return digests.insert(mesh_digest(other)).second;
  };
  CHECK(changed([](Mesh& m) { m.points[5].y = std::nextafter(m.points[5].y, 2.0); }));
  CHECK(changed([](Mesh& m) { m.point_to_entity[5].index += 1; }));
  CHECK(changed([](Mesh& m) { m.point_to_entity[5] = {}; }));
  CHECK(changed([](Mesh& m) { m.tet_to_entity[3] ^= 1; }));
  CHECK(changed([](Mesh& m) { m.tri_to_entity[3] += 1; }));
  CHECK(changed([](Mesh& m) { m.edge_to_entity[3] += 1; }));
  CHECK(changed([](Mesh& m) { std::swap(m.tet_to_vert[3][0], m.tet_to_vert[3][1]); }));
  CHECK(changed([](Mesh& m) { std::swap(m.tri_to_vert[3][0], m.tri_to_vert[3][1]); }));
  CHECK(changed([](Mesh& m) { std::swap(m.edge_to_vert[3][0], m.edge_to_vert[3][1]); }));
  CHECK(changed([](Mesh& m) { m.tet_to_vert[3][0] = m.tet_to_vert[4][3]; }));
  CHECK(changed([](Mesh& m) { m.tet_to_vert.pop_back(), m.tet_to_entity.pop_back(); }));
  CHECK(changed([](Mesh& m) { m.points.push_back({9, 9, 9}), m.point_to_entity.push_back({}); }));
  CHECK(changed([](Mesh& m) { m.tri_to_vert.push_back(m.tri_to_vert[0]), m.tri_to_entity.push_back(0); }));
  CHECK(changed([](Mesh& m) { m = Mesh{}; }));
}

TEST_CASE("points that cannot be told apart do not bring the order back in") {
  Mesh mesh = test::make_box(2, 1, 1);
  // A second copy of the mesh in the same place, without classification: every point has a twin.
  Mesh twice = mesh;
  const auto base = static_cast<std::uint32_t>(mesh.points.size());
  twice.point_to_entity.assign(base, {});
  mesh = twice;
  twice.points.insert(twice.points.end(), mesh.points.begin(), mesh.points.end());
  twice.point_to_entity.resize(twice.points.size());
  for (auto tet : mesh.tet_to_vert) {
    for (auto& v : tet) v += base;
    twice.tet_to_vert.push_back(tet);
    twice.tet_to_entity.push_back(0);
  }
  CHECK(mesh_digest(twice) != mesh_digest(mesh));
  CHECK(mesh_digest(renumbered(twice, 3)) == mesh_digest(twice));
}

TEST_CASE("a digest of a mesh with broken indices is refused") {
  Mesh mesh = test::make_box(1, 1, 1);
  mesh.tri_to_vert[0][0] = 8;
  CHECK_THROWS_AS(mesh_digest(mesh), Error);
}
