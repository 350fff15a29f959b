#include "mesher/lattice/lattice_points.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/error.hpp"
#include "mesher/lattice/cell_sites.hpp"
#include "mesher/lattice/point_grid.hpp"

namespace tetloom::lattice {

namespace {

constexpr int kMostLevels = 1024;
constexpr double kFromFinerLattice = 0.65;
// Large cells look at fewer triangles twice; small ones follow sizes that vary.
constexpr double kSizesPerCell = 4, kSizesPerUniformCell = 8;
constexpr int kDeepestCell = 24;
constexpr int kLevelsThatReach = 3;  // lattices finer by more are never near
constexpr double kMostPoints = 1e9;

struct Cell {
  Box3 box;
  double lo = 0, hi = 0;  // sizes met in it
  bool near_surface = false, meets_surface = false;
};

class Filler {
 public:
  Filler(const LatticeRequest& request, const TaskRunner& runner)
      : request_(request), runner_(runner), levels_(levels_of(request)) {
    for (int level = 0; level < levels_.count(); ++level)
      lattices_.emplace_back(request.kind, request.box.lo, levels_.size(level), level + kMostLevels * request.attempt,
                             levels_.count() == 1);
  }

  std::vector<LevelPoints> fill() {
    const Vec3 extent = request_.box.hi - request_.box.lo;
    const double width = std::max({extent.x, extent.y, extent.z});
    collect_cells({{request_.box.lo, request_.box.lo + Vec3{width, width, width}}, 0, true});
    std::vector<std::vector<std::vector<KeptSite>>> cell_to_sites(cells_.size());  // per level within a cell
    runner_.for_blocks(cells_.size(), 16, [&](std::size_t begin, std::size_t end) {
      CellSites sites;
      for (std::size_t i = begin; i < end; ++i) cell_to_sites[i] = fill_cell(cells_[i], sites);
    });
    std::vector<LevelPoints> result;
    for (int level = 0; level < levels_.count(); ++level) {
      LevelPoints& points = result.emplace_back(LevelPoints{lattices_[level], {}, {}});
      std::size_t count = 0;
      for (const auto& of_cell : cell_to_sites) count += of_cell[static_cast<std::size_t>(level)].size();
      points.sites.reserve(count);
      points.near_surface.reserve(count);
      for (auto& of_cell : cell_to_sites) append(std::exchange(of_cell[static_cast<std::size_t>(level)], {}), points);
    }
    drop_near_finer(result);
    return result;
  }

 private:
  // The field may hold sizes that this surface does not meet; the lattices follow those that it does.
  static Levels levels_of(const LatticeRequest& request) {
    if (request.sizes->is_uniform()) return {request.sizes->smallest(), request.sizes->smallest()};
    double lo = HUGE_VAL, hi = 0;
    request.sizes->for_each_leaf(
        request.box, [&](const SizeLeaf& leaf) { lo = std::min(lo, leaf.size), hi = std::max(hi, leaf.size); });
    return {lo, hi};
  }

  // True when the surface names a region around x.
  bool inside(const Vec3& x) const {
    int depth = 0;
    request_.tree->for_each_above(x, [&](std::uint32_t triangle, bool up) {
      const FaceSides& sides = request_.tri_to_sides[triangle];
      const ModelRegionId below = up ? sides.back : sides.front, above = up ? sides.front : sides.back;
      depth += int{below.valid()} - int{above.valid()};
    });
    return depth > 0;
  }

  struct Node {
    Box3 box;
    int depth;
    bool may_meet_surface;  // false: known to be inside
  };

  void collect_cells(const Node& node) {
    const Box3& box = node.box;
    Cell cell = sized_cell(box);
    const Vec3 center = box.center();
    cell.meets_surface = node.may_meet_surface && request_.tree->may_meet(box);
    if (node.may_meet_surface && !cell.meets_surface && !inside(center)) return;
    const double sizes_per_cell = request_.sizes->is_uniform() ? kSizesPerUniformCell : kSizesPerCell;
    if (box.hi.x - box.lo.x > sizes_per_cell * cell.lo && node.depth < kDeepestCell) {
      for (int octant = 0; octant < 8; ++octant) {
        const Vec3 lo{octant & 1 ? center.x : box.lo.x, octant & 2 ? center.y : box.lo.y,
                      octant & 4 ? center.z : box.lo.z};
        const Vec3 hi{octant & 1 ? box.hi.x : center.x, octant & 2 ? box.hi.y : center.y,
                      octant & 4 ? box.hi.z : center.z};
        collect_cells({{lo, hi}, node.depth + 1, cell.meets_surface});
      }
      return;
    }
    const double near_surface = LatticeShape::of(request_.kind).near_surface();
    const double reach = near_surface * cell.hi * 1.3;  // the lattice's size may be larger than the field's
    const Vec3 margin{reach, reach, reach};
    cell.near_surface = cell.meets_surface || request_.tree->may_meet({box.lo - margin, box.hi + margin});
    cells_.push_back(cell);
    if (static_cast<double>(cells_.size()) * 64 > kMostPoints)
      throw Error(ErrorCode::OutOfMemory, "the size field asks for more than a thousand million points");
  }

