#include "mesher/sizing/volume_floors.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/sizing/curvature_size.hpp"
#include "mesher/sizing/narrow_entities.hpp"

namespace tetloom {
namespace {

constexpr double kMostLost = 0.005;  // of a solid's volume
// The triangles that all lowered floors together may ask for.
constexpr double kMostTriangles = 300'000;
constexpr double kGivesWay = 1.2;        // by which a solid that is too dear may lose more
constexpr double kTriangleArea = 0.433;  // of edges of length 1

/// The size of a face at the scale `c`: curved faces are finer, but not by much, since what a triangle saves grows with
/// the curvature and its number with the area alone.
double size_at_scale(const CurvedFace& face, double c, double floor) {
  const double curvature = std::abs(face.bend) / face.area;
  return std::clamp(c * std::pow(curvature, -0.25), std::min(face.wish, floor), floor);
}

/// Whether the face becomes any better by the size.
bool helps(const CurvedFace& face, double size, double floor) {
  return size < floor && volume_lost(face, size) < 0.9 * volume_lost(face, floor);
}

/// The sizes of those curved faces of one solid that lose volume, or of those that gain it: the two do not make up for
/// each other where they are apart.
class SolidFloors {
 public:
  /// `sign`: of the curvature, seen from the solid.
  SolidFloors(const GeometricModel& model, ModelRegionId region, int sign, const std::vector<CurvedFace>& faces,
              const std::vector<double>& floors)
      : volume_(std::abs(model.volume(region))), faces_(faces), floors_(floors) {
    for (const ModelFaceId face : model.topology().region_to_faces[region.value]) {
      const FaceSides& sides = model.topology().face_to_sides[face.value];
      if (faces[face.value].area <= 0 || sides.front == sides.back) continue;
      if ((sides.back == region) == (sign * faces[face.value].bend > 0)) members_.push_back(face.value);
    }
  }

  /// The scale at which no more than the share `most` of the volume is lost, or nearly as little as can be; infinite
  /// where every scale will do.
  double find_scale(double most) const {
    constexpr double kNearly = 1.05;
    const double allowed = std::max(most * volume_, kNearly * lost(0));
    if (!(volume_ > 0) || lost(HUGE_VAL) <= allowed) return HUGE_VAL;
    double low = 0, high = 0;
    for (const std::uint32_t f : members_)
      high = std::max(high, floors_[f] * std::pow(std::abs(faces_[f].bend) / faces_[f].area, 0.25));
    constexpr int kSteps = 20;
    for (int i = 0; i < kSteps; ++i) (lost(0.5 * (low + high)) <= allowed ? low : high) = 0.5 * (low + high);
    return low;
  }

  /// The triangles that the sizes of a scale ask for on the faces that become better.
  double count_triangles(double c) const {
    double triangles = 0;
    for_each_better(c,
                    [&](std::uint32_t f, double size) { triangles += faces_[f].area / (kTriangleArea * size * size); });
    return triangles;
  }

  void lower(double c, std::vector<double>& floors) const {
    for_each_better(c, [&](std::uint32_t f, double size) { floors[f] = std::min(floors[f], size); });
  }

 private:
  template <class Visit>
  void for_each_better(double c, const Visit& visit) const {
    for (const std::uint32_t f : members_) {
      const double floor = floors_[f], size = size_at_scale(faces_[f], c, floor);
      if (helps(faces_[f], size, floor)) visit(f, size);
    }
  }

  double lost(double c) const {
    double sum = 0;
    for (const std::uint32_t f : members_) sum += volume_lost(faces_[f], size_at_scale(faces_[f], c, floors_[f]));
    return sum;
  }

  double volume_;
  const std::vector<CurvedFace>& faces_;
  const std::vector<double>& floors_;
  std::vector<std::uint32_t> members_;  // faces
};

}  // namespace

double volume_lost(const CurvedFace& face, double size) {
  return std::abs(face.bend) * std::min(size * size / 16, face.width * face.width / 12);
}

// The dearest solids give way first.
std::vector<double> lower_floors_for_volumes(const GeometricModel& model, const std::vector<CurvedFace>& faces,
                                             std::vector<double> floors) {
  std::vector<SolidFloors> solids;
  std::vector<double> most, triangles;
  double all = 0;
  for (std::size_t r = 0; r < model.topology().region_count(); ++r)
    for (const int sign : {1, -1}) {
      const SolidFloors& solid = solids.emplace_back(model, ModelRegionId(r), sign, faces, floors);
      most.push_back(kMostLost);
      triangles.push_back(solid.count_triangles(solid.find_scale(kMostLost)));
      all += triangles.back();
    }
  while (all > kMostTriangles) {
    const auto dearest = static_cast<std::size_t>(std::ranges::max_element(triangles) - triangles.begin());
    most[dearest] *= kGivesWay;
    const double fewer = solids[dearest].count_triangles(solids[dearest].find_scale(most[dearest]));
    all += fewer - std::exchange(triangles[dearest], fewer);
  }
  std::vector<double> lowered = floors;
  for (std::size_t i = 0; i < solids.size(); ++i) solids[i].lower(solids[i].find_scale(most[i]), lowered);
  return lowered;
}

CurvedFace measure_curved_face(const GeometricModel& model, ModelFaceId face, FaceGeometry& geometry,
                               const Tessellation& facets, double edges_per_turn, double floor) {
  if (geometry.parametrization() != Parametrization::Smooth || facets.tri_to_vert.empty()) return {};
  constexpr std::size_t kSamples = 16;
  const std::size_t step = (facets.tri_to_vert.size() + kSamples - 1) / kSamples;
  CurvedFace curved{.wish = HUGE_VAL};
  double bend = 0, sampled = 0;
  for (std::size_t t = 0; t < facets.tri_to_vert.size(); ++t) {
    const auto& [a, b, c] = facets.tri_to_vert[t];
    const double area = 0.5 * norm(cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a]));
    curved.area += area;
    if (t % step != 0) continue;
    const PrincipalCurvatures k = geometry.curvature((1.0 / 3) * (facets.uv[a] + facets.uv[b] + facets.uv[c]));
    if (!std::isfinite(k.largest) || !std::isfinite(k.smallest)) continue;
    curved.wish = std::min(curved.wish, size_from_curvature(k, edges_per_turn));
    bend += area * (k.largest + k.smallest);
    sampled += area;
  }
  if (!(curved.wish < floor) || !(sampled > 0) || bend == 0) return {};
  curved.bend = bend * curved.area / sampled;
  curved.width = mean_width(model, face, facets);
  return curved;
}

}  // namespace tetloom
