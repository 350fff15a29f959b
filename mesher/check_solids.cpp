#include "mesher/check_solids.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "core/mesh/mid_nodes.hpp"
#include "core/spatial/distances.hpp"
#include "mesher/complexes.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {
namespace {

constexpr double kTolerated = 0.01;  // of a solid's volume
constexpr double kTouching = 0.25;   // sizes: what lies deeper in a solid does not touch it
constexpr std::size_t kMostFacesNamed = 10;
constexpr std::size_t kMostAsked = 1000;  // points of one solid
constexpr std::size_t kPointsPerTask = 256;

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

// Vertices and mid nodes of a surface element, seen from `origin`.
template <std::size_t N>
std::array<Vec3, 2 * N> nodes_of(const Mesh& mesh, const MidNodes& mids, const std::array<std::uint32_t, N>& verts,
                                 const Vec3& origin) {
  std::array<Vec3, 2 * N> nodes;
  for (std::size_t i = 0; i < N; ++i) {
    const std::uint32_t a = verts[i], b = verts[(i + 1) % N];
    nodes[i] = mesh.points[a] - origin;
    nodes[N + i] = (mids.empty() ? 0.5 * (mesh.points[a] + mesh.points[b]) : mesh.points[mids.point(a, b)]) - origin;
  }
  return nodes;
}

std::array<Vec3, 3> corners_of(const Mesh& mesh, std::size_t triangle) {
  const auto& [a, b, c] = mesh.tri_to_vert[triangle];
  return {mesh.points[a], mesh.points[b], mesh.points[c]};
}

// A third of the integral of dot(x, dx/du × dx/dv) over a triangle with mid nodes: of degree 4, as is the quadrature
// (Dunavant 1985).
double volume_below(const std::array<Vec3, 6>& nodes) {
  constexpr std::array<std::array<double, 2>, 2> kRings{
      {{0.445948490915965, 0.223381589678011}, {0.091576213509771, 0.109951743655322}}};  // coordinate, weight
  double sum = 0;
  for (const auto& [coordinate, weight] : kRings)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      std::array<double, 3> l{coordinate, coordinate, coordinate};
      l[corner] = 1 - 2 * coordinate;
      Vec3 x, along_u, along_v;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + 1) % 3;
        x += l[i] * (2 * l[i] - 1) * nodes[i] + 4 * l[i] * l[j] * nodes[3 + i];
        const auto slope = [&](std::size_t k) {  // by coordinate k, of this vertex and of the mid node behind it
          return (k == i ? 4 * l[i] - 1 : 0) * nodes[i] +
                 4 * ((k == i ? l[j] : 0) + (k == j ? l[i] : 0)) * nodes[3 + i];
        };
        along_u += slope(1) - slope(0);
        along_v += slope(2) - slope(0);
      }
      sum += weight * dot(x, cross(along_u, along_v));
    }
  return sum / 6;
}

double volume_below(const std::array<Vec3, 3>& corners) { return dot(corners[0], cross(corners[1], corners[2])) / 6; }

