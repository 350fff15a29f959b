#include "mesher/surface/drop_faces.hpp"

#include <algorithm>

#include "core/base/lists.hpp"

namespace tetloom {
namespace {

using NodePair = std::array<std::uint32_t, 2>;

void drop_triangles(const std::vector<bool>& marked, Mesh& mesh) {
  std::size_t kept = 0;
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    if (marked[mesh.tri_to_entity[t]]) continue;
    mesh.tri_to_vert[kept] = mesh.tri_to_vert[t];
    mesh.tri_to_entity[kept++] = mesh.tri_to_entity[t];
  }
  mesh.tri_to_vert.resize(kept);
  mesh.tri_to_entity.resize(kept);
}

void drop_bare_edges(Mesh& mesh) {
  std::vector<NodePair> sides;
  sides.reserve(3 * mesh.tri_to_vert.size());
  for (const auto& [a, b, c] : mesh.tri_to_vert)
    for (const NodePair& side : {ascending(a, b), ascending(b, c), ascending(c, a)}) sides.push_back(side);
  std::sort(sides.begin(), sides.end());
  std::size_t kept = 0;
  for (std::size_t e = 0; e < mesh.edge_to_vert.size(); ++e) {
    const auto [a, b] = mesh.edge_to_vert[e];
    if (!std::binary_search(sides.begin(), sides.end(), ascending(a, b))) continue;
    mesh.edge_to_vert[kept] = mesh.edge_to_vert[e];
    mesh.edge_to_entity[kept++] = mesh.edge_to_entity[e];
  }
  mesh.edge_to_vert.resize(kept);
  mesh.edge_to_entity.resize(kept);
}

void drop_unused_points(Mesh& mesh) {
  std::vector<std::uint32_t> numbers(mesh.points.size(), kNone);
  for (const auto& tri : mesh.tri_to_vert)
    for (const std::uint32_t v : tri) numbers[v] = 0;
  std::uint32_t kept = 0;
  for (std::size_t v = 0; v < numbers.size(); ++v) {
    if (numbers[v] == kNone) continue;
    mesh.points[kept] = mesh.points[v];
    mesh.point_to_entity[kept] = mesh.point_to_entity[v];
    numbers[v] = kept++;
  }
  mesh.points.resize(kept);
  mesh.point_to_entity.resize(kept);
  for (auto& tri : mesh.tri_to_vert)
    for (std::uint32_t& v : tri) v = numbers[v];
  for (auto& edge : mesh.edge_to_vert)
    for (std::uint32_t& v : edge) v = numbers[v];
}

}  // namespace

void drop_faces(const std::vector<bool>& marked, Mesh& mesh) {
  drop_triangles(marked, mesh);
  drop_bare_edges(mesh);
  drop_unused_points(mesh);
}

}  // namespace tetloom
