#include "bench/support/surface_distance.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>

namespace tetloom::bench {

double surface_distance(const Mesh& mesh, const GeometricModel& model, std::size_t most) {
  std::map<std::uint32_t, std::unique_ptr<FaceGeometry>> faces;
  const std::size_t count = mesh.tri_to_vert.size(), step = std::max<std::size_t>(1, count / most);
  double largest = 0;
  for (std::size_t t = 0; t < count; t += step) {
    const std::uint32_t face = mesh.tri_to_entity[t];
    if (face >= model.topology().face_count()) continue;
    std::unique_ptr<FaceGeometry>& geometry = faces[face];
    if (!geometry) geometry = model.face_geometry(ModelFaceId(face));
    const auto& [i, j, k] = mesh.tri_to_vert[t];
    const Vec3 &a = mesh.points[i], &b = mesh.points[j], &c = mesh.points[k];
    const double edge = std::max({distance(a, b), distance(b, c), distance(c, a)});
    if (edge > 0) largest = std::max(largest, geometry->closest_point((a + b + c) / 3, std::nullopt).distance / edge);
  }
  return largest;
}

}  // namespace tetloom::bench
