#include "mesher/volume/interior_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>

#include "core/base/error.hpp"
#include "mesher/volume/point_grid.hpp"

namespace tetloom::volume {

namespace {

constexpr double kCubePerSize = 1.083;
constexpr double kLevelRatio = 1.5874010519681994;  // the cube root of 4
constexpr double kFromSurface = 0.55, kFromFinerLattice = 0.65;
constexpr double kJitter = 1e-4;
constexpr double kSizesPerCell = 4;
constexpr int kDeepestCell = 24;
constexpr int kLevelsThatReach = 3;  // finer lattices further away in level than this are never near
constexpr double kMostPoints = 1e9;

// Sizes h0 * ratio^k; uniform fields have one.
struct Levels {
  double smallest, ratio;
  int count;

  Levels(double lo, double hi) : smallest(lo), ratio(1), count(1) {
    const int steps = static_cast<int>(std::lround(std::log(hi / lo) / std::log(kLevelRatio)));
    if (steps == 0) smallest = std::sqrt(lo * hi);
    if (steps > 0) ratio = std::pow(hi / lo, 1.0 / steps), count = steps + 1;
  }
  double size(int level) const { return smallest * std::pow(ratio, level); }
  int of(double size) const {
    if (count == 1) return 0;
    return std::clamp(static_cast<int>(std::lround(std::log(size / smallest) / std::log(ratio))), 0, count - 1);
  }
};

std::uint64_t mixed(std::uint64_t x) {
  x = (x ^ x >> 30) * 0xbf58476d1ce4e5b9u;
  x = (x ^ x >> 27) * 0x94d049bb133111ebu;
  return x ^ x >> 31;
}

// A body-centred cubic lattice; index (i, j, k) with all even or all odd counts half cubes.
class Lattice {
 public:
  Lattice(const Vec3& origin, double size, int level)
      : half_(0.5 * kCubePerSize * size), jitter_(kJitter * size), level_(static_cast<std::uint64_t>(level)) {
    // Irrational shares of a cube, other ones for each level.
    const double turn = level * 0.7548776662466927;
    const auto share = [&](double x) { return 2 * half_ * (x + turn - std::floor(x + turn)); };
    origin_ = origin - Vec3{share(0.3819660113), share(0.2360679775), share(0.1458980338)};
  }

  // Calls visit(point) for the points whose exact lattice positions lie in the half-open box.
  template <class Visit>
  void for_each_in(const Box3& box, Visit&& visit) const {
    const auto first = [&](double x) { return static_cast<std::int64_t>(std::ceil(x / half_)); };
    const auto same_parity = [](std::int64_t i, std::int64_t k) { return i + ((i + k) & 1); };
    const Vec3 lo = box.lo - origin_, hi = box.hi - origin_;
    for (std::int64_t k = first(lo.z); k < first(hi.z); ++k) {
      for (std::int64_t j = same_parity(first(lo.y), k); j < first(hi.y); j += 2) {
        for (std::int64_t i = same_parity(first(lo.x), k); i < first(hi.x); i += 2) {
          visit(origin_ + half_ * Vec3{double(i), double(j), double(k)} + shift(i, j, k));
        }
      }
    }
  }

 private:
  Vec3 shift(std::int64_t i, std::int64_t j, std::int64_t k) const {
    std::uint64_t hash = level_;
    for (const std::int64_t index : {i, j, k})
      hash = mixed(hash * 0x9e3779b97f4a7c15u + static_cast<std::uint64_t>(index));
    const auto part = [&](int bits) { return jitter_ * (double(hash >> bits & 0x1fffff) / 0x100000 - 1); };
    return {part(0), part(21), part(42)};
  }

  Vec3 origin_;
  double half_, jitter_;
  std::uint64_t level_;
};

struct Cell {
  Box3 box;
  double lo = 0, hi = 0;  // sizes met in it
  bool near_surface = false;
};

class Filler {
 public:
  Filler(const InteriorRequest& request, const TaskRunner& runner)
      : request_(request), runner_(runner), levels_(levels_of(request)) {
    for (int level = 0; level < levels_.count; ++level) {
      lattices_.emplace_back(request.box.lo, levels_.size(level), level);
    }
  }

