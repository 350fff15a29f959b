#include "tetloom/check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "core/base/grain.hpp"
#include "core/mesh/cell_jacobians.hpp"
#include "core/mesh/curved_quality.hpp"
#include "core/mesh/incidence_detail.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "core/mesh/quality_values.hpp"
#include "core/mesh/statistics_detail.hpp"
#include "core/mesh/tet_volume.hpp"
#include "core/predicates/predicates.hpp"
#include "core/tets/tet_topology.hpp"

namespace tetloom {
namespace {

using detail::PerEntity;
using detail::Sum;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kBandLow = 0.707106781, kBandHigh = 1.41421356;

template <std::size_t Bins>
std::size_t bin_of(double share) {
  return share >= 1 ? Bins - 1 : share > 0 ? static_cast<std::size_t>(share * Bins) : 0;
}

/// Sorts angles into bins of 10 degrees by their cosines alone.
class DihedralBins {
 public:
  DihedralBins() {
    for (int i = 0; i < 17; ++i) edges_[i] = std::cos((i + 1) / 18.0 * std::numbers::pi);
  }
  std::size_t find(double cosine) const {
    // Counting all of them has no branches to mispredict and goes several at once.
    int bin = 0;
    for (const double edge : edges_) bin += cosine < edge;
    return static_cast<std::size_t>(bin);
  }

 private:
  std::array<double, 17> edges_{};
};

struct TetShape {
  double volume = 0, mean_ratio = 0;
  std::array<double, 6> dihedral_cosines{};
};

TetShape measure_tet(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  TetShape shape;
  const Vec3 ab = b - a, ac = c - a, ad = d - a, bc = c - b, bd = d - b, cd = d - c;
  const std::array<Vec3, 4> outward{cross(bc, bd), cross(ad, ac), cross(ab, ad), cross(ac, ab)};
  shape.volume = dot(cross(ab, ac), ad) / 6;
  const double edges = norm2(ab) + norm2(ac) + norm2(ad) + norm2(bc) + norm2(bd) + norm2(cd);
  if (shape.volume > 0 && std::isfinite(edges)) {
    const double root = std::cbrt(3 * shape.volume);
    shape.mean_ratio = 12 * root * root / edges;
  }
  std::array<double, 4> inverse_norm;
  for (int i = 0; i < 4; ++i) inverse_norm[i] = 1 / std::max(norm(outward[i]), std::numeric_limits<double>::min());
  for (int k = 0; k < 6; ++k) {
    const auto [i, j] = tets::kEdgeVerts[k];
    shape.dihedral_cosines[k] = -dot(outward[i], outward[j]) * inverse_norm[i] * inverse_norm[j];
  }
  return shape;
}

struct EdgeSums {
  std::size_t edges = 0, in_band = 0;
  Sum lengths, ratios;

  void add(const EdgeSums& other) {
    edges += other.edges, in_band += other.in_band;
    lengths.add(other.lengths), ratios.add(other.ratios);
  }
};

EdgeConformity conformity_of(const EdgeSums& sums) {
  if (sums.edges == 0) return {};
  const auto count = static_cast<double>(sums.edges);
  return {sums.edges, sums.lengths.value() / count, sums.ratios.value() / count,
          static_cast<double>(sums.in_band) / count};
}

/// Adds lengths of edges, and how they keep to the sizes at points, where there are some.
class EdgeMeter {
 public:
  EdgeMeter(const std::vector<Vec3>& points, const std::vector<double>& point_size)
      : points_(points), point_size_(point_size) {}

  void measure(std::uint32_t a, std::uint32_t b, EdgeSums& sums) const {
    const double length = distance(points_[a], points_[b]);
    ++sums.edges;
    sums.lengths.add(length);
    if (point_size_.empty()) return;
    const double ratio = length / (0.5 * (point_size_[a] + point_size_[b]));
    sums.ratios.add(ratio);
    sums.in_band += ratio >= kBandLow && ratio <= kBandHigh;
  }

  /// Of the unique edges of `elements` that pass the test, and of `more`.
  template <class Element>
  EdgeConformity measure_all(const std::vector<Element>& elements, const MeasuredEdges& measured,
                             const MeasuredEdges::Edges& more, const BlockLoop& loop) const {
    const auto measure_one = [&](std::uint32_t a, std::uint32_t b, EdgeSums& sums) {
      if (!measured.test || measured.test(a, b)) measure(a, b, sums);
    };
    EdgeSums total;
    for (const EdgeSums& sums : detail::map_unique_edges<EdgeSums>(elements, points_.size(), loop, measure_one))
      total.add(sums);
    for (const auto& [a, b] : more) measure(a, b, total);
    return conformity_of(total);
  }

