#include "adapt/metric/tet_links.hpp"

#include "core/tets/face_groups.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::adapt {

std::vector<FaceCode> link_tets(const TetView& mesh, const BlockLoop& loop) {
  TETLOOM_ASSERT(mesh.tets.size() < (std::size_t{1} << 30));
  std::vector<FaceCode> links(mesh.tets.size() * 4);
  if (mesh.tets.empty()) return links;
  tets::for_each_face_group({mesh.tets[0].data(), links.size()}, mesh.points.size(), loop,
                            [&](std::span<const FaceCode> faces, const tets::TriangleVerts&) {
                              if (faces.size() < 2) return;
                              links[faces[0].index()] = faces[1], links[faces[1].index()] = faces[0];
                            });
  return links;
}

}  // namespace tetloom::adapt
