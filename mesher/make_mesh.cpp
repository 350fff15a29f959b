#include <algorithm>

#include "core/base/lists.hpp"
#include "core/base/stopwatch.hpp"
#include "mesher/layers/layered_mesh.hpp"
#include "mesher/mesh_run_detail.hpp"
#include "mesher/volume/gather_volume.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

void gather(VolumeParts&& volume, Mesh& mesh, Trace* trace, const SharedWork& work) {
  const TraceSpan span(trace, "mesh");
  gather_volume(std::move(volume), mesh, work.ranks(), work.runner());
}

// The first rank has the mesh.
double gather_above_layers(VolumeParts&& volume, const layers::LayerGrowth& growth, Mesh& mesh,
                           const MeshOptions& options, const SharedWork& work) {
  Mesh filled = growth.surface().mesh;
  gather(std::move(volume), filled, options.trace, work);
  if (work.rank() > 0) return 0;
  Stopwatch watch;
  mesh = layers::make_layered_mesh(growth, mesh, std::move(filled), options.layers.all_tets, work.runner_for_one());
  return watch.lap();
}

MeshResult make_whole_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host,
                           Communicator* ranks) {
  VolumeUse use;
  use.take = [&](VolumeParts&& volume, Mesh& mesh, const SharedWork& work) {
    gather(std::move(volume), mesh, options.trace, work);
  };
  use.take_above_layers = [&](VolumeParts&& volume, const layers::LayerGrowth& growth, Mesh& mesh,
                              const SharedWork& work) {
    return gather_above_layers(std::move(volume), growth, mesh, options, work);
  };
  return run_mesh(model, options, host, use, ranks);
}

}  // namespace

std::vector<ModelRegionId> regions_that_cross(const MeshResult& result, const ModelTopology& topology) {
  std::vector<ModelRegionId> regions;
  for (const Diagnostic& error : result.errors) {
    if (error.code != ErrorCode::SelfIntersection) continue;
    for (const NamedEntity& named : error.entities) {
      if (named.entity.dim != 2 || named.entity.index >= topology.face_count()) continue;
      const FaceSides& sides = topology.face_to_sides[named.entity.index];
      for (const ModelRegionId region : {sides.front, sides.back})
        if (region.valid()) regions.push_back(region);
    }
  }
  sort_unique(regions);
  return regions;
}

MeshResult make_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host) {
  return make_whole_mesh(model, options, host, nullptr);
}

MeshResult make_mesh_on_ranks(const GeometricModel& model, const MeshOptions& options, Communicator& communicator,
                              const Host& host) {
  return make_whole_mesh(model, options, host, &communicator);
}

}  // namespace tetloom