// The same of a quadrilateral with mid nodes, of degree 5 along each side.
double volume_below(const std::array<Vec3, 8>& nodes) {
  constexpr std::array<std::array<double, 2>, 3> kPoints{
      {{-0.774596669241483, 5.0 / 9}, {0, 8.0 / 9}, {0.774596669241483, 5.0 / 9}}};  // coordinate, weight (Gauss)
  constexpr std::array<std::array<double, 2>, 4> kCorners{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  double sum = 0;
  for (const auto& [u, weight_u] : kPoints)
    for (const auto& [v, weight_v] : kPoints) {
      Vec3 x, along_u, along_v;
      const auto add = [&](const Vec3& node, double value, double by_u, double by_v) {
        x += value * node, along_u += by_u * node, along_v += by_v * node;
      };
      for (std::size_t i = 0; i < 4; ++i) {
        const auto [a, b] = kCorners[i];
        add(nodes[i], 0.25 * (1 + a * u) * (1 + b * v) * (a * u + b * v - 1),
            0.25 * a * (1 + b * v) * (2 * a * u + b * v), 0.25 * b * (1 + a * u) * (2 * b * v + a * u));
        const auto [c, d] = kCorners[(i + 1) % 4];
        if (a == c)
          add(nodes[4 + i], 0.5 * (1 + a * u) * (1 - v * v), 0.5 * a * (1 - v * v), -v * (1 + a * u));
        else
          add(nodes[4 + i], 0.5 * (1 - u * u) * (1 + b * v), -u * (1 + b * v), 0.5 * b * (1 - u * u));
      }
      sum += weight_u * weight_v * dot(x, cross(along_u, along_v));
    }
  return sum / 3;
}

// What the triangles and quadrilaterals of each region bound, measured from the middle of them all; NaN where there are
// none.
std::vector<double> volumes_of(const MeshedModel& meshed) {
  const ModelTopology& topology = meshed.model.topology();
  std::vector<double> volumes(topology.region_count(), std::numeric_limits<double>::quiet_NaN());
  const auto add = [&](ModelRegionId region, double volume) {
    if (!region.valid()) return;
    double& sum = volumes[region.value];
    sum = std::isnan(sum) ? volume : sum + volume;
  };
  const Box3 box = box_of(meshed.surface.points);
  const Vec3 middle = box.center();
  const MidNodes mids(meshed.surface);
  const auto volume_of = [&]<std::size_t N>(const std::array<std::uint32_t, N>& verts) {
    if constexpr (N == 3) {
      const auto at = [&](std::size_t i) { return meshed.surface.points[verts[i]] - middle; };
      if (mids.empty()) return volume_below(std::array{at(0), at(1), at(2)});
    }
    return volume_below(nodes_of(meshed.surface, mids, verts, middle));
  };
  for_each_surface_kind(meshed.surface, [&](const auto& elements, const auto& faces) {
    for (std::size_t e = 0; e < elements.size(); ++e) {
      const FaceSides& sides = topology.face_to_sides[faces[e]];
      const double volume = volume_of(elements[e]);
      add(sides.back, volume);
      add(sides.front, -volume);
    }
  });
  return volumes;
}

std::vector<bool> regions_with_triangles(const MeshedModel& meshed) {
  const ModelTopology& topology = meshed.model.topology();
  std::vector<bool> found(topology.region_count(), false);
  for (const std::uint32_t face : meshed.surface.tri_to_entity) {
    const FaceSides& sides = topology.face_to_sides[face];
    for (const ModelRegionId region : {sides.front, sides.back})
      if (region.valid()) found[region.value] = true;
  }
  return found;
}

struct MeasuredFace {
  double area = 0, largest = 0;  // largest: the area of the largest triangle
  Vec3 point;                    // its centre
};

std::vector<MeasuredFace> measure_faces(const MeshedModel& meshed) {
  std::vector<MeasuredFace> faces(meshed.model.topology().face_count());
  for (std::size_t t = 0; t < meshed.surface.tri_to_vert.size(); ++t) {
    const auto [a, b, c] = corners_of(meshed.surface, t);
    const double area = 0.5 * norm(cross(b - a, c - a));
    MeasuredFace& face = faces[meshed.surface.tri_to_entity[t]];
    face.area += area;
    if (area <= face.largest) continue;
    face.largest = area;
    face.point = (1.0 / 3) * (a + b + c);
  }
  return faces;
}

double model_area(const GeometricModel& model, ModelFaceId face) {
  try {
    return model.area(face);
  } catch (const Error&) {
    return 0;  // what cannot be measured comes first
  }
}

// The region, and its faces by how much their areas differ from the model's.
void place(const MeshedModel& meshed, const std::vector<MeasuredFace>& faces, ModelRegionId region,
           Diagnostic& diagnostic) {
  std::vector<std::pair<double, ModelFaceId>> worst;
  for (const ModelFaceId face : meshed.model.topology().region_to_faces[region.value])
    worst.emplace_back(-std::abs(faces[face.value].area - model_area(meshed.model, face)), face);
  std::ranges::sort(worst, [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : a.second.value < b.second.value;
  });
  diagnostic.entities.push_back(meshed.model.named(region));
  if (worst.size() > kMostFacesNamed) worst.resize(kMostFacesNamed);
  for (const auto& [difference, face] : worst) diagnostic.entities.push_back(meshed.model.named(face));
  if (!worst.empty()) diagnostic.point = faces[worst[0].second.value].point;
}

std::optional<Diagnostic> judge_volume(double mesh, double model, const std::string& region) {
  if (mesh < 0) {
    return Diagnostic{ErrorCode::RegionInsideOut,
                      "the boundary of " + region + " is inside out: it bounds a volume of " + number(mesh),
                      {},
                      {},
                      {}};
  }
  const double difference = mesh - model;
  if (!(std::abs(difference) > kTolerated * std::abs(model))) return std::nullopt;
  const std::string share = model != 0 ? " (" + number(100 * difference / std::abs(model)) + " %)" : "";
  return Diagnostic{
      ErrorCode::VolumeDiffers,
      "the mesh of " + region + " has a volume of " + number(mesh) + " where the model has " + number(model) + share,
      {},
      {},
      {}};
}

// Which solid, if any, a point of the surface of another lies in.
class OverlapSearch {
 public:
  OverlapSearch(const MeshedModel& meshed, const TaskRunner& runner)
      : meshed_(meshed),
        sides_(meshed.model.topology().face_to_sides),
        complexes_(find_complexes(meshed.model.topology())),
        tree_(meshed.surface.points, meshed.surface.tri_to_vert, runner) {
    const Mesh& mesh = meshed.surface;
    boxes_.resize(complexes_.empty() ? 0 : std::ranges::max(complexes_) + std::size_t{1});
    point_to_triangle_.assign(mesh.points.size(), kNone);
    for (std::uint32_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
      if (!is_of_solid(mesh.tri_to_entity[t])) continue;
      for (const std::uint32_t v : mesh.tri_to_vert[t]) {
        boxes_[complex_of(t)].add(mesh.points[v]);
        point_to_triangle_[v] = std::min(point_to_triangle_[v], t);
      }
    }
    find_neighbors();
  }

  /// Points of solids that lie in the box of another: all, or evenly chosen ones of solids with many.
  std::vector<std::uint32_t> points_to_ask() const {
    std::vector<std::vector<std::uint32_t>> of_complex(boxes_.size());
    for (std::uint32_t v = 0; v < point_to_triangle_.size(); ++v) {
      if (point_to_triangle_[v] == kNone) continue;
      const std::uint32_t complex = complex_of(point_to_triangle_[v]);
      if (is_in_neighbor_box(complex, meshed_.surface.points[v])) of_complex[complex].push_back(v);
    }
    std::vector<std::uint32_t> chosen;
    for (const auto& points : of_complex) {
      const std::size_t step = (points.size() + kMostAsked - 1) / kMostAsked;
      for (std::size_t i = 0; i < points.size(); i += step) chosen.push_back(points[i]);
    }
    return chosen;
  }
  std::uint32_t triangle_at(std::size_t point) const { return point_to_triangle_[point]; }

  /// The lowest region that point `v` of the surface lies deep inside of; invalid: none.
  ModelRegionId region_around(std::size_t v) const {
    const std::uint32_t own = point_to_triangle_[v];
    const Vec3& x = meshed_.surface.points[v];
    std::map<std::uint32_t, int> windings;  // of surfaces of other solids above the point, by region
    tree_.for_each_above(x, [&](std::uint32_t t, bool up) {
      if (complex_of(t) == complex_of(own)) return;
      const FaceSides& sides = sides_[meshed_.surface.tri_to_entity[t]];
      const ModelRegionId below = up ? sides.back : sides.front, above = up ? sides.front : sides.back;
      if (below.valid()) ++windings[below.value];
      if (above.valid()) --windings[above.value];
    });
    for (const auto& [region, winding] : windings)
      if (winding > 0 && is_deep(x, region)) return ModelRegionId(region);
    return {};
  }

 private:
  bool is_of_solid(std::uint32_t face) const { return sides_[face].front.valid() || sides_[face].back.valid(); }
  std::uint32_t complex_of(std::uint32_t triangle) const { return complexes_[meshed_.surface.tri_to_entity[triangle]]; }

  // Sweeps along x; of n solids side by side few are compared.
  void find_neighbors() {
    std::vector<std::uint32_t> order, reaching;
    for (std::uint32_t c = 0; c < boxes_.size(); ++c)
      if (!boxes_[c].empty()) order.push_back(c);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t c) { return boxes_[c].lo.x; });
    neighbors_.resize(boxes_.size());
    for (const std::uint32_t c : order) {
      std::erase_if(reaching, [&](std::uint32_t other) { return boxes_[other].hi.x < boxes_[c].lo.x; });
      for (const std::uint32_t other : reaching) {
        if (!boxes_[c].overlaps(boxes_[other])) continue;
        neighbors_[c].push_back(other), neighbors_[other].push_back(c);
      }
      reaching.push_back(c);
    }
  }

  bool is_in_neighbor_box(std::uint32_t complex, const Vec3& x) const {
    return std::ranges::any_of(neighbors_[complex], [&](std::uint32_t other) { return boxes_[other].contains(x); });
  }

  bool is_deep(const Vec3& x, std::uint32_t region) const {
    const double reach = kTouching * meshed_.sizes.size_at(x);
    const Vec3 extent{reach, reach, reach};
    bool touches = false;
    tree_.for_each_in({x - extent, x + extent}, [&](std::uint32_t t) {
      const FaceSides& sides = sides_[meshed_.surface.tri_to_entity[t]];
      if (touches || (sides.front.value != region && sides.back.value != region)) return;
      const auto [a, b, c] = corners_of(meshed_.surface, t);
      touches = distance_to_triangle(x, a, b, c) < reach;
    });
    return !touches;
  }

  const MeshedModel& meshed_;
  const std::vector<FaceSides>& sides_;
  std::vector<std::uint32_t> complexes_;  // per face
  intersection::TriangleTree tree_;
  std::vector<Box3> boxes_;                            // per complex; empty for sheets
  std::vector<std::vector<std::uint32_t>> neighbors_;  // per complex: those whose boxes overlap its own
  std::vector<std::uint32_t> point_to_triangle_;       // the first of a solid that has the point
};

