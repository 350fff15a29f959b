#include "adapt/metric/tet_links.hpp"

#include "core/tets/face_groups.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::adapt {

std::vector<std::uint32_t> link_tets(const TetView& mesh, const BlockLoop& loop) {
  TETLOOM_ASSERT(mesh.tets.size() < (std::size_t{1} << 30));
  std::vector<std::uint32_t> links(mesh.tets.size() * 4, kNone);
  if (mesh.tets.empty()) return links;
  tets::for_each_face_group({mesh.tets[0].data(), links.size()}, mesh.points.size(), loop,
                            [&](std::span<const tets::FaceCode> faces, const tets::TriangleVerts&) {
                              if (faces.size() > 1) links[faces[0]] = faces[1], links[faces[1]] = faces[0];
                            });
  return links;
}

}  // namespace tetloom::adapt
