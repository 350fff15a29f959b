#include "mesher/sizing/wire_faces.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#include "core/base/lists.hpp"
#include "core/geometry/bad_geometry.hpp"
#include "core/sizing/curvature_size.hpp"

namespace tetloom {
namespace {

/// Inside of the face's parameters, or beside them by less than a twentieth of their width.
bool is_within(double value, double lo, double hi, double period) {
  const double margin = 0.05 * (hi - lo);
  if (period > 0) value -= period * std::floor((value - lo + margin) / period);
  return value >= lo - margin && value <= hi + margin;
}

bool passes_by(FaceGeometry& face, const Vec3& point, double distance) {
  const SurfacePoint found = face.closest_point(point, {});
  const ParameterBox box = face.parameter_box();
  const Vec2 period = face.period();
  return found.distance <= distance && is_within(found.uv.u, box.lo.u, box.hi.u, period.u) &&
         is_within(found.uv.v, box.lo.v, box.hi.v, period.v);
}

/// Makes the geometry of the neighbours when the first is asked for.
class FacesAround {
 public:
  FacesAround(const GeometricModel& model, FaceGeometry& own, std::vector<ModelFaceId> neighbors)
      : model_(model), own_(own), neighbors_(std::move(neighbors)) {}

  bool any_passes_by(const Vec3& point, double distance) {
    if (passes_by(own_, point, distance)) return true;
    if (geometries_.empty())
      for (const ModelFaceId face : neighbors_) geometries_.push_back(model_.face_geometry(face));
    return std::any_of(geometries_.begin(), geometries_.end(),
                       [&](const auto& geometry) { return passes_by(*geometry, point, distance); });
  }