Diagnostic describe_overlap(const MeshedModel& meshed, std::pair<std::uint32_t, std::uint32_t> regions,
                            std::uint32_t face, const Vec3& point) {
  const NamedEntity one = meshed.model.named(ModelRegionId(regions.first)),
                    other = meshed.model.named(ModelRegionId(regions.second));
  return {ErrorCode::RegionsOverlap,
          describe(one) + " and " + describe(other) + " lie in each other, and are meshed each on its own",
          {one, other, meshed.model.named(ModelFaceId(face))},
          point,
          {}};
}

}  // namespace

std::vector<Diagnostic> check_volumes(const MeshedModel& meshed, std::span<const double> model_volumes) {
  const std::vector<double> volumes = volumes_of(meshed);
  const std::vector<bool> is_meshed = regions_with_triangles(meshed);
  std::optional<std::vector<MeasuredFace>> faces;
  std::vector<Diagnostic> warnings;
  for (std::uint32_t r = 0; r < volumes.size(); ++r) {
    const ModelRegionId region(r);
    if (!is_meshed[r]) continue;
    auto warning = judge_volume(volumes[r], model_volumes[r], describe(meshed.model.named(region)));
    if (!warning) continue;
    if (!faces) faces = measure_faces(meshed);
    place(meshed, *faces, region, *warning);
    warnings.push_back(std::move(*warning));
  }
  return warnings;
}

std::vector<Diagnostic> check_overlaps(const MeshedModel& meshed, const TaskRunner& runner) {
  std::vector<Diagnostic> warnings;
  if (meshed.model.topology().region_count() < 2) return warnings;
  const OverlapSearch search(meshed, runner);
  const Mesh& mesh = meshed.surface;
  const std::vector<std::uint32_t> points = search.points_to_ask();
  std::vector<ModelRegionId> around(points.size());
  runner.for_blocks(points.size(), kPointsPerTask, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) around[i] = search.region_around(points[i]);
  });
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> first;  // point, by regions
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!around[i].valid()) continue;
    const FaceSides& sides = meshed.model.topology().face_to_sides[mesh.tri_to_entity[search.triangle_at(points[i])]];
    const std::uint32_t own = sides.back.valid() ? sides.back.value : sides.front.value;
    first.emplace(std::minmax(own, around[i].value), points[i]);
  }
  for (const auto& [regions, v] : first)
    warnings.push_back(describe_overlap(meshed, regions, mesh.tri_to_entity[search.triangle_at(v)], mesh.points[v]));
  return warnings;
}

}  // namespace tetloom
