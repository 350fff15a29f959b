#include "mesher/sizing/octree_builder.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/lists.hpp"
#include "core/sizing/block_corners.hpp"
#include "core/spatial/morton.hpp"
#include "tetloom/assert.hpp"
#include "threading/runtime/parallel_sort.hpp"

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

/// About how many leaves lie beside the sources when leaves have the widths 2^(phase - n), at `widest` sizes.
double leaves_beside(std::span<const SizeSource> sources, double widest, double phase) {
  double leaves = 0;
  for (const SizeSource& source : sources) {
    const double width = std::exp2(std::floor(std::log2(widest * source.size) - phase) + phase);
    const double area = 0.5 * norm(cross(source.b - source.a, source.c - source.a));
    leaves += area / (width * width) + distance(source.a, source.b) / width + 1;
  }
  return leaves;
}

}  // namespace

OctreeFrame fit_frame(const Box3& domain, std::span<const SizeSource> sources, double width_at_source) {
  constexpr int kPhases = 32;
  constexpr std::size_t kSamples = 4096;
  const Vec3 extent = domain.hi - domain.lo;
  const double least = std::log2(1.001 * std::max({extent.x, extent.y, extent.z}));
  std::vector<SizeSource> samples;
  for (std::size_t i = 0; i < sources.size(); i += 1 + sources.size() / kSamples) samples.push_back(sources[i]);
  double best = least, fewest = HUGE_VAL;
  for (int i = 0; i < kPhases; ++i) {
    const double phase = least + static_cast<double>(i) / kPhases;
    const double leaves = leaves_beside(samples, width_at_source, phase);
    if (leaves < fewest) best = phase, fewest = leaves;
  }
  const double width = std::exp2(best);
  return {domain.center() - Vec3{0.5 * width, 0.5 * width, 0.5 * width}, width};
}

OctreeBuilder::OctreeBuilder(const TargetField& field, const OctreeFrame& frame, const Box3& domain,
                             std::size_t max_cells, const SharedWork& work)
    : field_(field), frame_(frame), domain_(domain), max_cells_(max_cells), work_(work), runner_(work.runner()) {}

Box3 OctreeBuilder::box_of(std::uint64_t code, int level) const {
  const std::array<std::uint32_t, 3> cell = morton_decode(code);
  const double width = std::ldexp(frame_.width, -level);
  const Vec3 lo = frame_.origin + width * Vec3{double(cell[0]), double(cell[1]), double(cell[2])};
  return {lo, lo + Vec3{width, width, width}};
}

OctreeBuilder::Codes OctreeBuilder::cuts_of(const std::vector<OctreeCell>& cells) const {
  constexpr std::size_t kBlock = 8192;
  std::vector<std::size_t> first((cells.size() + kBlock - 1) / kBlock + 1, 0);
  const auto for_each_cut = [&](std::size_t begin, std::size_t end, const auto& visit) {
    for (std::size_t i = begin; i < end; ++i)
      if (cells[i].judged.verdict == CellVerdict::Split) visit(cells[i].code);
  };
  runner_.for_blocks(cells.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for_each_cut(begin, end, [&](std::uint64_t) { ++first[begin / kBlock + 1]; });
  });
  for (std::size_t block = 1; block < first.size(); ++block) first[block] += first[block - 1];
  Codes cuts(first.back());
  runner_.for_blocks(cells.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    std::size_t next = first[begin / kBlock];
    for_each_cut(begin, end, [&](std::uint64_t code) { cuts[next++] = code; });
  });
  return cuts;
}

OctreeBuilder::JudgedLevel OctreeBuilder::verdicts_on(const std::vector<OctreeCell>& cells) const {
  JudgedLevel level{cuts_of(cells), std::vector<CellVerdict>(cells.size())};
  runner_.for_blocks(cells.size(), 8192, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) level.verdicts[i] = cells[i].judged.verdict;
  });
  return level;
}

