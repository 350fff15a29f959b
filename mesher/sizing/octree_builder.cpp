#include "mesher/sizing/octree_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/assert.hpp"
#include "core/sizing/morton.hpp"
#include "threading/parallel_sort.hpp"

namespace tetloom {
namespace {

constexpr int kMaxDepth = SizeOctree::kMaxDepth;
constexpr int kCallbackDepth = 4;  // features of a callback are looked for on a grid of 2 * 2^4 + 1 points

/// The parents of all neighbours of a cell: for the octant o of its own parent these lie in the directions of o.
void append_neighbour_parents(std::uint64_t code, int level, std::vector<std::uint64_t>& out) {
  const std::array<std::uint32_t, 3> cell = morton_decode(code);
  const std::uint32_t end = 1u << (level - 1);
  for (std::uint32_t mask = 0; mask < 8; ++mask) {
    std::array<std::uint32_t, 3> parent;
    bool inside = true;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const std::uint32_t step = (mask >> axis & 1) == 0 ? 0 : (cell[axis] & 1) != 0 ? 1u : ~0u;
      parent[axis] = (cell[axis] >> 1) + step;
      inside = inside && parent[axis] < end;
    }
    if (inside) out.push_back(morton_encode(parent));
  }
}

}  // namespace

OctreeBuilder::OctreeBuilder(const TargetField& field, const Box3& domain, std::size_t max_cells,
                             const SharedWork& work)
    : field_(field), domain_(domain), max_cells_(max_cells), work_(work), runner_(work.runner()) {
  const Vec3 extent = domain.hi - domain.lo;
  const double least = 1.001 * std::max({extent.x, extent.y, extent.z});
  // Where the smallest size is asked for lie most leaves: let a level have just the width that they need.
  const double finest = 0.9999 * field.finest_width();
  width_ = std::ldexp(finest, static_cast<int>(std::ceil(std::log2(least / finest))));
  origin_ = domain.center() - Vec3{0.5 * width_, 0.5 * width_, 0.5 * width_};
}

Box3 OctreeBuilder::box_of(std::uint64_t code, int level) const {
  const std::array<std::uint32_t, 3> cell = morton_decode(code);
  const double width = std::ldexp(width_, -level);
  const Vec3 lo = origin_ + width * Vec3{double(cell[0]), double(cell[1]), double(cell[2])};
  return {lo, lo + Vec3{width, width, width}};
}

std::vector<std::uint64_t> OctreeBuilder::cuts_of(const std::vector<Cell>& cells) const {
  constexpr std::size_t kBlock = 8192;
  std::vector<std::size_t> first((cells.size() + kBlock - 1) / kBlock + 1, 0);
  const auto for_each_cut = [&](std::size_t begin, std::size_t end, const auto& visit) {
    for (std::size_t i = begin; i < end; ++i)
      if (cells[i].verdict == CellVerdict::Split) visit(cells[i].code);
  };
  runner_.for_blocks(cells.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for_each_cut(begin, end, [&](std::uint64_t) { ++first[begin / kBlock + 1]; });
  });
  for (std::size_t block = 1; block < first.size(); ++block) first[block] += first[block - 1];
  std::vector<std::uint64_t> cuts(first.back());
  runner_.for_blocks(cells.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    std::size_t next = first[begin / kBlock];
    for_each_cut(begin, end, [&](std::uint64_t code) { cuts[next++] = code; });
  });
  return cuts;
}

/// `cuts`: of the cells.
std::vector<OctreeBuilder::Cell> OctreeBuilder::children_of(const std::vector<Cell>& cells,
                                                            const std::vector<std::uint64_t>& cuts) const {
  std::vector<Cell> children(8 * cuts.size());
  runner_.for_blocks(cuts.size(), 1024, [&](std::size_t begin, std::size_t end) {
    auto cell = std::ranges::lower_bound(cells, cuts[begin], {}, &Cell::code);
    for (std::size_t i = begin; i < end; ++i) {
      while (cell->code != cuts[i]) ++cell;
      for (std::uint64_t octant = 0; octant < 8; ++octant)
        children[8 * i + octant] = {cell->code << 3 | octant, cell->state, CellVerdict::Global};
    }
  });
  return children;
}

void OctreeBuilder::judge(std::vector<Cell>& cells, int level) const {
  const bool search = field_.may_be_steep() && level < kCallbackDepth;
  work_.fill<Cell>(cells, 512, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Box3 box = box_of(cells[i].code, level);
      if (!box.overlaps(domain_)) continue;
      cells[i].verdict = field_.classify(box.center(), box.hi.x - box.lo.x, cells[i].state);
      if (search) cells[i].verdict = CellVerdict::Split;
      if (level == 0) cells[i].verdict = CellVerdict::Split;  // block 0 always exists
      if (level == kMaxDepth && cells[i].verdict == CellVerdict::Split) cells[i].verdict = CellVerdict::Leaf;
    }
  });
}

/// A cell may be cut only where all its neighbours exist, so their parents are cut too.
void OctreeBuilder::balance() {
  for (std::size_t level = cuts_.size() - 1; level > 1; --level) {
    std::vector<std::uint64_t>& coarser = cuts_[level - 1];
    append_parents(static_cast<int>(level), coarser);
    parallel_sort_unique(coarser, runner_);
  }
}

