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
  /// For `tet_count` tets that lie in `box`, which are added afterwards in their order, some at a time.
  StartGrid(const Box3& box, std::size_t tet_count);
  void add(const TetView& some);
  /// Pre: all tets have been added.
  void finish();

  std::uint32_t tet_near(const Vec3& x) const { return cell_to_tet_[cell_of(x)]; }

 private:
  std::size_t cell_of(const Vec3& x) const;

  Box3 box_;
  std::uint32_t added_ = 0;
  std::array<std::size_t, 3> cells_{1, 1, 1};  // along each axis
  std::vector<std::uint32_t> cell_to_tet_;
};

}  // namespace tetloom::adapt
