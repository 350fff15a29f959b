#include "mesher/lattice/lattice_cells.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/lists.hpp"
#include "mesher/lattice/point_grid.hpp"
#include "tetloom/error.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::lattice {

namespace {

constexpr int kMostLevels = 1024;
constexpr double kFromFinerLattice = 0.65;
// Large cells look at fewer triangles twice; small ones follow sizes that vary.
constexpr double kSizesPerCell = 4, kSizesPerUniformCell = 8;
constexpr int kDeepestCell = 24;
constexpr double kMostPoints = 1e9;

// The field may hold sizes that this surface does not meet; the lattices follow those that it does.
Levels levels_of(const LatticeRequest& request) {
  if (request.sizes->is_uniform()) return {request.sizes->smallest(), request.sizes->smallest()};
  double lo = HUGE_VAL, hi = 0;
  request.sizes->for_each_leaf(
      request.box, [&](const SizeLeaf& leaf) { lo = std::min(lo, leaf.size), hi = std::max(hi, leaf.size); });
  return {lo, hi};
}

}  // namespace

LatticeCells::LatticeCells(const LatticeRequest& request, const SharedWork& work)
    : request_(request), levels_(levels_of(request)) {
  for (int level = 0; level < levels_.count(); ++level)
    lattices_.emplace_back(request.kind, request.box.lo, levels_.size(level), level + kMostLevels * request.attempt,
                           levels_.count() == 1);
  const Vec3 extent = request.box.hi - request.box.lo;
  const double width = std::max({extent.x, extent.y, extent.z});
  // Level by level until there are enough subtrees; cells stand in the order of the whole tree in the end.
  std::vector<Node> nodes{{{request.box.lo, request.box.lo + Vec3{width, width, width}}, 0, true}};
  for (std::size_t before = 0; before != nodes.size() && nodes.size() < kSubtrees;) {
    before = nodes.size();
    std::vector<std::vector<Node>> node_to_next(nodes.size());
    work.runner().for_each(nodes.size(), [&](std::size_t i) {
      const auto branch = [&](const Node& child) { node_to_next[i].push_back(child); };
      visit(
          nodes[i], [&](const LatticeCell&) { node_to_next[i].push_back(nodes[i]); }, branch);
    });
    nodes.clear();
    for (const auto& next : node_to_next) nodes.insert(nodes.end(), next.begin(), next.end());
  }
  const std::vector<double> subtrees(nodes.size(), 1.0);
  cells_ = joined(work.make_lists<LatticeCell>(subtrees, [&](std::size_t i) {
    std::vector<LatticeCell> cells;
    collect(nodes[i], cells);
    return cells;
  }));
  if (static_cast<double>(cells_.size()) * 64 > kMostPoints)
    throw Error(ErrorCode::OutOfMemory, "the size field asks for more than a thousand million points");
}

void LatticeCells::keep(std::span<const std::uint32_t> cells) {
  std::vector<LatticeCell> kept;
  kept.reserve(cells.size());
  for (const std::uint32_t cell : cells) kept.push_back(cells_[cell]);
  cells_ = std::move(kept);
}

const SiteLattice& LatticeCells::coarsest_of(const LatticeCell& cell) const {
  return lattices_[static_cast<std::size_t>(std::min(levels_.count() - 1, levels_.of(cell.hi) + 1))];
}

// Every region is left as often as it is entered above x, but for that around x.
std::uint32_t LatticeCells::region_at(const Vec3& x) const {
  std::vector<std::pair<ModelRegionId, int>> region_to_depth;
  const auto count = [&](ModelRegionId region, int change) {
    if (!region.valid()) return;
    for (auto& [known, depth] : region_to_depth) {
      if (known != region) continue;
      depth += change;
      return;
    }
    region_to_depth.emplace_back(region, change);
  };
  request_.tree->for_each_above(x, [&](std::uint32_t triangle, bool up) {
    const FaceSides& sides = request_.tri_to_sides[triangle];
    count(up ? sides.back : sides.front, 1);
    count(up ? sides.front : sides.back, -1);
  });
  for (const auto& [region, depth] : region_to_depth)
    if (depth > 0) return region.value;
  return kNone;
}

