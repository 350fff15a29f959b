#include "adapt/transfer/cell_slopes.hpp"

#include <algorithm>
#include <cmath>

#include "adapt/transfer/clip_tet.hpp"
#include "core/base/grain.hpp"
#include "core/base/lists.hpp"

namespace tetloom::adapt {
namespace {

constexpr double kDeterminedSlope = 1e-10;  // of the largest eigenvalue: below, neighbours do not determine the slope

/// The corners of tets, those of two regions at one vertex apart.
class RegionCorners {
 public:
  RegionCorners(const TetView& mesh, std::span<const std::uint32_t> regions)
      : mesh_(mesh), regions_(regions), first_(mesh.points.size(), kNone) {
    for (std::size_t tet = 0; tet < mesh.tets.size(); ++tet) {
      for (const std::uint32_t v : mesh.tets[tet]) {
        if (first_[v] == kNone) first_[v] = regions[tet];
        if (first_[v] != regions[tet]) others_.emplace_back(v, regions[tet]);
      }
    }
    sort_unique(others_);
  }

  std::size_t size() const { return first_.size() + others_.size(); }
  std::size_t index(std::size_t tet, std::size_t corner) const {
    const std::pair key(mesh_.tets[tet][corner], regions_[tet]);
    if (first_[key.first] == key.second) return key.first;
    const auto at = std::lower_bound(others_.begin(), others_.end(), key);
    return first_.size() + static_cast<std::size_t>(at - others_.begin());
  }

 private:
  const TetView mesh_;
  std::span<const std::uint32_t> regions_;
  std::vector<std::uint32_t> first_;                             ///< region at each vertex
  std::vector<std::pair<std::uint32_t, std::uint32_t>> others_;  ///< vertices and further regions
};

struct Range {
  double least = HUGE_VAL, greatest = -HUGE_VAL;
  void add(double value) { least = std::min(least, value), greatest = std::max(greatest, value); }
};

class Slopes {
 public:
  Slopes(const LinkedTets& mesh, const CellValues& cells)
      : links_(mesh.links), view_(mesh.mesh), regions_(mesh.regions), cells_(cells), corners_(mesh.mesh, mesh.regions) {
    ranges_.resize(corners_.size() * cells.components);
    for (std::size_t tet = 0; tet < view_.tets.size(); ++tet)
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t c = 0; c < cells.components; ++c)
          ranges_[corners_.index(tet, i) * cells.components + c].add(cells.of(tet)[c]);
  }

  void find(std::uint32_t tet, std::vector<std::uint32_t>& neighbors, Vec3* slopes) const {
    collect(tet, neighbors);
    const Corners x = corners_of(view_, tet);
    const Vec3 center = center_of(x);
    const std::array<Vec3, 3> edges{x[1] - x[0], x[2] - x[0], x[3] - x[0]};
    const double scale = 1 / dot(cross(edges[0], edges[1]), edges[2]);
    const std::array<Vec3, 3> axes{scale * cross(edges[1], edges[2]), scale * cross(edges[2], edges[0]),
                                   scale * cross(edges[0], edges[1])};  // gradients of barycentric coordinates
    const auto away = [&](std::uint32_t other) {
      const Vec3 by = center_of(corners_of(view_, other)) - center;
      return Vec3{dot(axes[0], by), dot(axes[1], by), dot(axes[2], by)};
    };
    Tensor normal;
    for (const std::uint32_t other : neighbors) {
      const Vec3 by = away(other);
      normal += outer(by, 1 / norm2(by));
    }
    const double most = eigen(normal).values[2];
    const Tensor inverse =
        map_eigenvalues(normal, [&](double value) { return value > kDeterminedSlope * most ? 1 / value : 0.0; });
    for (std::size_t c = 0; c < cells_.components; ++c) {
      const double value = cells_.of(tet)[c];
      Vec3 right;
      for (const std::uint32_t other : neighbors) {
        const Vec3 by = away(other);
        right += (cells_.of(other)[c] - value) / norm2(by) * by;
      }
      const Vec3 local = inverse * right;
      slopes[c] = limited(tet, c, x, center, local.x * axes[0] + local.y * axes[1] + local.z * axes[2]);
    }
  }

 private:
  // Tets of the region across faces, and across theirs; ascending.
  void collect(std::uint32_t tet, std::vector<std::uint32_t>& neighbors) const {
    neighbors.clear();
    const auto add_around = [&](std::uint32_t of) {
      for (const FaceCode face : FaceCode::of(of)) {
        const FaceCode behind = links_[face.index()];
        if (behind.valid() && behind.tet() != tet && regions_[behind.tet()] == regions_[tet])
          neighbors.push_back(behind.tet());
      }
    };
    add_around(tet);
    for (std::size_t i = 0, count = neighbors.size(); i < count; ++i) add_around(neighbors[i]);
    sort_unique(neighbors);
  }

  Vec3 limited(std::uint32_t tet, std::size_t c, const Corners& x, const Vec3& center, const Vec3& slope) const {
    const double value = cells_.of(tet)[c];
    double share = 1;
    for (std::size_t i = 0; i < 4; ++i) {
      const double step = dot(slope, x[i] - center);
      const Range& range = ranges_[corners_.index(tet, i) * cells_.components + c];
      const double room = step > 0 ? range.greatest - value : range.least - value;
      if (std::abs(step) > std::abs(room)) share = std::min(share, room / step);
    }
    return is_finite(slope) ? share * slope : Vec3{};
  }

  std::span<const FaceCode> links_;
  const TetView view_;
  std::span<const std::uint32_t> regions_;
  const CellValues& cells_;
  RegionCorners corners_;
  std::vector<Range> ranges_;  ///< per corner and component
};

}  // namespace

std::vector<Vec3> limited_slopes(const LinkedTets& mesh, const CellValues& cells, const BlockLoop& loop) {
  const Slopes finder(mesh, cells);
  const std::size_t count = mesh.end - mesh.begin;
  std::vector<Vec3> slopes(count * cells.components);
  loop.for_blocks(count, kStarGrain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> neighbors;
    for (std::size_t i = begin; i < end; ++i)
      finder.find(static_cast<std::uint32_t>(mesh.begin + i), neighbors, &slopes[i * cells.components]);
  });
  return slopes;
}

}  // namespace tetloom::adapt
