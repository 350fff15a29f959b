// Where faces meet in edges that are of no model edge.
#include <catch2/catch.hpp>

#include "mesher/intersection/pinched_edges.hpp"
#include "tests/support/strip_mesh.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::intersection;
using namespace tetloom::test_models;

TEST_CASE("faces that meet in an edge of no model edge are found") {
  Mesh mesh = make_strip(true);
  CHECK(find_pinched_edges(mesh, TaskRunner(1)).empty());
  // Without its piece, the edge from 4 to 5 is between two faces.
  mesh.edge_to_vert.erase(mesh.edge_to_vert.begin());
  mesh.edge_to_entity.erase(mesh.edge_to_entity.begin());
  const std::vector<TriangleIntersection> found = find_pinched_edges(mesh, TaskRunner(1));
  REQUIRE(found.size() == 1);
  CHECK(mesh.tri_to_entity[found[0].first] != mesh.tri_to_entity[found[0].second]);
  CHECK(distance(found[0].point, {0.5, 1, 0}) < 1e-12);
  // Two strips on each other, between the same points.
  mesh = make_strip(true);
  for (std::size_t t = 0, count = mesh.tri_to_vert.size(); t < count; ++t) {
    const auto [a, b, c] = mesh.tri_to_vert[t];
    mesh.tri_to_vert.push_back({a, c, b});
    mesh.tri_to_entity.push_back(mesh.tri_to_entity[t]);
  }
  CHECK(find_pinched_edges(mesh, TaskRunner(1)).size() >= 3);
}