 private:
  const std::vector<Vec3>& points_;
  const std::vector<double>& point_size_;
};

/// The size at every point; empty without a field.
std::vector<double> sizes_at_points(const Mesh& mesh, const SizeField* sizes, const BlockLoop& loop) {
  std::vector<double> point_size;
  if (sizes == nullptr) return point_size;
  point_size.resize(vertex_count(mesh));
  loop.for_blocks(point_size.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) point_size[i] = sizes->size_at(mesh.points[i]);
  });
  return point_size;
}

/// The signed volume of a cell. Between two triangles that share a diagonal and the two that share the other one, a
/// bilinear face lies in the middle.
double cell_volume(const std::vector<Vec3>& points, std::span<const std::uint32_t> cell, CellKind kind) {
  const Vec3& o = points[cell[0]];
  if (kind == CellKind::Tet) return tet_volume(o, points[cell[1]], points[cell[2]], points[cell[3]]);
  double volume = 0;
  for (const LocalFace& face : shape_of(kind).faces()) {
    const auto at = [&](std::size_t i) -> const Vec3& { return points[cell[face.vert[i]]]; };
    if (face.count == 3)
      volume += tet_volume(o, at(0), at(1), at(2));
    else
      volume += 0.5 * (tet_volume(o, at(0), at(1), at(2)) + tet_volume(o, at(0), at(2), at(3)) +
                       tet_volume(o, at(0), at(1), at(3)) + tet_volume(o, at(1), at(2), at(3)));
  }
  return volume;
}

/// The volume is not finite when a coordinate is not, and the predicate wants finite ones.
bool is_inverted(const std::vector<Vec3>& points, std::span<const std::uint32_t> cell, CellKind kind, double volume) {
  if (!std::isfinite(volume)) return true;
  for (const auto& [a, b, c, d] : corners_of(kind))
    if (orient3d(points[cell[a]], points[cell[b]], points[cell[c]], points[cell[d]]) <= 0) return true;
  return false;
}

struct RegionSums {
  std::size_t tets = 0, cells = 0;
  Sum volume;

  void add(const RegionSums& other) {
    tets += other.tets, cells += other.cells;
    volume.add(other.volume);
  }
};

/// Cells of one kind.
struct CellSums {
  std::size_t inverted = 0;
  Sum volume;
  PerEntity<RegionSums> regions;

  void add(const CellSums& other) {
    inverted += other.inverted;
    volume.add(other.volume);
    regions.add(other.regions);
  }
};

void measure_cell(std::uint32_t region, bool is_tet, double volume, bool inverted, CellSums& sums) {
  sums.inverted += inverted;
  sums.volume.add(volume);
  RegionSums& of_region = sums.regions.at(region);
  ++of_region.cells;
  of_region.tets += is_tet;
  of_region.volume.add(volume);
}

template <class Cell>
CellSums sum_cells(const Mesh& mesh, CellKind kind, const std::vector<Cell>& cells,
                   const std::vector<std::uint32_t>& regions, const BlockLoop& loop) {
  const auto of_blocks =
      map_blocks(loop, cells.size(), kCopyGrain, CellSums{}, [&](std::size_t begin, std::size_t end, CellSums& result) {
        CellSums sums{0, {}, PerEntity<RegionSums>(std::span(regions).subspan(begin, end - begin))};
        for (std::size_t c = begin; c < end; ++c) {
          const double volume = cell_volume(mesh.points, cells[c], kind);
          measure_cell(regions[c], false, volume, is_inverted(mesh.points, cells[c], kind, volume), sums);
        }
        result = std::move(sums);
      });
  CellSums total;
  for (const CellSums& sums : of_blocks) total.add(sums);
  return total;
}

CellQuality measure_cells(const Mesh& mesh, const CellSums& tets, const BlockLoop& loop,
                          GrowingArray<float>& scaled_jacobians) {
  CellQuality result;
  result.count = cell_count(mesh);
  CellSums total;
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto& regions) {
    result.counts[static_cast<std::size_t>(kind)] = cells.size();
    total.add(kind == CellKind::Tet ? tets : sum_cells(mesh, kind, cells, regions, loop));
  });
  result.inverted = total.inverted;
  result.volume = total.volume.value();
  const CellJacobians jacobians = measure_jacobians(mesh, loop, scaled_jacobians);
  result.min_scaled_jacobian = jacobians.least;
  result.scaled_jacobian_p1 = jacobians.p1;
  for (const auto& [region, sums] : total.regions.items())
    result.regions.push_back({region, sums.tets, sums.cells, sums.volume.value()});
  return result;
}

