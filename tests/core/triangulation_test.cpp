#include "core/spatial/triangulation.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <random>
#include <set>

using tetloom::Triangulation;

namespace {

// A grid of n × n squares, each cut in two.
Triangulation make_grid(std::uint32_t n) {
  Triangulation mesh;
  for (std::uint32_t i = 0; i < (n + 1) * (n + 1); ++i) mesh.add_vertex();
  std::vector<std::array<std::uint32_t, 3>> tris;
  for (std::uint32_t j = 0; j < n; ++j)
    for (std::uint32_t i = 0; i < n; ++i) {
      const std::uint32_t a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      tris.push_back({a, b, c});
      tris.push_back({a, c, d});
    }
  for (const auto& [a, b, c] : tris) mesh.add_triangle(a, b, c);
  for (std::uint32_t h = 0; h < mesh.half_edges(); ++h)
    for (std::uint32_t g = 0; g < h; ++g)
      if (mesh.origin(g) == mesh.target(h) && mesh.target(g) == mesh.origin(h)) mesh.link(h, g);
  return mesh;
}

struct Counts {
  std::uint32_t triangles = 0;
  int euler = 0;
};

Counts count(const Triangulation& mesh) {
  std::set<std::uint32_t> vertices;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  Counts counts;
  for (std::uint32_t tri = 0; tri < mesh.slots(); ++tri) {
    if (!mesh.alive(tri)) continue;
    ++counts.triangles;
    for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
      vertices.insert(mesh.origin(h));
      edges.insert(std::minmax(mesh.origin(h), mesh.target(h)));
    }
  }
  counts.euler =
      static_cast<int>(vertices.size()) - static_cast<int>(edges.size()) + static_cast<int>(counts.triangles);
  return counts;
}

}  // namespace

TEST_CASE("a flip exchanges the diagonal and keeps fixed marks on the rim of its two triangles") {
  Triangulation mesh = make_grid(1);
  const std::uint32_t diagonal =
      mesh.find_half_edge(0, 3) != Triangulation::kNone ? mesh.find_half_edge(0, 3) : mesh.find_half_edge(3, 0);
  REQUIRE(diagonal != Triangulation::kNone);
  mesh.fix(mesh.find_half_edge(0, 1), 2);
  mesh.flip(diagonal);
  CHECK(mesh.validate());
  CHECK((mesh.find_half_edge(1, 2) != Triangulation::kNone && mesh.find_half_edge(2, 1) != Triangulation::kNone));
  CHECK(mesh.fixed(mesh.find_half_edge(0, 1)) == 2);
  CHECK(count(mesh).euler == 1);
}

TEST_CASE("a half-edge is found from either end, inside and at the rim, and only where there is one") {
  std::mt19937 random(3);
  Triangulation mesh = make_grid(6);
  for (int i = 0; i < 40; ++i)
    if (const auto h = static_cast<std::uint32_t>(random() % mesh.half_edges()); mesh.twin(h) != Triangulation::kNone)
      mesh.split_edge(h, mesh.add_vertex());
  for (std::uint32_t a = 0; a < mesh.vertex_count(); ++a)
    for (std::uint32_t b = 0; b < mesh.vertex_count(); ++b) {
      std::uint32_t expected = Triangulation::kNone;
      for (std::uint32_t h = 0; h < mesh.half_edges(); ++h)
        if (mesh.alive(h / 3) && mesh.origin(h) == a && mesh.target(h) == b) expected = h;
      REQUIRE(mesh.find_half_edge(a, b) == expected);
    }
}

TEST_CASE("splitting a fixed edge gives two fixed edges") {
  Triangulation mesh = make_grid(2);
  const std::uint32_t inner = mesh.find_half_edge(1, 4);
  REQUIRE(mesh.twin(inner) != Triangulation::kNone);
  mesh.fix(inner, 1);
  const std::uint32_t v = mesh.add_vertex();
  mesh.split_edge(inner, v);
  CHECK(mesh.validate());
  CHECK(mesh.fixed(mesh.find_half_edge(1, v)) == 1);
  CHECK(mesh.fixed(mesh.find_half_edge(v, 4)) == 1);
  CHECK(count(mesh).triangles == 10);
  CHECK(count(mesh).euler == 1);
}

TEST_CASE("a collapse is refused for a vertex on the rim or on a fixed edge") {
  Triangulation mesh = make_grid(2);
  CHECK_FALSE(mesh.collapse_keeps_topology(mesh.find_half_edge(0, 1)));
  CHECK(mesh.collapse_keeps_topology(mesh.find_half_edge(4, 1)));
  mesh.fix(mesh.find_half_edge(4, 5), 1);
  CHECK_FALSE(mesh.collapse_keeps_topology(mesh.find_half_edge(4, 1)));
}

TEST_CASE("an edge is not collapsed where another one joins its ends") {
  // Two discs of two triangles each, glued along both of the edges from a to b.
  Triangulation mesh;
  const std::uint32_t a = mesh.add_vertex(), b = mesh.add_vertex(), c = mesh.add_vertex(), d = mesh.add_vertex();
  mesh.add_triangle(a, b, c), mesh.add_triangle(b, a, c), mesh.add_triangle(b, a, d), mesh.add_triangle(a, b, d);
  for (const auto& [h, g] : {std::array{1u, 5u}, {2u, 4u}, {7u, 11u}, {8u, 10u}, {0u, 6u}, {3u, 9u}}) mesh.link(h, g);
  REQUIRE(mesh.validate());
  for (const std::uint32_t h : {0u, 3u, 6u, 9u}) CHECK_FALSE(mesh.collapse_keeps_topology(h));
}

TEST_CASE("random flips, splits and collapses keep the topology of a disc") {
  const auto seed = GENERATE(1u, 2u, 3u, 4u, 5u);
  INFO("seed " << seed);
  std::mt19937 random(seed);
  Triangulation mesh = make_grid(6);
  for (int step = 0; step < 2000; ++step) {
    const auto h = static_cast<std::uint32_t>(random() % mesh.half_edges());
    if (!mesh.alive(h / 3) || mesh.twin(h) == Triangulation::kNone) continue;
    switch (random() % 3) {
      case 0:
        if (mesh.find_half_edge(mesh.apex(h), mesh.apex(mesh.twin(h))) == Triangulation::kNone &&
            mesh.find_half_edge(mesh.apex(mesh.twin(h)), mesh.apex(h)) == Triangulation::kNone)
          mesh.flip(h);
        break;
      case 1: mesh.split_edge(h, mesh.add_vertex()); break;
      default:
        if (mesh.collapse_keeps_topology(h)) mesh.collapse(h);
    }
    if (step % 100 == 0) {
      REQUIRE(mesh.validate());
      REQUIRE(count(mesh).euler == 1);
    }
  }
  const std::uint32_t before = count(mesh).triangles;
  mesh.compact();
  CHECK(mesh.validate());
  CHECK(mesh.slots() == before);
}
