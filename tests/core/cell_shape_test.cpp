#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "core/predicates/predicates.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/vec.hpp"

using namespace tetloom;

namespace {

/// Positive cells as mesh.hpp describes them.
std::vector<Vec3> reference_cell(CellKind kind) {
  switch (kind) {
    case CellKind::Tet: return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    case CellKind::Pyramid: return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}};
    case CellKind::Prism: return {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
    case CellKind::Hex: return {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  }
  return {};
}

using Pair = std::pair<int, int>;

}  // namespace

TEST_CASE("every edge of a cell lies in two faces that run along it in opposite directions") {
  for (const CellKind kind : kAllCellKinds) {
    INFO(to_string(kind));
    const CellShape& shape = shape_of(kind);
    std::multiset<Pair> directed;
    for (const LocalFace& face : shape.faces())
      for (std::size_t i = 0; i < face.count; ++i) directed.insert({face.vert[i], face.vert[(i + 1) % face.count]});
    CHECK(directed.size() == 2u * shape.edge_count);
    std::set<Pair> edges;
    for (const auto& edge : shape.edges()) {
      CHECK(edges.insert(std::minmax<int>(edge[0], edge[1])).second);
      CHECK(directed.count({edge[0], edge[1]}) == 1);
      CHECK(directed.count({edge[1], edge[0]}) == 1);
    }
    CHECK(shape.vertex_count - shape.edge_count + shape.face_count == 2);
  }
}

TEST_CASE("the faces of a cell turn counter-clockwise seen from outside") {
  for (const CellKind kind : kAllCellKinds) {
    INFO(to_string(kind));
    const std::vector<Vec3> points = reference_cell(kind);
    REQUIRE(points.size() == shape_of(kind).vertex_count);
    for (const LocalFace& face : shape_of(kind).faces()) {
      std::set<int> on_face(face.vertices().begin(), face.vertices().end());
      CHECK(on_face.size() == face.count);
      for (int v = 0; v < static_cast<int>(points.size()); ++v) {
        const int expected = on_face.contains(v) ? 0 : -1;
        for (std::size_t i = 0; i < face.count; ++i)
          CHECK(orient3d(points[face.vert[i]], points[face.vert[(i + 1) % face.count]],
                         points[face.vert[(i + 2) % face.count]], points[v]) == expected);
      }
    }
  }
}

TEST_CASE("the corners of a cell follow its edges and are positive") {
  for (const CellKind kind : kAllCellKinds) {
    INFO(to_string(kind));
    const std::vector<Vec3> points = reference_cell(kind);
    std::set<Pair> edges;
    for (const auto& [a, b] : shape_of(kind).edges()) edges.insert({a, b}), edges.insert({b, a});
    std::set<int> tops;
    for (const auto& [a, b, c, d] : corners_of(kind)) {
      CHECK(tops.insert(a).second);
      for (const int end : {b, c, d}) CHECK(edges.contains({a, end}));
      CHECK(orient3d(points[a], points[b], points[c], points[d]) == 1);
    }
    const std::size_t expected = kind == CellKind::Tet ? 1 : kind == CellKind::Pyramid ? 4 : points.size();
    CHECK(tops.size() == expected);
  }
}

TEST_CASE("the faces of a tet lie opposite to their vertices") {
  const CellShape& tet = shape_of(CellKind::Tet);
  for (int f = 0; f < 4; ++f)
    for (const int v : tet.faces()[f].vertices()) CHECK(v != f);
}
