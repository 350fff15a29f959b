#pragma once
// The tets around those that are to give way, as small meshes that share no vertex.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/tets/tet_mesh.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::second_order {

/// All tets that have a vertex of one of some bad tets.
struct BadPatch {
  std::vector<std::uint32_t> to_tet;   ///< of the mesh, ascending, by the patch's own numbers
  std::vector<std::uint32_t> to_vert;  ///< the same of vertices
  std::vector<std::uint32_t> bad;      ///< in the patch's own numbers, ascending
  tets::TetMesh tets;                  ///< triangles of the surface are fixed, nothing lies behind the patch's hull
};

/// Patches around the tets `bad`, which ascend: two of them lie in one where their tets share a vertex. Ascending by
/// their first bad tet. Linear in the mesh. Pre: the mesh has tets only.
std::vector<BadPatch> find_bad_patches(const Mesh& mesh, std::span<const std::uint32_t> bad, const TaskRunner& runner);

}  // namespace tetloom::second_order
