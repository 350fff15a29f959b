#include "mesher/sizing/wire_faces.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

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
class Surroundings {
 public:
  Surroundings(const GeometricModel& model, FaceGeometry& own, std::vector<ModelFaceId> neighbors)
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

}  // namespace

// A triangle of edge h = 6 / (N k) has the area 0.433 h².
double wire_edges_per_turn(const std::vector<double>& weights, double wanted) {
  constexpr double kMostTriangles = 150'000, kFarTooMany = 4, kLeastPerTurn = 8;
  const double per_square = 1 / (0.433 * 36);  // triangles per weight and squared number of edges per turn
  double weight = 0;
  for (const double w : weights) weight += w;
  const double affordable = weight > 0 ? std::sqrt(kMostTriangles / (per_square * weight)) : wanted;
  const double edges = std::min(wanted, std::max(kLeastPerTurn, affordable));
  return per_square * weight * edges * edges <= kFarTooMany * kMostTriangles ? edges : 0;
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
  Surroundings surroundings(model_, geometry, neighbors(face));
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
