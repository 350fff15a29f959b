#include <algorithm>
#include <cmath>

#include "core/sizing/block_corners.hpp"
#include "tetloom/error.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom {
namespace {

std::string validate_frame(const SizeOctree& tree) {
  if (!(std::isfinite(tree.size) && tree.size > 0)) return "the size is not positive";
  if (!(std::isfinite(tree.gradation) && tree.gradation >= 0)) return "the gradation is negative or not a number";
  if (!is_finite(tree.origin) || !(std::isfinite(tree.width) && tree.width > 0)) return "the cube is not finite";
  if (tree.domain.empty() || !is_finite(tree.domain.lo) || !is_finite(tree.domain.hi)) return "the domain is empty";
  const double slack = 1e-9 * (tree.width + norm(tree.origin));
  for (int axis = 0; axis < 3; ++axis)
    if (tree.domain.lo[axis] < tree.origin[axis] - slack ||
        tree.domain.hi[axis] > tree.origin[axis] + tree.width + slack)
      return "the domain leaves the cube";
  return {};
}

std::string validate_ratios(const SizeOctree& tree) {
  for (const float ratio : tree.corner_ratios)
    if (!(ratio > 0 && ratio <= 1)) return "a corner's ratio is outside (0, 1]";
  std::size_t first = 0;
  for (std::size_t block = 0; block < tree.cells.size(); block += 8) {
    for (std::size_t octant = 0; octant < 8; ++octant)
      if (is_sized_leaf(tree.cells[block + octant]) && tree.cells[block + octant] - SizeOctree::kLeafBit != first)
        return "a leaf refers to ratios that are not its block's";
    first += stored_corners(tree.cells.data() + block).count;
  }
  return first == tree.corner_ratios.size() ? "" : "there are more ratios than corners, or fewer";
}

}  // namespace

std::string validate_octree(const SizeOctree& tree) {
  if (std::string wrong = validate_frame(tree); !wrong.empty()) return wrong;
  if (tree.cells.empty() || tree.cells.size() % 8 != 0) return "the cells do not come in blocks of 8";
  if (tree.cells.size() >= SizeOctree::kLeafBit) return "there are too many cells";
  if (std::string wrong = validate_ratios(tree); !wrong.empty()) return wrong;
  const std::size_t block_count = tree.cells.size() / 8;
  std::vector<std::uint8_t> depth(block_count, 0);  // of a block's cells; 0 until its parent is met
  depth[0] = 1;
  for (std::size_t i = 0; i < tree.cells.size(); ++i) {
    const std::size_t block = i / 8;
    const std::uint32_t code = tree.cells[i];
    if (depth[block] == 0) return "a block has no parent before it";
    if (code >= SizeOctree::kLeafBit) continue;
    if (code >= block_count || code <= block || depth[code] != 0) return "a cell refers to a wrong child block";
    if (depth[block] >= SizeOctree::kMaxDepth) return "the tree is too deep";
    depth[code] = static_cast<std::uint8_t>(depth[block] + 1);
  }
  return {};
}

void set_corner_ratios(SizeOctree& tree, std::span<const std::array<float, 8>> leaf_to_ratios) {
  for (const std::uint32_t code : tree.cells)
    if (is_sized_leaf(code) && code - SizeOctree::kLeafBit >= leaf_to_ratios.size())
      throw Error(ErrorCode::InvalidArgument, "a leaf of the octree has no ratios");
  tree.corner_ratios.clear();
  for (std::size_t block = 0; block + 8 <= tree.cells.size(); block += 8) {
    std::uint32_t* const cells = tree.cells.data() + block;
    const StoredCorners& stored = stored_corners(cells);
    const std::size_t first = tree.corner_ratios.size();
    tree.corner_ratios.resize(first + stored.count, HUGE_VALF);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      if (!is_sized_leaf(cells[octant])) continue;
      const std::array<float, 8>& ratios = leaf_to_ratios[cells[octant] - SizeOctree::kLeafBit];
      for (std::size_t corner = 0; corner < 8; ++corner) {
        float& ratio = tree.corner_ratios[first + stored.places[octant][corner]];
        if (!(ratios[corner] >= ratio)) ratio = ratios[corner];
      }
      cells[octant] = SizeOctree::kLeafBit + static_cast<std::uint32_t>(first);
    }
  }
}

}  // namespace tetloom