  std::vector<Vec3> fill() {
    const Vec3 extent = request_.box.hi - request_.box.lo;
    const double width = std::max({extent.x, extent.y, extent.z});
    collect_cells({request_.box.lo, request_.box.lo + Vec3{width, width, width}}, 0);
    std::vector<std::vector<std::vector<Vec3>>> cell_to_points(cells_.size());  // per level within a cell
    runner_.for_blocks(cells_.size(), 16, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) cell_to_points[i] = fill_cell(cells_[i]);
    });
    std::vector<std::vector<Vec3>> level_to_points(levels_.count);
    for (auto& of_cell : cell_to_points) {
      for (int level = 0; level < levels_.count; ++level) {
        auto& points = level_to_points[level];
        if (!of_cell.empty()) points.insert(points.end(), of_cell[level].begin(), of_cell[level].end());
      }
      of_cell.clear();
    }
    return merge(std::move(level_to_points));
  }

 private:
  // The field may hold sizes that this surface does not meet; the lattices follow those that it does.
  static Levels levels_of(const InteriorRequest& request) {
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

  void collect_cells(const Box3& box, int depth) {
    Cell cell{box, HUGE_VAL, 0, false};
    const Vec3 center = box.center();
    for (int corner = 0; corner < 9; ++corner) {
      const Vec3 x{corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y,
                   corner & 4 ? box.hi.z : box.lo.z};
      const double size = request_.sizes->size_at(corner == 8 ? center : x);
      cell.lo = std::min(cell.lo, size), cell.hi = std::max(cell.hi, size);
    }
    bool has_surface = false;
    request_.tree->for_each_in(box, [&](std::uint32_t) { has_surface = true; });
    if (!has_surface && !inside(center)) return;
    if (box.hi.x - box.lo.x > kSizesPerCell * cell.lo && depth < kDeepestCell) {
      for (int octant = 0; octant < 8; ++octant) {
        const Vec3 lo{octant & 1 ? center.x : box.lo.x, octant & 2 ? center.y : box.lo.y,
                      octant & 4 ? center.z : box.lo.z};
        const Vec3 hi{octant & 1 ? box.hi.x : center.x, octant & 2 ? box.hi.y : center.y,
                      octant & 4 ? box.hi.z : center.z};
        collect_cells({lo, hi}, depth + 1);
      }
      return;
    }
    cell.near_surface = has_surface;
    cells_.push_back(cell);
    if (static_cast<double>(cells_.size()) * 64 > kMostPoints) {
      throw Error(ErrorCode::OutOfMemory, "the size field asks for more than a thousand million points");
    }
  }

  std::vector<std::vector<Vec3>> fill_cell(const Cell& cell) const {
    std::vector<std::vector<Vec3>> level_to_points(levels_.count);
    const int first = std::max(0, levels_.of(cell.lo) - 1), last = std::min(levels_.count - 1, levels_.of(cell.hi) + 1);
    for (int level = first; level <= last; ++level) {
      lattices_[level].for_each_in(cell.box, [&](const Vec3& x) {
        const double size = request_.sizes->size_at(x);
        if (levels_.of(size) != level || request_.tree->any_within(x, kFromSurface * size)) return;
        if (!cell.near_surface || inside(x)) level_to_points[level].push_back(x);
      });
    }
    return level_to_points;
  }

  std::vector<Vec3> merge(std::vector<std::vector<Vec3>> level_to_points) const {
    std::vector<Vec3> all;
    for (int level = 0; level < levels_.count; ++level) {
      std::vector<Vec3>& points = level_to_points[level];
      if (level > 0) drop_near_finer(level_to_points, level);
      all.insert(all.end(), points.begin(), points.end());
    }
    return all;
  }

  void drop_near_finer(std::vector<std::vector<Vec3>>& level_to_points, int level) const {
    const double radius = kFromFinerLattice * levels_.size(level);
    PointGrid grid(radius);
    for (int finer = std::max(0, level - kLevelsThatReach); finer < level; ++finer) grid.add(level_to_points[finer]);
    grid.finish();
    std::vector<Vec3>& points = level_to_points[level];
    std::vector<char> dropped(points.size(), 0);
    runner_.for_blocks(points.size(), 4096, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) dropped[i] = grid.any_within(points[i]);
    });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (!dropped[i]) points[kept++] = points[i];
    }
    points.resize(kept);
  }

  const InteriorRequest& request_;
  const TaskRunner& runner_;
  Levels levels_;
  std::vector<Lattice> lattices_;
  std::vector<Cell> cells_;
};

}  // namespace

std::vector<Vec3> make_interior_points(const InteriorRequest& request, const TaskRunner& runner) {
  if (request.box.empty()) return {};
  return Filler(request, runner).fill();
}

}  // namespace tetloom::volume