/// Appends the parents of all neighbours of the cuts of a level; what one block finds twice it tells once.
void OctreeBuilder::append_parents(int level, std::vector<std::uint64_t>& coarser) const {
  constexpr std::size_t kBlock = 2048;
  const std::vector<std::uint64_t>& cuts = cuts_[static_cast<std::size_t>(level)];
  std::vector<std::vector<std::uint64_t>> blocks((cuts.size() + kBlock - 1) / kBlock);
  runner_.for_blocks(cuts.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint64_t>& parents = blocks[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i) append_neighbour_parents(cuts[i], level, parents);
    std::ranges::sort(parents);
    parents.erase(std::unique(parents.begin(), parents.end()), parents.end());
  });
  for (const auto& parents : blocks) coarser.insert(coarser.end(), parents.begin(), parents.end());
}

/// Rebuilds the levels from the balanced cuts; children that nobody judged are like their parent.
void OctreeBuilder::adopt_cuts() {
  std::size_t total = 0;
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    std::vector<Cell>& cells = levels_[level];
    const std::vector<std::uint64_t> no_cuts;
    const std::vector<std::uint64_t>& cuts = level < cuts_.size() ? cuts_[level] : no_cuts;
    std::vector<Cell> children;
    children.reserve(8 * cuts.size());
    const std::vector<Cell> no_cells;
    const std::vector<Cell>& judged = level + 1 < levels_.size() ? levels_[level + 1] : no_cells;
    std::size_t cut = 0, known = 0;
    for (Cell& cell : cells) {
      if (cut == cuts.size() || cuts[cut] != cell.code) continue;
      ++cut;
      for (std::uint64_t octant = 0; octant < 8; ++octant) {
        const std::uint64_t code = cell.code << 3 | octant;
        while (known < judged.size() && judged[known].code < code) ++known;
        if (known < judged.size() && judged[known].code == code)
          children.push_back(judged[known]);
        else
          children.push_back({code, cell.state, cell.verdict});
      }
      cell.verdict = CellVerdict::Split;
    }
    TETLOOM_ASSERT(cut == cuts.size());
    if (level + 1 < levels_.size()) levels_[level + 1] = std::move(children);
    total += cells.size();
  }
  if (total > max_cells_) throw Error(ErrorCode::OutOfMemory, "the balanced size field does not fit in memory");
}

/// Depth first: numbers the blocks, and puts the leaves that need sizes in Morton order.
SizeOctree OctreeBuilder::pack(std::vector<OctreeLeaf>& leaves) const {
  std::vector<std::vector<std::uint32_t>> first_child(levels_.size());
  for (std::size_t level = 0; level < levels_.size(); ++level) {
    std::uint32_t next = 0;
    for (const Cell& cell : levels_[level]) {
      first_child[level].push_back(next);
      if (cell.verdict == CellVerdict::Split) next += 8;
    }
  }
  SizeOctree tree;
  const auto emit = [&](const auto& self, std::size_t level, std::size_t first) -> std::uint32_t {
    const auto block = static_cast<std::uint32_t>(tree.cells.size() / 8);
    tree.cells.resize(tree.cells.size() + 8, SizeOctree::kGlobalLeaf);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const Cell& cell = levels_[level][first + octant];
      std::uint32_t code = SizeOctree::kGlobalLeaf;
      if (cell.verdict == CellVerdict::Split) {
        code = self(self, level + 1, first_child[level][first + octant]);
      } else if (cell.verdict == CellVerdict::Leaf) {
        code = SizeOctree::kLeafBit + static_cast<std::uint32_t>(leaves.size());
        const int shift = kMaxDepth - static_cast<int>(level);
        std::array<std::uint32_t, 3> corner = morton_decode(cell.code);
        for (std::uint32_t& c : corner) c <<= shift;
        leaves.push_back({corner, 1u << shift});
      }
      tree.cells[8 * std::size_t{block} + octant] = code;
    }
    return block;
  };
  emit(emit, 1, 0);
  tree.origin = origin_;
  tree.width = width_;
  tree.domain = domain_;
  tree.size = field_.global();
  tree.gradation = field_.gradation();
  return tree;
}

SizeOctree OctreeBuilder::build(std::vector<OctreeLeaf>& leaves) {
  std::vector<Cell> cells{{0, {}, CellVerdict::Split}};
  std::size_t total = 0;
  for (int level = 0; !cells.empty(); ++level) {
    total += cells.size();
    if (total > max_cells_)
      throw Error(ErrorCode::OutOfMemory, "the size field would need more than " + std::to_string(max_cells_) +
                                              " cells, which do not fit in memory; ask for larger sizes");
    judge(cells, level);
    cuts_.push_back(cuts_of(cells));
    std::vector<Cell> next = children_of(cells, cuts_.back());
    levels_.push_back(std::move(cells));
    cells = std::move(next);
  }
  balance();
  adopt_cuts();
  return pack(leaves);
}

}  // namespace tetloom
