#include "core/mesh/quality.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>
#include <span>

#include "core/mesh/incidence_detail.hpp"
#include "core/mesh/mesh_access.hpp"
#include "core/predicates/predicates.hpp"

namespace tetloom {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr double kBandLow = 0.707106781, kBandHigh = 1.41421356;

/// Sum with the rounding errors carried along (Neumaier 1974), so that it does not drift over many millions of terms.
class Sum {
 public:
  void add(double x) {
    const double next = total_ + x;
    lost_ += std::abs(total_) >= std::abs(x) ? (total_ - next) + x : (x - next) + total_;
    total_ = next;
  }
  double value() const { return total_ + lost_; }

 private:
  double total_ = 0, lost_ = 0;
};

/// Entries per entity index, found without trusting that indices are small. Elements of an entity tend to follow each
/// other, so the last entry is tried first.
template <class Entry>
class PerEntity {
 public:
  explicit PerEntity(std::initializer_list<std::span<const std::uint32_t>> element_to_entity) {
    for (const std::span<const std::uint32_t> entities : element_to_entity)
      for (const std::uint32_t entity : entities)
        if (keys_.empty() || keys_.back() != entity) keys_.push_back(entity);
    std::sort(keys_.begin(), keys_.end());
    keys_.erase(std::unique(keys_.begin(), keys_.end()), keys_.end());
    entries_.resize(keys_.size());
  }
  Entry& at(std::uint32_t entity) {
    if (keys_[last_] != entity)
      last_ = static_cast<std::size_t>(std::lower_bound(keys_.begin(), keys_.end(), entity) - keys_.begin());
    return entries_[last_];
  }
  std::size_t size() const { return keys_.size(); }
  std::uint32_t key(std::size_t i) const { return keys_[i]; }
  const Entry& entry(std::size_t i) const { return entries_[i]; }

 private:
  std::vector<std::uint32_t> keys_;
  std::vector<Entry> entries_;
  std::size_t last_ = 0;
};

/// The `share` quantile of `values`, interpolated linearly between its neighbours. Reorders `values`.
double quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const double position = share * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(position);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(below);
  std::nth_element(values.begin(), middle, values.end());
  if (below + 1 == values.size()) return *middle;
  const double upper = *std::min_element(middle + 1, values.end());
  return *middle + (position - static_cast<double>(below)) * (upper - *middle);
}

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
    const auto [i, j] = detail::kTetEdge[k];
    shape.dihedral_cosines[k] = -dot(outward[i], outward[j]) * inverse_norm[i] * inverse_norm[j];
  }
  return shape;
}

/// Length and conformity of all unique edges of `elements`.
template <class Element>
EdgeConformity measure_edges(const std::vector<Element>& elements, const std::vector<Vec3>& points,
                             const std::vector<double>& point_size) {
  EdgeConformity result;
  Sum lengths, ratios;
  std::size_t in_band = 0;
  detail::for_each_unique_edge(std::span<const Element>(elements), points.size(),
                               [&](std::uint32_t a, std::uint32_t b) {
                                 const double length = distance(points[a], points[b]);
                                 ++result.edges;
                                 lengths.add(length);
                                 if (point_size.empty()) return;
                                 const double ratio = length / (0.5 * (point_size[a] + point_size[b]));
                                 ratios.add(ratio);
                                 in_band += ratio >= kBandLow && ratio <= kBandHigh;
                               });
  if (result.edges == 0) return result;
  const auto count = static_cast<double>(result.edges);
  result.mean_length = lengths.value() / count;
  result.mean_length_ratio = ratios.value() / count;
  result.in_band = static_cast<double>(in_band) / count;
  return result;
}

/// The size at every point that an element uses; empty without a field.
std::vector<double> sizes_at_points(const Mesh& mesh, const SizeField* sizes) {
  std::vector<double> point_size;
  if (sizes == nullptr) return point_size;
  point_size.assign(mesh.points.size(), 0.0);
  const auto query = [&](const auto& elements) {
    for (const auto& element : elements)
      for (const std::uint32_t v : element)
        if (point_size[v] == 0) point_size[v] = sizes->size_at(mesh.points[v]);
  };
  query(mesh.tet_to_vert);
  query(mesh.tri_to_vert);
  return point_size;
}

double tet_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a) / 6;
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
};