struct TetSums {
  CellSums cells;
  Sum ratio;
  float least_ratio = std::numeric_limits<float>::infinity();
  double largest_cosine = -1;
  std::array<std::size_t, 10> ratio_histogram{};
  std::array<std::size_t, 18> dihedral_histogram{};

  void add(const TetSums& other) {
    cells.add(other.cells);
    ratio.add(other.ratio);
    least_ratio = std::min(least_ratio, other.least_ratio);
    largest_cosine = std::max(largest_cosine, other.largest_cosine);
    for (std::size_t i = 0; i < ratio_histogram.size(); ++i) ratio_histogram[i] += other.ratio_histogram[i];
    for (std::size_t i = 0; i < dihedral_histogram.size(); ++i) dihedral_histogram[i] += other.dihedral_histogram[i];
  }
};

/// Adds a tet and returns its mean ratio.
float add_tet(const Mesh& mesh, std::size_t t, const DihedralBins& bins, TetSums& sums) {
  const auto& [a, b, c, d] = mesh.tet_to_vert[t];
  const Vec3 &pa = mesh.points[a], &pb = mesh.points[b], &pc = mesh.points[c], &pd = mesh.points[d];
  const TetShape shape = measure_tet(pa, pb, pc, pd);
  // The volume is not finite when a coordinate is not, and the predicate wants finite ones.
  const bool inverted = !std::isfinite(shape.volume) || orient3d(pa, pb, pc, pd) <= 0;
  const double ratio = inverted ? 0 : shape.mean_ratio;
  measure_cell(mesh.tet_to_entity[t], true, shape.volume, inverted, sums.cells);
  sums.ratio.add(ratio);
  sums.least_ratio = std::min(sums.least_ratio, static_cast<float>(ratio));
  ++sums.ratio_histogram[bin_of<10>(ratio)];
  if (!inverted)
    for (const double cosine : shape.dihedral_cosines) {
      sums.largest_cosine = std::max(sums.largest_cosine, cosine);
      ++sums.dihedral_histogram[bins.find(cosine)];
    }
  return static_cast<float>(ratio);
}

/// Measures all tets; their mean ratios go to `ratios`.
TetSums sum_tets(const Mesh& mesh, const BlockLoop& loop, std::span<float> ratios) {
  const DihedralBins bins;
  const auto of_blocks =
      map_blocks(loop, ratios.size(), kCopyGrain, TetSums{}, [&](std::size_t begin, std::size_t end, TetSums& result) {
        TetSums sums;
        sums.cells.regions = PerEntity<RegionSums>(std::span(mesh.tet_to_entity).subspan(begin, end - begin));
        for (std::size_t t = begin; t < end; ++t) ratios[t] = add_tet(mesh, t, bins, sums);
        result = std::move(sums);
      });
  TetSums total;
  for (const TetSums& sums : of_blocks) total.add(sums);
  return total;
}

/// What is common with other cells goes to `cells`.
TetQuality measure_tets(const Mesh& mesh, const BlockLoop& loop, CellSums& cells, GrowingArray<float>& ratios) {
  TetQuality result;
  result.count = mesh.tet_to_vert.size();
  if (result.count == 0) return result;
  ratios.resize_for_overwrite(result.count);
  const TetSums sums = sum_tets(mesh, loop, ratios);
  cells = sums.cells;
  result.inverted = cells.inverted;
  result.min_dihedral_deg = result.inverted > 0 ? 0 : std::acos(std::clamp(sums.largest_cosine, -1.0, 1.0)) * kDegrees;
  result.mean_ratio_min = sums.least_ratio;
  result.mean_ratio_p1 = detail::quantile(ratios.span(), 0.01, loop);
  result.mean_ratio_mean = sums.ratio.value() / static_cast<double>(result.count);
  result.volume = cells.volume.value();
  result.mean_ratio_histogram = sums.ratio_histogram;
  result.dihedral_histogram = sums.dihedral_histogram;
  return result;
}

struct TriangleShape {
  double area = 0, shape = 0, min_angle = 0;
};