LatticeCell LatticeCells::sized_cell(const Box3& box) const {
  LatticeCell cell{box, HUGE_VAL, 0, false, false};
  const int samples = request_.sizes->is_uniform() ? 1 : 9;
  for (int corner = 0; corner < samples; ++corner) {
    const Vec3 x{corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y, corner & 4 ? box.hi.z : box.lo.z};
    const double size = request_.sizes->size_at(corner == 8 ? box.center() : x);
    cell.lo = std::min(cell.lo, size), cell.hi = std::max(cell.hi, size);
  }
  return cell;
}

// A node is outside, or a leaf, or has eight children.
template <class Leaf, class Branch>
void LatticeCells::visit(const Node& node, const Leaf& leaf, const Branch& branch) const {
  const Box3& box = node.box;
  LatticeCell cell = sized_cell(box);
  const Vec3 center = box.center();
  cell.meets_surface = node.may_meet_surface && request_.tree->may_meet(box);
  if (node.may_meet_surface && !cell.meets_surface && !is_inside(center)) return;
  const double sizes_per_cell = request_.sizes->is_uniform() ? kSizesPerUniformCell : kSizesPerCell;
  if (box.hi.x - box.lo.x > sizes_per_cell * cell.lo && node.depth < kDeepestCell) {
    for (int octant = 0; octant < 8; ++octant) {
      const Vec3 lo{octant & 1 ? center.x : box.lo.x, octant & 2 ? center.y : box.lo.y,
                    octant & 4 ? center.z : box.lo.z};
      const Vec3 hi{octant & 1 ? box.hi.x : center.x, octant & 2 ? box.hi.y : center.y,
                    octant & 4 ? box.hi.z : center.z};
      branch(Node{{lo, hi}, node.depth + 1, cell.meets_surface});
    }
    return;
  }
  const double near_surface = LatticeShape::of(request_.kind).near_surface();
  const double reach = near_surface * cell.hi * 1.3;  // the lattice's size may be larger than the field's
  const Vec3 margin{reach, reach, reach};
  cell.near_surface = cell.meets_surface || request_.tree->may_meet({box.lo - margin, box.hi + margin});
  leaf(cell);
}

void LatticeCells::collect(const Node& node, std::vector<LatticeCell>& cells) const {
  if (static_cast<double>(cells.size()) * 64 > kMostPoints) return;  // to be refused
  const auto leaf = [&](const LatticeCell& cell) { cells.push_back(cell); };
  visit(node, leaf, [&](const Node& child) { collect(child, cells); });
}

std::vector<std::vector<KeptSite>> LatticeCells::find_sites(const LatticeCell& cell, const Box3& box,
                                                            CellSites& sites) const {
  std::vector<std::vector<KeptSite>> level_to_sites(level_count());
  const int first = std::max(0, levels_.of(cell.lo) - 1);
  const int last = std::min(levels_.count() - 1, levels_.of(cell.hi) + 1);
  CellSites::Questions questions{cell.near_surface ? request_.tree : nullptr, {}, {}};
  if (cell.meets_surface) questions.is_inside = [this](const Vec3& x) { return is_inside(x); };
  for (int level = first; level <= last; ++level) {
    if (levels_.count() > 1) {
      questions.is_wanted = [this, range = levels_.range(level)](const Vec3& x) {
        return range.holds(request_.sizes->size_at(x));
      };
    }
    level_to_sites[static_cast<std::size_t>(level)] =
        sites.find(lattices_[static_cast<std::size_t>(level)], box, questions);
  }
  return level_to_sites;
}

void drop_near_finer(LevelPoints& level, std::span<const std::span<const Vec3>> finer, const TaskRunner& runner) {
  PointGrid grid(kFromFinerLattice * level.lattice.size());
  for (const std::span<const Vec3> points : finer) grid.add(points);
  grid.finish();
  std::vector<char> dropped(level.sites.size(), 0);
  runner.for_blocks(dropped.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) dropped[i] = grid.any_within(level.lattice.point(level.sites[i]));
  });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < dropped.size(); ++i) {
    if (dropped[i]) continue;
    level.sites[kept] = level.sites[i];
    level.near_surface[kept++] = level.near_surface[i];
  }
  level.sites.resize(kept);
  level.near_surface.resize(kept);
}

}  // namespace tetloom::lattice