CellQuality measure_cells(const Mesh& mesh, std::size_t inverted_tets) {
  CellQuality result;
  result.inverted = inverted_tets;
  result.count = cell_count(mesh);
  if (result.count == 0) return result;
  PerEntity<RegionSums> regions({mesh.tet_to_entity, mesh.pyramid_to_entity, mesh.prism_to_entity, mesh.hex_to_entity});
  Sum total;
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto& entities) {
    result.counts[static_cast<std::size_t>(kind)] = cells.size();
    for (std::size_t c = 0; c < cells.size(); ++c) {
      const double volume = cell_volume(mesh.points, cells[c], kind);
      total.add(volume);
      RegionSums& region = regions.at(entities[c]);
      ++region.cells;
      region.tets += kind == CellKind::Tet;
      region.volume.add(volume);
      if (kind != CellKind::Tet) result.inverted += is_inverted(mesh.points, cells[c], kind, volume);
    }
  });
  result.volume = total.value();
  for (std::size_t i = 0; i < regions.size(); ++i) {
    const RegionSums& region = regions.entry(i);
    result.regions.push_back({regions.key(i), region.tets, region.cells, region.volume.value()});
  }
  return result;
}

TetQuality measure_tets(const Mesh& mesh, const std::vector<double>& point_size) {
  TetQuality result;
  result.count = mesh.tet_to_vert.size();
  if (result.count == 0) return result;
  const DihedralBins bins;
  std::vector<float> ratios(result.count);
  Sum volume, ratio_sum;
  double largest_cosine = -1;
  for (std::size_t t = 0; t < result.count; ++t) {
    const auto [a, b, c, d] = mesh.tet_to_vert[t];
    const Vec3 &pa = mesh.points[a], &pb = mesh.points[b], &pc = mesh.points[c], &pd = mesh.points[d];
    const TetShape shape = measure_tet(pa, pb, pc, pd);
    // The volume is not finite when a coordinate is not, and the predicate wants finite ones.
    const bool inverted = !std::isfinite(shape.volume) || orient3d(pa, pb, pc, pd) <= 0;
    const double ratio = inverted ? 0 : shape.mean_ratio;
    ratios[t] = static_cast<float>(ratio);
    ratio_sum.add(ratio);
    ++result.mean_ratio_histogram[bin_of<10>(ratio)];
    volume.add(shape.volume);
    if (inverted) {
      ++result.inverted;
      continue;
    }
    for (const double cosine : shape.dihedral_cosines) {
      largest_cosine = std::max(largest_cosine, cosine);
      ++result.dihedral_histogram[bins.find(cosine)];
    }
  }
  result.min_dihedral_deg = result.inverted > 0 ? 0 : std::acos(std::clamp(largest_cosine, -1.0, 1.0)) * kDegrees;
  result.mean_ratio_min = *std::min_element(ratios.begin(), ratios.end());
  result.mean_ratio_p1 = quantile(ratios, 0.01);
  result.mean_ratio_mean = ratio_sum.value() / static_cast<double>(result.count);
  result.volume = volume.value();
  result.edges = measure_edges(mesh.tet_to_vert, mesh.points, point_size);
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
};

TriangleQuality measure_triangles(const Mesh& mesh, const std::vector<double>& point_size) {
  TriangleQuality result;
  result.count = mesh.tri_to_vert.size();
  if (result.count == 0) return result;
  PerEntity<FaceSums> faces({mesh.tri_to_entity});
  std::vector<float> shapes(result.count);
  Sum area, shape_sum;
  double min_angle = std::numbers::pi;
  for (std::size_t t = 0; t < result.count; ++t) {
    const auto [a, b, c] = mesh.tri_to_vert[t];
    const TriangleShape triangle = measure_triangle(mesh.points[a], mesh.points[b], mesh.points[c]);
    shapes[t] = static_cast<float>(triangle.shape);
    shape_sum.add(triangle.shape);
    area.add(triangle.area);
    min_angle = std::min(min_angle, triangle.min_angle);
    FaceSums& face = faces.at(mesh.tri_to_entity[t]);
    ++face.triangles;
    face.area.add(triangle.area);
    face.min_angle = std::min(face.min_angle, triangle.min_angle);
  }
  result.shape_min = *std::min_element(shapes.begin(), shapes.end());
  result.shape_p1 = quantile(shapes, 0.01);
  result.shape_mean = shape_sum.value() / static_cast<double>(result.count);
  result.min_angle_deg = min_angle * kDegrees;
  result.area = area.value();
  for (std::size_t i = 0; i < faces.size(); ++i)
    result.faces.push_back(
        {faces.key(i), faces.entry(i).triangles, faces.entry(i).area.value(), faces.entry(i).min_angle * kDegrees});
  result.edges = measure_edges(mesh.tri_to_vert, mesh.points, point_size);
  return result;
}

}  // namespace

QualityReport compute_quality(const Mesh& mesh, const SizeField* sizes) {
  require_consistent(mesh);
  const std::vector<double> point_size = sizes_at_points(mesh, sizes);
  const TetQuality tets = measure_tets(mesh, point_size);
  return {measure_cells(mesh, tets.inverted), tets, measure_triangles(mesh, point_size)};
}

}  // namespace tetloom
