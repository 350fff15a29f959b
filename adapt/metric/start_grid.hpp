#pragma once
// A tet near any place of a mesh: where to begin to look without a hint.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/metric.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::adapt {

/// About 4 tets for each cell of a grid over the mesh, and a tet in or near each cell. Immutable.
class StartGrid {
 public:
  StartGrid() = default;
  /// Pre: at least one tet. Linear.
  explicit StartGrid(const TetView& mesh);

  std::uint32_t tet_near(const Vec3& x) const { return cell_to_tet_[cell_of(x)]; }

 private:
  void choose_cells(std::size_t tet_count);
  void fill_empty_cells();
  std::size_t cell_of(const Vec3& x) const;

  Box3 box_;
  std::array<std::size_t, 3> cells_{1, 1, 1};  // along each axis
  std::vector<std::uint32_t> cell_to_tet_;
};

}  // namespace tetloom::adapt
