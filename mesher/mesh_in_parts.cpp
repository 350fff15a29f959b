#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>

#include "core/base/stopwatch.hpp"
#include "mesher/classify_parts.hpp"
#include "mesher/mesh_run_detail.hpp"
#include "tetloom/partition.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {
namespace {

constexpr const char* kWhy = "; only meshes of volumes can be dealt to parts";

Diagnostic refusal(const GeometricModel& model, const std::vector<ModelEntity>& entities, const std::string& what) {
  Diagnostic diagnostic{ErrorCode::InputUnsuitable, what + kWhy, {}, {}, {}};
  for (const ModelEntity entity : entities) diagnostic.entities.push_back({entity, model.attributes(entity).name});
  return diagnostic;
}

// Why the mesh of a model cannot be dealt to parts, which are of cells and what lies on them.
std::optional<Diagnostic> find_unsuitable(const GeometricModel& model) {
  const ModelTopology& topology = model.topology();
  if (topology.region_count() == 0) return refusal(model, {}, "the model has no solid");
  std::vector<ModelEntity> sheets, wires;
  std::vector<bool> bounds(topology.edge_count(), false);
  for (std::uint32_t f = 0; f < topology.face_count(); ++f) {
    const FaceSides& sides = topology.face_to_sides[f];
    if (!sides.front.valid() && !sides.back.valid()) {
      sheets.push_back({2, f});
      continue;
    }
    for (const ModelLoop& loop : topology.face_to_loops[f])
      for (const EdgeUse& use : loop) bounds[use.edge.value] = true;
  }
  if (!sheets.empty()) return refusal(model, sheets, "the model has faces that bound no solid");
  for (std::uint32_t e = 0; e < topology.edge_count(); ++e)
    if (!bounds[e] && !topology.edges[e].degenerate) wires.push_back({1, e});
  if (!wires.empty()) return refusal(model, wires, "the model has edges that bound no solid");
  return std::nullopt;
}

MeshInPartsResult refuse(const Diagnostic& diagnostic) {
  MeshInPartsResult result;
  result.run.errors.push_back(diagnostic);
  return result;
}

}  // namespace

MeshInPartsResult make_mesh_in_parts(const GeometricModel& model, const MeshOptions& options,
                                     Communicator& communicator, const Host& host) {
  if (options.surface_only)
    throw Error(ErrorCode::InvalidArgument, std::string("the surface alone was asked for") + kWhy);
  if (options.order != 1)
    throw Error(ErrorCode::InvalidArgument, "a mesh in parts is of first order, so order must be 1");
  if (const auto unsuitable = find_unsuitable(model)) return refuse(*unsuitable);
  MeshInPartsResult result;
  const auto make_parts = [&](VolumeParts&& volume, const Mesh& surface, const layers::PartLayers* layers,
                              const SharedWork& work) {
    const TaskRunner& runner = work.runner();
    Stopwatch watch;
    run_on_all(work.ranks(), [&] {
      runner.begin_stage(Stage::Partition, 0);
      runner.check_cancelled();
    });
    PartitionedMesh mesh = classify_parts(surface, std::move(volume.parts), volume.part_count, layers, work);
    if (options.parts > 0)
      deal_cells(mesh, {.part_count = static_cast<std::size_t>(options.parts), .weights = {}}, runner);
    result.partition_seconds = watch.lap();
    mesh.communicator = &communicator;
    result.mesh = std::move(mesh);
  };
  VolumeUse use;
  use.take = [&](VolumeParts&& volume, const Mesh& surface, const SharedWork& work) {
    make_parts(std::move(volume), surface, nullptr, work);
  };
  use.take_above_layers = [&](VolumeParts&& volume, const layers::LayerGrowth& growth, const Mesh& given,
                              const SharedWork& work) {
    Mesh surface = growth.surface().mesh;
    surface.entities = given.entities;
    surface.face_to_sides = given.face_to_sides;
    const layers::PartLayers layers(growth, volume.first_new + volume.new_points, options.layers.all_tets);
    make_parts(std::move(volume), surface, &layers, work);
    return 0.0;
  };
  result.run = run_mesh(model, options, host, use, &communicator);
  result.run.seconds.volume -= result.partition_seconds;
  return result;
}

}  // namespace tetloom
