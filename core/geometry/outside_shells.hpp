#pragma once
// Which faces of a model the space around it has.
#include <array>
#include <cstdint>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom {

/// Faces with the outside on one side, in shells that hang together through edges. Shells around voids, and shells in
/// other shells, do not meet the space around the model; facets tell, by volume and winding number. Faces that cannot
/// be facetted are left to whoever meshes them.
class OutsideShells {
 public:
  explicit OutsideShells(const GeometricModel& model);

  /// Whether the face meets the space around the model.
  bool has(std::uint32_t face) const { return shell_of_[face] != kNone && shells_[shell_of_[face]].is_outside; }

  /// The volume of the solids with such faces, of solids that share faces with them, and of voids in all these.
  double enclosed_volume() const;

 private:
  struct Shell {
    std::vector<std::array<Vec3, 3>> facets;  // normals out of the solid
    double volume = 0;                        // negative for voids
    Box3 box;
    std::uint32_t region = kNone;  // of one of its faces
    bool is_closed = true, is_outside = true;
  };

  ModelRegionId region_of(std::uint32_t face) const;
  void find_shells();
  void measure();
  void judge(Shell& shell);
  static double winding_number(const Shell& shell, const Vec3& point);

  const GeometricModel& model_;
  const ModelTopology& topology_;
  std::vector<Shell> shells_;
  std::vector<std::uint32_t> shell_of_;  // per face
};

}  // namespace tetloom
