#include <algorithm>

#include "mesher/mesh_run_detail.hpp"
#include "mesher/volume/gather_volume.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

MeshResult make_whole_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host,
                           Communicator* ranks) {
  const auto take = [&](VolumeParts&& volume, Mesh& mesh, const SharedWork& work) {
    const TraceSpan span(options.trace, "mesh");
    gather_volume(std::move(volume), mesh, work.ranks(), work.runner());
  };
  return run_mesh(model, options, host, take, ranks);
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
  std::ranges::sort(regions);
  regions.erase(std::unique(regions.begin(), regions.end()), regions.end());
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
