#include "core/mesh/mesh_access.hpp"

#include <string>

#include "core/base/error.hpp"

namespace tetloom {
namespace {

template <class Elements>
void require_indices(const Elements& elements, std::size_t entity_count, std::size_t point_count, const char* what) {
  if (elements.size() != entity_count)
    throw Error(ErrorCode::InvalidArgument, "the mesh has " + std::to_string(elements.size()) + " " + what + " but " +
                                                std::to_string(entity_count) + " entities for them");
  for (std::size_t i = 0; i < elements.size(); ++i)
    for (const std::uint32_t vertex : elements[i])
      if (vertex >= point_count)
        throw Error(Diagnostic{ErrorCode::InvalidArgument,
                               "element " + std::to_string(i) + " of the mesh's " + what + " refers to point " +
                                   std::to_string(vertex) + " of " + std::to_string(point_count),
                               {},
                               {},
                               {i}});
}

}  // namespace

void require_consistent(const Mesh& mesh) {
  const std::size_t points = mesh.points.size();
  if (points >= 0xffffffffu) throw Error(ErrorCode::InvalidArgument, "the mesh has more than 2^32 - 2 points");
  if (!mesh.point_to_entity.empty() && mesh.point_to_entity.size() != points)
    throw Error(ErrorCode::InvalidArgument, "the mesh has " + std::to_string(points) + " points but " +
                                                std::to_string(mesh.point_to_entity.size()) + " entities for them");
  require_indices(mesh.edge_to_vert, mesh.edge_to_entity.size(), points, "edges");
  require_indices(mesh.tri_to_vert, mesh.tri_to_entity.size(), points, "triangles");
  require_indices(mesh.tet_to_vert, mesh.tet_to_entity.size(), points, "tets");
}

}  // namespace tetloom