  Cell sized_cell(const Box3& box) const {
    Cell cell{box, HUGE_VAL, 0, false, false};
    const int samples = request_.sizes->is_uniform() ? 1 : 9;
    for (int corner = 0; corner < samples; ++corner) {
      const Vec3 x{corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                   corner & 4 ? box.hi.z : box.lo.z};
      const double size = request_.sizes->size_at(corner == 8 ? box.center() : x);
      cell.lo = std::min(cell.lo, size), cell.hi = std::max(cell.hi, size);
    }
    return cell;
  }

  std::vector<std::vector<KeptSite>> fill_cell(const Cell& cell, CellSites& sites) const {
    std::vector<std::vector<KeptSite>> level_to_sites(static_cast<std::size_t>(levels_.count()));
    const int first = std::max(0, levels_.of(cell.lo) - 1);
    const int last = std::min(levels_.count() - 1, levels_.of(cell.hi) + 1);
    CellSites::Questions questions{cell.near_surface ? request_.tree : nullptr, {}, {}};
    if (cell.meets_surface) questions.is_inside = [this](const Vec3& x) { return inside(x); };
    for (int level = first; level <= last; ++level) {
      if (levels_.count() > 1) {
        questions.is_wanted = [this, range = levels_.range(level)](const Vec3& x) {
          return range.holds(request_.sizes->size_at(x));
        };
      }
      level_to_sites[static_cast<std::size_t>(level)] =
          sites.find(lattices_[static_cast<std::size_t>(level)], cell.box, questions);
    }
    return level_to_sites;
  }

  static void append(const std::vector<KeptSite>& from, LevelPoints& to) {
    for (const KeptSite& kept : from) {
      to.sites.push_back(kept.site);
      to.near_surface.push_back(kept.near_surface);
    }
  }

  static std::vector<Vec3> positions(const LevelPoints& level) {
    std::vector<Vec3> points;
    points.reserve(level.sites.size());
    for (const Site& site : level.sites) points.push_back(level.lattice.point(site));
    return points;
  }

  void drop_near_finer(std::vector<LevelPoints>& levels) const {
    std::vector<std::vector<Vec3>> points;
    for (std::size_t level = 0; level < levels.size(); ++level) {
      points.push_back(levels.size() > 1 ? positions(levels[level]) : std::vector<Vec3>());
      if (level == 0) continue;
      PointGrid grid(kFromFinerLattice * levels[level].lattice.size());
      const std::size_t first = level < kLevelsThatReach ? 0 : level - kLevelsThatReach;
      for (std::size_t finer = first; finer < level; ++finer) grid.add(points[finer]);
      grid.finish();
      drop_near(grid, levels[level], points[level]);
    }
  }

  void drop_near(const PointGrid& grid, LevelPoints& level, std::vector<Vec3>& points) const {
    std::vector<char> dropped(points.size(), 0);
    runner_.for_blocks(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) dropped[i] = grid.any_within(points[i]);
    });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (dropped[i]) continue;
      points[kept] = points[i];
      level.sites[kept] = level.sites[i];
      level.near_surface[kept++] = level.near_surface[i];
    }
    points.resize(kept);
    level.sites.resize(kept);
    level.near_surface.resize(kept);
  }

  const LatticeRequest& request_;
  const TaskRunner& runner_;
  Levels levels_;
  std::vector<SiteLattice> lattices_;
  std::vector<Cell> cells_;
};

}  // namespace

std::vector<LevelPoints> make_lattice_points(const LatticeRequest& request, const TaskRunner& runner) {
  if (request.box.empty()) return {};
  return Filler(request, runner).fill();
}

}  // namespace tetloom::lattice
