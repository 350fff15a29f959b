#pragma once
// Layers in the parts of a volume: stacks go to the parts that have the tets on their tops.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/grow_layers.hpp"
#include "mesher/layers/point_numbers.hpp"
#include "tetloom/part_mesh.hpp"
#include "tetloom/partition.hpp"

namespace tetloom::layers {

/// Refers to `growth`. All members but the first may be called by several threads at once.
///
/// A part is lean as in VolumeParts when it comes. Its vertices have as global ids the numbers with which points are
/// made (PointNumbers) until `number_as_in_mesh`.
class PartLayers {
 public:
  /// `after_volume`: one past the last point that filling added, of all parts.
  PartLayers(const LayerGrowth& growth, std::uint64_t after_volume, bool all_tets);

  /// Takes the tops out of a part's triangles, and returns the stacks below them, ascending; each is in one part.
  std::vector<std::uint32_t> take_tops(PartMesh& part) const;
  /// Adds these stacks: vertices, cells, cell fields, and elements on walls and side faces. Pre:
  /// triangles have the model faces as their entities; cells are not connected.
  void add_stacks(std::span<const std::uint32_t> stacks, PartMesh& part) const;
  /// What a point lies on that is between foot and top of a curve; invalid for all others.
  ModelEntity entity_of(std::uint64_t made) const;
  /// Adds the pieces of model edges on which layers of the part stand.
  void add_edges(std::span<const std::uint32_t> stacks, PartMesh& part) const;
  /// Those of every part.
  static std::vector<FieldInfo> fields();
  /// Global ids become those of make_layered_mesh.
  void number_as_in_mesh(PartMesh& part) const;

 private:
  bool is_first_of_stack(std::uint32_t triangle) const;

  const LayerGrowth& growth_;
  const PointNumbers numbers_;
  const bool all_tets_;
  std::vector<std::uint32_t> wall_to_rim_;  // first rim of each wall triangle, in rims_; one longer than there are
  std::vector<std::uint32_t> rims_;         // by wall triangle
};

}  // namespace tetloom::layers
