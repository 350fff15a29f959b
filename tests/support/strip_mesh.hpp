#pragma once
// A small flat surface mesh, of one face or two.
#include <cstdint>

#include "tetloom/mesh_data.hpp"

namespace tetloom::test_models {

/// Two rows of squares, each cut in two, in one face, but for the points, which are as given; the middle row of points
/// (4 … 7) lies on the model edge 0 where `with_edge`.
///
///   8---9--10--11
///   | / | / | / |
///   4---5---6---7
///   | / | / | / |
///   0---1---2---3
inline Mesh make_strip(bool with_edge) {
  Mesh mesh;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 4; ++i) mesh.points.push_back({double(i), double(j), 0});
  mesh.point_to_entity.assign(12, ModelFaceId(0));
  for (std::uint32_t j = 0; j < 2; ++j)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = 4 * j + i, b = a + 1, c = a + 4, d = c + 1;
      mesh.tri_to_vert.push_back({a, b, d});
      mesh.tri_to_vert.push_back({a, d, c});
      mesh.tri_to_entity.insert(mesh.tri_to_entity.end(), 2, with_edge ? j : 0);
    }
  for (std::uint32_t i = 4; with_edge && i < 7; ++i) {
    mesh.edge_to_vert.push_back({i, i + 1});
    mesh.edge_to_entity.push_back(0);
  }
  for (std::uint32_t i = 4; with_edge && i < 8; ++i) mesh.point_to_entity[i] = ModelEdgeId(0);
  for (const std::uint32_t rim : {0, 1, 2, 3, 8, 9, 10, 11}) mesh.point_to_entity[rim] = ModelEdgeId(1);
  mesh.face_to_sides.resize(2);
  return mesh;
}

}  // namespace tetloom::test_models
