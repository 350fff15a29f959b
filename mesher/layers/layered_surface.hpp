#pragma once
// The surface that the volume has above the layers: tops in place of walls.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/layer_counts.hpp"
#include "mesher/layers/side_mesh.hpp"
#include "mesher/layers/walls.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom::layers {

/// What is to be filled. The points of `mesh` are those of the given surface mesh, the tops of curves that have layers,
/// and new points on side faces; its edges are pieces of model edges.
struct LayeredSurface {
  Mesh mesh;
  std::vector<FaceSides> tri_to_sides;                   ///< per triangle of `mesh`
  std::vector<std::uint8_t> is_top;                      ///< per triangle of `mesh`: it is none of the model's surface
  std::vector<std::uint32_t> tri_to_stack;               ///< of tops; else none. Those of one stack follow each other
  std::vector<ModelEntity> free_to_slide;                ///< per point: what it may slide on; none where it stays
  std::vector<std::array<std::uint32_t, 2>> kept_edges;  ///< that stay as they are
  std::vector<std::array<std::uint32_t, 3>> covered;     ///< wall triangles with nothing to fill at them
  std::vector<std::uint32_t> covered_to_entity;
  std::vector<std::uint32_t> curve_to_top;  ///< per curve a point of `mesh`; that of its foot where it has no layers
  std::vector<std::uint32_t> fan_to_apex;   ///< per element of a fan: a point of `mesh`, or none

  /// Refers to this.
  VolumeInput input(const GeometricModel& model, const SizeField& sizes) const;
};

/// The surface above the layers. `side_meshes` are those of all side faces on which layers stand.
LayeredSurface make_layered_surface(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls,
                                    const SideFaces& sides, const LayerCounts& counts,
                                    std::span<const SideMesh> side_meshes);

}  // namespace tetloom::layers
