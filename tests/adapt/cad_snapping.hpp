#pragma once
// Meshes of CAD models whose sizes halve again and again, for tests of how boundaries follow.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

#include "tests/adapt/meshed.hpp"
#include "tests/adapt/uniform_metric.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/check.hpp"

namespace tetloom::test {

/// How far boundaries of meshes lie from a model.
class Boundary {
 public:
  explicit Boundary(const GeometricModel& model)
      : model_(model), faces_(model.topology().face_count()), edges_(model.topology().edge_count()) {}

  /// How far vertices lie from what they are classified on, over what that may be off by: at most 1 where all lie on
  /// it.
  double farthest(const Mesh& mesh) {
    double most = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      const ModelEntity entity = mesh.point_to_entity[v];
      if (entity.dim > 2) continue;
      // Kernels compute places to 1e-7 of what they model in the unit that they keep it in.
      const double allowed = std::max(model_.attributes(entity).tolerance, 1e-7);
      most = std::max(most, distance_to(entity, mesh.points[v]) / allowed);
    }
    return most;
  }

  /// The volume between the triangles of model faces and the faces themselves, on whichever side. Distances vanish at
  /// the corners of a triangle and are quadratic in it to leading order: their mean is that at the middles of its
  /// edges.
  double volume_between(const Mesh& mesh) {
    double sum = 0;
    for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
      const auto [a, b, c] = mesh.tri_to_vert[t];
      const Vec3 &x = mesh.points[a], &y = mesh.points[b], &z = mesh.points[c];
      const ModelEntity face(2, mesh.tri_to_entity[t]);
      double distances = 0;
      for (const Vec3& middle : {0.5 * (x + y), 0.5 * (y + z), 0.5 * (z + x)}) distances += distance_to(face, middle);
      sum += 0.5 * norm(cross(y - x, z - x)) * distances / 3;
    }
    return sum;
  }

 private:
  struct Face {
    std::unique_ptr<FaceGeometry> geometry;
    std::optional<Vec2> last;
  };

  double distance_to(ModelEntity entity, const Vec3& x) {
    if (entity.dim == 0) return distance(model_.vertex_point(ModelVertexId(entity.index)), x);
    if (entity.dim == 1) {
      auto& edge = edges_[entity.index];
      if (!edge) edge = model_.edge_geometry(ModelEdgeId(entity.index));
      return edge->closest_point(x).distance;
    }
    Face& face = faces_[entity.index];
    if (!face.geometry) face.geometry = model_.face_geometry(ModelFaceId(entity.index));
    // What lies near the last place is found from there; what seems far is searched for all over.
    SurfacePoint found = face.geometry->closest_point(x, face.last);
    if (face.last && found.distance > 1e-8) found = face.geometry->closest_point(x, std::nullopt);
    face.last = found.uv;
    return found.distance;
  }

  const GeometricModel& model_;
  std::vector<Face> faces_;
  std::vector<std::unique_ptr<EdgeGeometry>> edges_;
};

/// Meshes the model with size `h`, then leads the mesh to half the size, `times` over: valid meshes without inverted
/// tets, all of the boundary on the model, and volumes that converge at second order, also where what a mesh lacks at
/// one face is what it has too much at another, as inside and outside of a pipe. Prints a table.
inline void check_halvings(const std::string& name, const GeometricModel& model, double h, int times) {
  double volume = 0;
  for (std::uint32_t region = 0; region < model.topology().region_count(); ++region)
    volume += model.volume(ModelRegionId(region));
  Mesh mesh = meshed(model, h);
  Boundary boundary(model);
  const auto volume_off = [&] {
    return std::max(std::abs(volume_of(mesh) - volume), boundary.volume_between(mesh)) / volume;
  };
  double last = volume_off(), bound = 0.5 * last;
  std::printf("%s: %zu tets, volume off by %.2e\n", name.c_str(), mesh.tet_to_vert.size(), last);
  for (int i = 0; i < times; ++i) {
    h /= 2;
    CAPTURE(name, i, h);
    AdaptOptions adapt_options;
    adapt_options.model = &model;
    const auto metric = test::uniform_metric(mesh, h);
    AdaptResult result = adapt_mesh(mesh, metric, adapt_options);
    for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
    REQUIRE(result.status == AdaptStatus::Ok);
    mesh = std::move(result.mesh);
    const ValidationReport validation = validate_mesh(mesh);
    for (const MeshProblem& problem : validation.problems) FAIL_CHECK(problem.message);
    const double off = volume_off(), farthest = boundary.farthest(mesh);
    std::printf(
        "  h %.4g: %8zu tets, volume off by %.2e (%.2f times less), boundary at %.1e of its tolerance, unit %.2f %%, "
        "mean ratio at least %.3f\n",
        h, mesh.tet_to_vert.size(), off, last / off, farthest, 100 * result.report.after.unit,
        result.report.after.least_quality);
    std::fflush(stdout);
    CHECK(farthest <= 1);
    CHECK(off <= bound);
    if (i + 1 == times) CHECK(last >= 3.5 * off);
    // The first mesh may be too coarse to show a shape; from the second on the error falls with the square of the size.
    bound = (i == 0 ? 1.5 * off : bound) / 4;
    last = off;
  }
}

}  // namespace tetloom::test
