#include "core/sizing/size_tree.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/sizing/block_corners.hpp"

namespace tetloom {
namespace {

/// NaN goes to lo.
double clamp_into(double x, double lo, double hi) { return x > lo ? (x < hi ? x : hi) : lo; }

double mix(double a, double b, double t) { return a + t * (b - a); }

/// 2^-(kMaxDepth - depth): one over the width of a cell in finest cells.
constexpr std::array<double, SizeOctree::kMaxDepth + 1> kInverseWidth = [] {
  std::array<double, SizeOctree::kMaxDepth + 1> inverse{};
  double value = 1;
  for (int depth = SizeOctree::kMaxDepth; depth >= 0; --depth, value /= 2)
    inverse[static_cast<std::size_t>(depth)] = value;
  return inverse;
}();

}  // namespace

SizeField::Tree::Tree(SizeOctree octree)
    : cells_(std::exchange(octree.cells, {})),
      corner_ratios_(std::exchange(octree.corner_ratios, {})),
      scale_(kCells / octree.width) {
  frame_ = std::move(octree);
  top_depth_ = cells_.size() < (1u << 14) ? 4 : cells_.size() < (1u << 18) ? 5 : 6;
  std::vector<TopCell> top(std::size_t{1} << (3 * top_depth_));
  fill_top(0, 1, {0, 0, 0}, top);
  top_ = FixedArray(std::move(top));
}

void SizeField::Tree::move_arrays(const KeepBytes& keep) {
  cells_.move_to(keep);
  corner_ratios_.move_to(keep);
  top_.move_to(keep);
}

/// `corner`: of the parent of the block's cells, in cells of top_depth_.
void SizeField::Tree::fill_top(std::uint32_t block, std::uint32_t depth, const std::array<std::uint32_t, 3>& corner,
                               std::vector<TopCell>& top) const {
  const std::uint32_t width = 1u << (top_depth_ - depth);
  for (std::uint32_t octant = 0; octant < 8; ++octant) {
    const std::uint32_t cell = 8 * block + octant;
    std::uint32_t code = cells_[cell];
    const std::array<std::uint32_t, 3> lo{corner[0] + (octant & 1) * width, corner[1] + (octant >> 1 & 1) * width,
                                          corner[2] + (octant >> 2) * width};
    if (code < SizeOctree::kLeafBit && depth < top_depth_) {
      fill_top(code, depth + 1, lo, top);
      continue;
    }
    if (is_sized_leaf(code)) code = SizeOctree::kLeafBit + cell;
    for (std::uint32_t z = lo[2]; z < lo[2] + width; ++z)
      for (std::uint32_t y = lo[1]; y < lo[1] + width; ++y)
        for (std::uint32_t x = lo[0]; x < lo[0] + width; ++x)
          top[(z << top_depth_ | y) << top_depth_ | x] = {code, depth};
  }
}

/// Of a leaf with sizes of its own, between its corners: shares of its width.
double SizeField::Tree::interpolate(std::size_t cell, double x, double y, double z) const {
  const std::size_t octant = cell % 8;
  const float* of_block = corner_ratios_.data() + (cells_[cell] - SizeOctree::kLeafBit);
  const std::array<std::uint8_t, 8>& places = stored_corners(cells_.data() + (cell - octant)).places[octant];
  const auto at = [&](std::size_t corner) { return static_cast<double>(of_block[places[corner]]); };
  const double lower = mix(mix(at(0), at(1), x), mix(at(2), at(3), x), y);
  const double upper = mix(mix(at(4), at(5), x), mix(at(6), at(7), x), y);
  return frame_.size * mix(lower, upper, z);
}

double SizeField::Tree::size_at(const Vec3& x) const {
  const Box3& domain = frame_.domain;
  const Vec3 inside{clamp_into(x.x, domain.lo.x, domain.hi.x), clamp_into(x.y, domain.lo.y, domain.hi.y),
                    clamp_into(x.z, domain.lo.z, domain.hi.z)};
  const Vec3 local = (inside - frame_.origin) * scale_;
  std::array<std::uint32_t, 3> cell;
  for (int axis = 0; axis < 3; ++axis)
    cell[static_cast<std::size_t>(axis)] = static_cast<std::uint32_t>(clamp_into(local[axis], 0, kCells - 1));
  const std::uint32_t top_shift = kMaxDepth - top_depth_;
  auto [code, depth] =
      top_[((cell[2] >> top_shift) << top_depth_ | cell[1] >> top_shift) << top_depth_ | cell[0] >> top_shift];
  if (code == SizeOctree::kGlobalLeaf) return frame_.size;
  std::size_t leaf = code - SizeOctree::kLeafBit;
  while (code < SizeOctree::kLeafBit) {
    const std::uint32_t shift = kMaxDepth - ++depth;
    const std::uint32_t octant = (cell[0] >> shift & 1) | (cell[1] >> shift & 1) << 1 | (cell[2] >> shift & 1) << 2;
    leaf = 8 * std::size_t{code} + octant;
    code = cells_[leaf];
    if (code == SizeOctree::kGlobalLeaf) return frame_.size;
  }
  const std::uint32_t mask = ~((1u << (kMaxDepth - depth)) - 1);
  const double to_unit = kInverseWidth[depth];
  const double size = interpolate(leaf, (local.x - (cell[0] & mask)) * to_unit, (local.y - (cell[1] & mask)) * to_unit,
                                  (local.z - (cell[2] & mask)) * to_unit);
  if (inside == x) return size;
  const double beyond = distance(x, inside);
  return beyond >= 0 ? std::min(frame_.size, size + frame_.gradation * beyond) : size;
}

void SizeField::Tree::for_each_leaf(const Box3& box, const std::function<void(const SizeLeaf&)>& visit) const {
  const auto walk = [&](const auto& self, std::uint32_t block, const Vec3& origin, double width) -> void {
    for (std::uint32_t octant = 0; octant < 8; ++octant) {
      const Vec3 lo = origin + width * Vec3{double(octant & 1), double(octant >> 1 & 1), double(octant >> 2)};
      const Box3 cell{lo, lo + Vec3{width, width, width}};
      if (!cell.overlaps(box)) continue;
      const std::size_t at_leaf = 8 * std::size_t{block} + octant;
      const std::uint32_t code = cells_[at_leaf];
      if (code < SizeOctree::kLeafBit) {
        self(self, code, lo, width / 2);
        continue;
      }
      SizeLeaf leaf{cell, frame_.size};
      for (int axis = 0; axis < 3; ++axis) {
        leaf.box.lo[axis] = std::max(cell.lo[axis], box.lo[axis]);
        leaf.box.hi[axis] = std::min(cell.hi[axis], box.hi[axis]);
      }
      if (code != SizeOctree::kGlobalLeaf) {
        const Vec3 at = (leaf.box.center() - cell.lo) / width;
        leaf.size = interpolate(at_leaf, at.x, at.y, at.z);
      }
      visit(leaf);
    }
  };
  walk(walk, 0, frame_.origin, frame_.width / 2);
}

std::size_t SizeField::Tree::leaf_count() const {
  return cells_.size() - (cells_.size() / 8 - 1);  // every block but the first hangs on one cell
}

std::size_t SizeField::Tree::memory() const {
  return sizeof(Tree) + cells_.size() * sizeof(cells_[0]) + corner_ratios_.size() * sizeof(corner_ratios_[0]) +
         top_.size() * sizeof(TopCell);
}

}  // namespace tetloom