TriangleShape measure_triangle(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, bc = c - b;
  const double twice_area = norm(cross(ab, ac));
  const double edges = norm2(ab) + norm2(ac) + norm2(bc);
  if (!(edges > 0) || !std::isfinite(edges)) return {};
  // The smallest angle lies opposite to the shortest edge; atan2 keeps it accurate for slivers.
  double facing = dot(ab, ac);
  if (norm2(ac) < norm2(bc) && norm2(ac) <= norm2(ab)) facing = -dot(ab, bc);
  if (norm2(ab) < norm2(bc) && norm2(ab) < norm2(ac)) facing = dot(ac, bc);
  return {0.5 * twice_area, 2 * std::numbers::sqrt3 * twice_area / edges, std::atan2(twice_area, facing)};
}

struct FaceSums {
  std::size_t triangles = 0;
  Sum area;
  double min_angle = std::numbers::pi;

  void add(const FaceSums& other) {
    triangles += other.triangles;
    area.add(other.area);
    min_angle = std::min(min_angle, other.min_angle);
  }
};

struct TriangleSums {
  FaceSums all;
  Sum shape;
  float least_shape = std::numeric_limits<float>::infinity();
  PerEntity<FaceSums> faces;

  void add(const TriangleSums& other) {
    all.add(other.all);
    shape.add(other.shape);
    least_shape = std::min(least_shape, other.least_shape);
    faces.add(other.faces);
  }
};

/// Measures all triangles; their shapes go to `shapes`.
TriangleSums sum_triangles(const Mesh& mesh, const BlockLoop& loop, std::span<float> shapes) {
  const auto of_blocks = map_blocks(
      loop, shapes.size(), kCopyGrain, TriangleSums{}, [&](std::size_t begin, std::size_t end, TriangleSums& result) {
        TriangleSums sums;
        sums.faces = PerEntity<FaceSums>(std::span(mesh.tri_to_entity).subspan(begin, end - begin));
        for (std::size_t t = begin; t < end; ++t) {
          const auto& [a, b, c] = mesh.tri_to_vert[t];
          const TriangleShape triangle = measure_triangle(mesh.points[a], mesh.points[b], mesh.points[c]);
          shapes[t] = static_cast<float>(triangle.shape);
          sums.shape.add(triangle.shape);
          sums.least_shape = std::min(sums.least_shape, shapes[t]);
          FaceSums face{1, {}, triangle.min_angle};
          face.area.add(triangle.area);
          sums.all.add(face);
          sums.faces.at(mesh.tri_to_entity[t]).add(face);
        }
        result = std::move(sums);
      });
  TriangleSums total;
  for (const TriangleSums& sums : of_blocks) total.add(sums);
  return total;
}

TriangleQuality measure_triangles(const Mesh& mesh, const BlockLoop& loop, GrowingArray<float>& shapes) {
  TriangleQuality result;
  result.count = mesh.tri_to_vert.size();
  if (result.count == 0) return result;
  shapes.resize_for_overwrite(result.count);
  const TriangleSums sums = sum_triangles(mesh, loop, shapes);
  result.shape_min = sums.least_shape;
  result.shape_p1 = detail::quantile(shapes.span(), 0.01, loop);
  result.shape_mean = sums.shape.value() / static_cast<double>(result.count);
  result.min_angle_deg = sums.all.min_angle * kDegrees;
  result.area = sums.all.area.value();
  for (const auto& [face, of_face] : sums.faces.items())
    result.faces.push_back({face, of_face.triangles, of_face.area.value(), of_face.min_angle * kDegrees});
  return result;
}

}  // namespace

QualityReport compute_quality(const Mesh& mesh, const SizeField* sizes, const BlockLoop& loop) {
  QualityValues values;
  return compute_quality(mesh, sizes, loop, values);
}

QualityReport compute_quality(const Mesh& mesh, const SizeField* sizes, const BlockLoop& loop, QualityValues& values,
                              const MeasuredEdges& measured) {
  require_consistent(mesh, loop);
  QualityReport report;
  CellSums of_tets;
  report.tets = measure_tets(mesh, loop, of_tets, values.mean_ratios);
  report.cells = measure_cells(mesh, of_tets, loop, values.jacobians);
  report.triangles = measure_triangles(mesh, loop, values.shapes);
  report.curved = measure_curved(mesh, report.cells.volume, loop);
  const std::vector<double> point_size = sizes_at_points(mesh, sizes, loop);
  const EdgeMeter meter(mesh.points, point_size);
  report.tets.edges = meter.measure_all(mesh.tet_to_vert, measured, measured.more_of_tets, loop);
  report.triangles.edges = meter.measure_all(mesh.tri_to_vert, measured, measured.more_of_triangles, loop);
  return report;
}

}  // namespace tetloom