/// `cuts`: of the cells.
std::vector<OctreeCell> OctreeBuilder::children_of(const std::vector<OctreeCell>& cells, const Codes& cuts) const {
  std::vector<OctreeCell> children(8 * cuts.size());
  runner_.for_blocks(cuts.size(), 1024, [&](std::size_t begin, std::size_t end) {
    auto cell = std::ranges::lower_bound(cells, cuts[begin], {}, &OctreeCell::code);
    for (std::size_t i = begin; i < end; ++i) {
      while (cell->code != cuts[i]) ++cell;
      for (std::uint64_t octant = 0; octant < 8; ++octant)
        children[8 * i + octant] = {cell->code << 3 | octant, {cell->judged.state, CellVerdict::Global}};
    }
  });
  return children;
}

/// `before`: the same level of an earlier build.
void OctreeBuilder::judge(std::vector<OctreeCell>& cells, int level, std::span<const OctreeCell> before) const {
  const bool search = field_.may_be_steep() && level < kCallbackDepth;
  const auto owner_of = [&](std::size_t i) { return rank_at(cells[i].code, level, work_.rank_count()); };
  work_.fill<OctreeCell>(cells, 512, owner_of, [&](std::size_t begin, std::size_t end) {
    auto known = std::ranges::lower_bound(before, cells[begin].code, {}, &OctreeCell::code);
    for (std::size_t i = begin; i < end; ++i) {
      const Box3 box = box_of(cells[i].code, level);
      if (!box.overlaps(domain_)) continue;
      while (known != before.end() && known->code < cells[i].code) ++known;
      const bool met = known != before.end() && known->code == cells[i].code;
      JudgedCell& judged = cells[i].judged;
      judged.verdict = field_.classify(box.center(), box.hi.x - box.lo.x, met ? &known->judged : nullptr, judged.state);
      if (search) judged.verdict = CellVerdict::Split;
      if (level == 0) judged.verdict = CellVerdict::Split;  // block 0 always exists
      if (level == kMaxDepth && judged.verdict == CellVerdict::Split) judged.verdict = CellVerdict::Leaf;
    }
  });
}

/// A cell may be cut only where all its neighbours exist, so their parents are cut too.
void OctreeBuilder::balance(std::vector<Codes>& cuts) const {
  for (std::size_t level = cuts.size() - 1; level > 1; --level) {
    append_parents(static_cast<int>(level), cuts[level], cuts[level - 1]);
    parallel_sort_unique(cuts[level - 1], runner_);
  }
}

/// Appends the parents of all neighbours of the cuts of a level; what one block finds twice it tells once.
void OctreeBuilder::append_parents(int level, const Codes& cuts, Codes& coarser) const {
  constexpr std::size_t kBlock = 2048;
  std::vector<Codes> blocks((cuts.size() + kBlock - 1) / kBlock);
  runner_.for_blocks(cuts.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    Codes& parents = blocks[begin / kBlock];
    for (std::size_t i = begin; i < end; ++i) append_neighbour_parents(cuts[i], level, parents);
    sort_unique(parents);
  });
  for (const auto& parents : blocks) coarser.insert(coarser.end(), parents.begin(), parents.end());
}

/// The cells that balanced cuts make; children that nobody judged are like their parent.
OctreeBuilder::PlacedLevels OctreeBuilder::place(const std::vector<JudgedLevel>& levels,
                                                 const std::vector<Codes>& cuts) const {
  PlacedLevels placed(levels.size());
  placed[0] = {{0, CellVerdict::Split}};
  std::size_t total = 1;
  for (std::size_t level = 0; level + 1 < levels.size(); ++level) {
    const Codes& judged = levels[level].cuts;
    std::size_t known = 0;
    auto cut = cuts[level].begin();
    placed[level + 1].reserve(8 * cuts[level].size());
    for (PlacedCell& cell : placed[level]) {
      if (cut == cuts[level].end() || *cut != cell.code) continue;
      ++cut;
      while (known < judged.size() && judged[known] < cell.code) ++known;
      const bool is_judged = known < judged.size() && judged[known] == cell.code;
      for (std::uint64_t octant = 0; octant < 8; ++octant)
        placed[level + 1].push_back(
            {cell.code << 3 | octant, is_judged ? levels[level + 1].verdicts[8 * known + octant] : cell.verdict});
      cell.verdict = CellVerdict::Split;
    }
    TETLOOM_ASSERT(cut == cuts[level].end());
    total += placed[level + 1].size();
  }
  if (total > max_cells_) throw Error(ErrorCode::OutOfMemory, "the balanced size field does not fit in memory");
  return placed;
}