 private:
  const GeometricModel& model_;
  FaceGeometry& own_;
  std::vector<ModelFaceId> neighbors_;
  std::vector<std::unique_ptr<FaceGeometry>> geometries_;
};

// Points on a grid over the face's parameters, with triangles between them.
Tessellation grid_over(FaceGeometry& face) {
  constexpr std::uint32_t kCells = 6;
  const ParameterBox box = face.parameter_box();
  Tessellation grid;
  for (std::uint32_t i = 0; i <= kCells; ++i)
    for (std::uint32_t j = 0; j <= kCells; ++j) {
      grid.uv.push_back({box.lo.u + i * (box.hi.u - box.lo.u) / kCells, box.lo.v + j * (box.hi.v - box.lo.v) / kCells});
      grid.points.push_back(face.evaluate(grid.uv.back()));
      if (i == kCells || j == kCells) continue;
      const std::uint32_t corner = i * (kCells + 1) + j, across = corner + kCells + 1;
      grid.tri_to_vert.push_back({corner, across, across + 1});
      grid.tri_to_vert.push_back({corner, across + 1, corner + 1});
    }
  return grid;
}

// Whether the curvature rule asks anywhere, of a few places, for less than the floor.
bool is_thin_somewhere(FaceGeometry& face, const SizeTargets& targets) {
  const ParameterBox box = face.parameter_box();
  for (const double s : {0.17, 0.5, 0.83})
    for (const double t : {0.17, 0.5, 0.83}) {
      const Vec2 uv{box.lo.u + s * (box.hi.u - box.lo.u), box.lo.v + t * (box.hi.v - box.lo.v)};
      if (size_from_curvature(face.curvature(uv), targets.curvature) < targets.floor) return true;
    }
  return false;
}

}  // namespace

std::vector<double> find_wires(const GeometricModel& model, const SizeTargets& targets, double most_triangles,
                               const SharedWork& work) {
  constexpr double kPerTurn = 10;  // with which a cylinder loses 4.5 % of its volume
  constexpr double kThin = 0.5;    // of the size: what asks for less is thin, as a cylinder of .8 sizes
  SizeTargets thin = targets;
  thin.curvature = kPerTurn, thin.floor = kThin * targets.global;
  const WireFinder wires(model, thin);
  const std::vector<double> faces(model.topology().face_count(), 1.0);
  std::vector<double> weights = joined(work.make_lists<double>(faces, [&](std::size_t f) {
    double weight = 0;
    tolerate_bad_geometry([&] {
      const auto geometry = model.face_geometry(ModelFaceId(f));
      if (geometry->parametrization() == Parametrization::Smooth && is_thin_somewhere(*geometry, thin))
        weight = wires.weight(ModelFaceId(f), *geometry, grid_over(*geometry));
    });
    return std::vector{weight};
  }));
  const double edges = wire_edges_per_turn(weights, kPerTurn, {.most_triangles = most_triangles, .least_per_turn = 6});
  if (edges <= 0 || std::ranges::all_of(weights, [](double weight) { return weight <= 0; })) return {};
  for (double& weight : weights) weight = weight > 0 ? edges : 0;
  return weights;
}

// A triangle of edge h = 6 / (N k) has the area 0.433 h².
double wire_edges_per_turn(const std::vector<double>& weights, double wanted, const WireBudget& budget) {
  constexpr double kFarTooMany = 4;
  const double per_square = 1 / (0.433 * 36);  // triangles per weight and squared number of edges per turn
  double weight = 0;
  for (const double w : weights) weight += w;
  const double affordable = weight > 0 ? std::sqrt(budget.most_triangles / (per_square * weight)) : wanted;
  const double edges = std::min(wanted, std::max(budget.least_per_turn, affordable));
  return per_square * weight * edges * edges <= kFarTooMany * budget.most_triangles ? edges : 0;
}

double WireFinder::weight(ModelFaceId face, FaceGeometry& geometry, const Tessellation& facets) const {
  if (!is_wire(face, geometry, facets)) return 0;
  double sum = 0;
  for (const auto& [a, b, c] : facets.tri_to_vert) {
    const Vec3& origin = facets.points[a];
    const PrincipalCurvatures k = geometry.curvature((1.0 / 3) * (facets.uv[a] + facets.uv[b] + facets.uv[c]));
    const double area = 0.5 * norm(cross(facets.points[b] - origin, facets.points[c] - origin));
    const double largest = std::max(std::abs(k.largest), std::abs(k.smallest));
    if (std::isfinite(largest)) sum += area * largest * largest;
  }
  return sum;
}

WireFinder::WireFinder(const GeometricModel& model, const SizeTargets& targets) : model_(model), targets_(targets) {
  const ModelTopology& topology = model.topology();
  edge_to_faces_.resize(topology.edge_count());
  if (targets.curvature <= 0 || !targets.floor_is_default) return;
  for (std::size_t f = 0; f < topology.face_count(); ++f)
    for (const ModelLoop& loop : topology.face_to_loops[f])
      for (const EdgeUse& use : loop) edge_to_faces_[use.edge.value].push_back(ModelFaceId(f));
}

std::vector<ModelFaceId> WireFinder::neighbors(ModelFaceId face) const {
  constexpr std::size_t kMost = 8;
  std::vector<ModelFaceId> found;
  for (const ModelLoop& loop : model_.topology().face_to_loops[face.value])
    for (const EdgeUse& use : loop)
      for (const ModelFaceId other : edge_to_faces_[use.edge.value])
        if (other != face && found.size() < kMost && std::find(found.begin(), found.end(), other) == found.end())
          found.push_back(other);
  return found;
}

bool WireFinder::is_wire(ModelFaceId face, FaceGeometry& geometry, const Tessellation& facets) const {
  const FaceSides& sides = model_.topology().face_to_sides[face.value];
  if (targets_.curvature <= 0 || !targets_.floor_is_default) return false;
  if (geometry.parametrization() != Parametrization::Smooth) return false;
  if (!sides.front.valid() && !sides.back.valid()) return false;
  constexpr std::size_t kSamples = 16;
  constexpr double kNear = 0.1, kShare = 0.6;  // of the radius; of the samples
  FacesAround surroundings(model_, geometry, neighbors(face));
  std::size_t asked = 0, back = 0;
  const std::size_t step = std::max<std::size_t>(1, facets.points.size() / kSamples);
  for (std::size_t i = 0; i < facets.points.size(); i += step) {
    const PrincipalCurvatures k = geometry.curvature(facets.uv[i]);
    const double largest = std::max(std::abs(k.largest), std::abs(k.smallest));
    if (!std::isfinite(largest) || size_from_curvature(k, targets_.curvature) >= targets_.floor) continue;
    const Vec3 across = (2 / largest) * geometry.normal(facets.uv[i]);
    const double near = kNear / largest;
    ++asked;
    if ((sides.back.valid() && surroundings.any_passes_by(facets.points[i] - across, near)) ||
        (sides.front.valid() && surroundings.any_passes_by(facets.points[i] + across, near)))
      ++back;
  }
  return asked > 0 && static_cast<double>(back) >= kShare * static_cast<double>(asked);
}

}  // namespace tetloom
