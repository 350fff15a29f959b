#include "tetloom/size_field.hpp"

#include <cmath>

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
  for (const auto& ratios : tree.corner_ratios)
    for (const float ratio : ratios)
      if (!(ratio > 0 && ratio <= 1)) return "a corner's ratio is outside (0, 1]";
  return {};
}

}  // namespace

std::string validate_octree(const SizeOctree& tree) {
  if (std::string wrong = validate_frame(tree); !wrong.empty()) return wrong;
  if (std::string wrong = validate_ratios(tree); !wrong.empty()) return wrong;
  if (tree.cells.empty() || tree.cells.size() % 8 != 0) return "the cells do not come in blocks of 8";
  const std::size_t block_count = tree.cells.size() / 8;
  if (block_count >= SizeOctree::kLeafBit) return "there are too many blocks";
  std::vector<std::uint8_t> depth(block_count, 0);  // of a block's cells; 0 until its parent is met
  depth[0] = 1;
  std::vector<bool> leaf_met(tree.corner_ratios.size(), false);
  for (std::size_t i = 0; i < tree.cells.size(); ++i) {
    const std::size_t block = i / 8;
    const std::uint32_t code = tree.cells[i];
    if (depth[block] == 0) return "a block has no parent before it";
    if (code == SizeOctree::kGlobalLeaf) continue;
    if (code >= SizeOctree::kLeafBit) {
      const std::uint32_t leaf = code - SizeOctree::kLeafBit;
      if (leaf >= leaf_met.size() || leaf_met[leaf]) return "a leaf refers to ratios that are missing or taken";
      leaf_met[leaf] = true;
      continue;
    }
    if (code >= block_count || code <= block || depth[code] != 0) return "a cell refers to a wrong child block";
    if (depth[block] >= SizeOctree::kMaxDepth) return "the tree is too deep";
    depth[code] = static_cast<std::uint8_t>(depth[block] + 1);
  }
  for (const bool met : leaf_met)
    if (!met) return "ratios belong to no leaf";
  return {};
}

}  // namespace tetloom
