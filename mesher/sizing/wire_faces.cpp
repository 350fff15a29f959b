#include "mesher/sizing/wire_faces.hpp"

#include <algorithm>
#include <cmath>

#include "mesher/sizing/curvature_size.hpp"

namespace tetloom {
namespace {

/// Does the face come back to where the far end of the curvature's diameter is?
bool comes_back(FaceGeometry& face, const Vec3& point, const Vec3& inward, double curvature) {
  constexpr double kNear = 0.2;  // of the radius
  const double radius = 1 / curvature;
  return face.closest_point(point + 2 * radius * inward, {}).distance <= kNear * radius;
}

}  // namespace

bool encloses_wire(FaceGeometry& face, const FaceSides& sides, const Tessellation& facets, const SizeTargets& targets) {
  if (targets.curvature <= 0 || (!sides.front.valid() && !sides.back.valid())) return false;
  constexpr std::size_t kSamples = 24;
  const std::size_t step = std::max<std::size_t>(1, facets.points.size() / kSamples);
  for (std::size_t i = 0; i < facets.points.size(); i += step) {
    const PrincipalCurvatures k = face.curvature(facets.uv[i]);
    const double largest = std::max(std::abs(k.largest), std::abs(k.smallest));
    if (!std::isfinite(largest) || size_from_curvature(k, targets.curvature) >= targets.floor) continue;
    const Vec3 normal = face.normal(facets.uv[i]);
    if (sides.back.valid() && comes_back(face, facets.points[i], -normal, largest)) return true;
    if (sides.front.valid() && comes_back(face, facets.points[i], normal, largest)) return true;
  }
  return false;
}

}  // namespace tetloom
