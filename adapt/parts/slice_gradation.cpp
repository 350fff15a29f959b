#include "adapt/parts/slice_gradation.hpp"

#include "adapt/parts/slice_links.hpp"

namespace tetloom::adapt {

void limit_gradation(MeshSlice& slice, double growth, const SharedWork& work) {
  const GhostLinks ghosts(slice, VertexOwners(slice, work), work);
  const VertexGraph graph(tets_of(slice.mesh), work.runner());
  limit_gradation(slice.metric, slice.mesh.points, graph, growth, ghosts.own_verts(), work.runner());
}

}  // namespace tetloom::adapt