/// Depth first: numbers the blocks, and says where the ratios of each one's leaves begin.
SizeOctree OctreeBuilder::pack(const PlacedLevels& levels, std::vector<OctreeBlock>& blocks) const {
  std::vector<std::size_t> next_child(levels.size(), 0);  // depth first, the blocks of a level come in order
  SizeOctree tree;
  std::size_t cells = 0, ratios = 0;
  for (const std::vector<PlacedCell>& level : levels) cells += level.size();
  tree.cells.reserve(cells - 1);
  const auto emit = [&](const auto& self, std::size_t level) -> std::uint32_t {
    const std::size_t block = tree.cells.size();
    tree.cells.resize(block + 8, SizeOctree::kGlobalLeaf);
    const std::span<const PlacedCell> placed = std::span(levels[level]).subspan(next_child[level], 8);
    next_child[level] += 8;
    for (std::size_t octant = 0; octant < 8; ++octant)
      if (placed[octant].verdict == CellVerdict::Leaf)
        tree.cells[block + octant] = SizeOctree::kLeafBit + static_cast<std::uint32_t>(ratios);
    if (const std::size_t stored = stored_corners(tree.cells.data() + block).count; stored > 0) {
      const int shift = kMaxDepth - static_cast<int>(level);
      std::array<std::uint32_t, 3> corner = morton_decode(placed[0].code);
      for (std::uint32_t& c : corner) c <<= shift;
      blocks.push_back({static_cast<std::uint32_t>(block), corner, 1u << shift});
      ratios += stored;
    }
    for (std::size_t octant = 0; octant < 8; ++octant)
      if (placed[octant].verdict == CellVerdict::Split) {
        const std::uint32_t below = self(self, level + 1);
        tree.cells[block + octant] = below;
      }
    return static_cast<std::uint32_t>(block / 8);
  };
  emit(emit, 1);
  tree.origin = frame_.origin;
  tree.width = frame_.width;
  tree.domain = domain_;
  tree.size = field_.global();
  tree.gradation = field_.gradation();
  return tree;
}

std::vector<OctreeCell> OctreeBuilder::own_cells(const std::vector<OctreeCell>& cells, int level) const {
  std::vector<OctreeCell> own;
  for (const OctreeCell& cell : cells)
    if (cell.judged.state.is_own && rank_at(cell.code, level, work_.rank_count()) == work_.rank()) own.push_back(cell);
  own.shrink_to_fit();
  return own;
}

SizeOctree OctreeBuilder::build(const OctreeLevels& before, OctreeLevels& levels, std::vector<OctreeBlock>& blocks) {
  std::vector<JudgedLevel> judged;
  std::vector<OctreeCell> cells{{0, {}}};
  std::size_t total = 0;
  for (std::size_t level = 0; !cells.empty(); ++level) {
    total += cells.size();
    if (total > max_cells_)
      throw Error(ErrorCode::OutOfMemory, "the size field would need more than " + std::to_string(max_cells_) +
                                              " cells, which do not fit in memory; ask for larger sizes");
    judge(cells, static_cast<int>(level), level < before.size() ? before[level] : std::span<const OctreeCell>{});
    judged.push_back(verdicts_on(cells));
    std::vector<OctreeCell> next = children_of(cells, judged.back().cuts);
    levels.push_back(own_cells(cells, static_cast<int>(level)));
    cells = std::move(next);
  }
  std::vector<Codes> cuts;
  for (const JudgedLevel& level : judged) cuts.push_back(level.cuts);
  balance(cuts);
  return pack(place(judged, cuts), blocks);
}

}  // namespace tetloom
