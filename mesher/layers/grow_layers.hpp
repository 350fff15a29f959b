#pragma once
// Boundary layers between the surface mesh of a model and what fills the rest of its regions.
//
// After Garimella & Shephard (2000): growth curves from the vertices of walls, layers of prisms between them.
// Departures: a curve has a number of layers of its own, and where two neighbours differ, pyramids and tets lie beside
// the prisms, so that nothing has to be made to fit; counts are lowered instead of heights; curves follow the front in
// steps; and what comes out is proven: all cells are positive in exact arithmetic however they are split, and walls,
// tops and side faces do not cross by the exact test that the surface has passed before. Both together mean that no two
// cells overlap.
#include <memory>
#include <optional>
#include <span>

#include "mesher/layers/growth_paths.hpp"
#include "mesher/layers/layered_surface.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// The layers of one run. Refers to its arguments.
class LayerGrowth {
 public:
  /// Grows all layers. Pre: the surface mesh does not cross itself. Errors: Cancelled, OutOfMemory.
  LayerGrowth(const GeometricModel& model, const Mesh& mesh, const SizeField& sizes, const LayerOptions& options,
              const TaskRunner& runner);
  ~LayerGrowth();

  const GeometricModel& model() const { return model_; }
  const Mesh& given() const { return mesh_; }  ///< the surface mesh
  const LayeredSurface& surface() const { return surface_; }
  const Walls& walls() const { return walls_; }
  const SideFaces& sides() const { return *sides_; }
  const LayerCounts& counts() const { return *counts_; }

  /// Leaves so much of the layers of some regions, where they could not be filled, and makes the surface anew. False
  /// where there are none left to be lowered. Errors: Cancelled, OutOfMemory.
  bool lower(std::span<const std::uint32_t> regions, double share);

 private:
  // Of a try at which fans were too thin.
  struct Grown {
    Walls walls;
    GrowthPaths paths;
    std::vector<KeptCount> counts;  // per curve; empty: no layers were counted
    std::vector<CurveTop> tops;     // per curve, if nothing crossed between them; else empty
  };

  std::vector<std::uint32_t> grow(int tries);
  std::vector<std::uint32_t> settle(int tries, std::span<const std::uint32_t> kept);
  std::vector<KeptCount> kept_counts(std::span<const std::uint32_t> kept) const;
  std::vector<std::uint32_t> thin_fans() const;
  std::vector<std::uint8_t> is_proven(std::span<const std::uint32_t> kept) const;
  void make_surface(std::span<const std::uint8_t> is_proven = {});
  void make_side_meshes(std::vector<std::uint8_t>& changed, std::vector<int>& hits);
  bool lower_at_crossings(const std::vector<std::uint8_t>& changed, std::vector<int>& hits);
  bool lower_where_room_lacks(std::vector<std::uint8_t>& unseen);
  bool lower_hit(const std::vector<std::uint8_t>& is_hit, std::vector<int>& hits, LayerLimit limit);
  std::vector<CurveTop> tops() const;

  const GeometricModel& model_;
  const Mesh& mesh_;
  const SizeField& sizes_;
  const LayerOptions& options_;
  const TaskRunner& runner_;
  std::optional<Grown> before_;             // while fans are tried
  std::vector<std::uint32_t> blunt_verts_;  // where fans were tried and failed, ascending
  Walls walls_;
  std::optional<SideFaces> sides_;
  std::optional<LayerCounts> counts_;
  std::vector<std::optional<SideMesh>> side_meshes_;  // per side face, where layers stand on it
  LayeredSurface surface_;
};

/// Errors: InvalidArgument with the face, for walls that cannot be made: unknown faces, heights, growth or counts out
/// of range, faces that bound no region on the sides asked for; and without one for an angle of fans out of range.
void check_layer_options(const GeometricModel& model, const LayerOptions& options);

}  // namespace tetloom::layers
