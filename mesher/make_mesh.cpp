#include <algorithm>

#include "core/base/page_size.hpp"
#include "mesher/mesh_run_detail.hpp"
#include "mesher/volume/fill_over_given.hpp"
#include "mesher/volume/gather_volume.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kPointsPerTask = 1 << 16;

// The points of `volume` begin with those of the mesh.
void add_volume(const GeometricModel& model, VolumeMesh&& volume, const TaskRunner& runner, Mesh& mesh) {
  const std::size_t given = mesh.points.size();
  for (const MovedPoint& moved : volume.moved_points) mesh.points[moved.point] = moved.to;
  for (const ChangedTriangle& changed : volume.changed_triangles) mesh.tri_to_vert[changed.triangle] = changed.verts;
  std::ranges::copy(mesh.points, volume.new_points.begin());
  mesh.points = std::move(volume.new_points);
  reserve_touched(mesh.point_to_entity, mesh.points.size(), runner);
  mesh.point_to_entity.resize(mesh.points.size());
  mesh.tet_to_vert = std::move(volume.tet_to_vert);
  mesh.tet_to_entity = std::move(volume.tet_to_region);
  if (model.topology().region_count() == 1) {
    runner.for_blocks(mesh.points.size() - given, kPointsPerTask, [&](std::size_t begin, std::size_t end) {
      for (std::size_t v = begin; v < end; ++v) mesh.point_to_entity[given + v] = ModelRegionId(0);
    });
    return;
  }
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t)
    for (const std::uint32_t v : mesh.tet_to_vert[t])
      if (v >= given) mesh.point_to_entity[v] = ModelRegionId(mesh.tet_to_entity[t]);
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
  return run_mesh(model, options, host,
                  [&](const VolumeInput& input, const VolumeOptions& how, const SharedWork& work, Mesh& mesh) {
                    VolumeMesh volume = fill_over_given(input, how, work.runner());
                    FillingReport report{std::move(volume.errors), std::move(volume.warnings), volume.figures};
                    const TraceSpan span(how.trace, "mesh");
                    if (report.errors.empty()) add_volume(model, std::move(volume), work.runner(), mesh);
                    return report;
                  });
}

MeshResult make_mesh_on_ranks(const GeometricModel& model, const MeshOptions& options, Communicator& communicator,
                              const Host& host) {
  if (communicator.rank_count() == 1) return make_mesh(model, options, host);
  const auto fill = [&](const VolumeInput& input, const VolumeOptions& how, const SharedWork& work, Mesh& mesh) {
    VolumeParts parts = fill_volume_in_parts(input, how, work.ranks(), work.runner());
    VolumeMesh volume = gather_volume(input, std::move(parts), work.ranks(), work.runner());
    FillingReport report{std::move(volume.errors), std::move(volume.warnings), volume.figures};
    run_on_first(work.ranks(), [&] {
      if (report.errors.empty()) add_volume(model, std::move(volume), work.runner(), mesh);
    });
    return report;
  };
  return run_mesh(model, options, host, fill, &communicator);
}

}  // namespace tetloom
