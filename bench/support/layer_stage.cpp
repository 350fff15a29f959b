#include "bench/support/layer_stage.hpp"

#include <fstream>

#include "bench/support/machine.hpp"
#include "core/base/stopwatch.hpp"
#include "mesher/layers/grow_layers.hpp"
#include "mesher/layers/layered_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

namespace tetloom::bench {
namespace {

LayerOptions on_all_walls(const GeometricModel& model, const LayerStageTask& task) {
  LayerOptions options;
  for (std::uint32_t f = 0; f < model.topology().face_count(); ++f) {
    const FaceSides& sides = model.topology().face_to_sides[f];
    if (!sides.front.valid() && !sides.back.valid()) continue;
    WallLayers wall;
    wall.face = ModelFaceId(f);
    wall.first_height = task.first_height, wall.growth = task.growth, wall.count = task.count;
    options.walls.push_back(wall);
  }
  return options;
}

template <class T>
std::uint64_t bytes_of(const std::vector<T>& items) {
  return items.size() * sizeof(T);
}

std::uint64_t bytes_of_cells(const Mesh& mesh) {
  std::uint64_t bytes = bytes_of(mesh.tet_to_vert) + bytes_of(mesh.tet_to_entity) + bytes_of(mesh.pyramid_to_vert) +
                        bytes_of(mesh.pyramid_to_entity) + bytes_of(mesh.prism_to_vert) +
                        bytes_of(mesh.prism_to_entity) + bytes_of(mesh.hex_to_vert) + bytes_of(mesh.hex_to_entity) +
                        bytes_of(mesh.points) + bytes_of(mesh.point_to_entity);
  for (const MeshField& field : mesh.cell_fields) bytes += bytes_of(field.values);
  return bytes;
}

// Linux: the largest resident set is counted anew from here.
void forget_peak() { std::ofstream("/proc/self/clear_refs") << "5"; }

}  // namespace

LayerStageSample measure_layer_stage(const LayerStageTask& task) {
  const ModelDocument document = read_model(task.model);
  MeshOptions options;
  options.sizes.size = task.edge;
  options.threads = task.threads;
  options.surface_only = true;
  const MeshResult surface = make_mesh(*document.model, options);
  if (surface.status != MeshStatus::Ok) throw Error(surface.errors.at(0));
  const TaskRunner runner(task.threads);
  LayerStageSample sample;
  forget_peak();
  const std::uint64_t before = resident_bytes();
  Stopwatch watch;
  const layers::LayerGrowth growth(*document.model, surface.mesh, surface.sizes, on_all_walls(*document.model, task),
                                   runner);
  sample.grow = watch.lap();
  Mesh above = growth.surface().mesh;
  watch.lap();
  const Mesh mesh = layers::make_layered_mesh(growth, surface.mesh, std::move(above), false, runner);
  sample.write = watch.lap();
  sample.cells = mesh.tet_to_vert.size() + mesh.pyramid_to_vert.size() + mesh.prism_to_vert.size();
  sample.result_bytes = bytes_of_cells(mesh);
  sample.peak_bytes = peak_resident_bytes() - before;
  sample.digest = mesh_digest(mesh, runner);
  return sample;
}

}  // namespace tetloom::bench
