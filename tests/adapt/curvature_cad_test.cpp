// Curvature limits on models of OpenCASCADE.
#include <catch2/catch.hpp>

#include "tests/adapt/uniform_metric.hpp"
#include "tests/cad/cad_samples.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/metric.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

/// The facets of all faces, by their face.
Mesh facets_of(const GeometricModel& model) {
  Mesh mesh;
  for (std::uint32_t face = 0; face < model.topology().face_count(); ++face) {
    const Tessellation facets = model.face_geometry(ModelFaceId(face))->tessellate(0.1, 0.3);
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), facets.points.begin(), facets.points.end());
    for (const auto& tri : facets.tri_to_vert) {
      mesh.tri_to_vert.push_back({first + tri[0], first + tri[1], first + tri[2]});
      mesh.tri_to_entity.push_back(face);
    }
  }
  return mesh;
}

double size_along(const MetricField& metric, std::size_t vert, const Vec3& direction) {
  return std::sqrt(norm2(direction) / dot(metric.at(vert), direction));
}

}  // namespace

TEST_CASE("the metric follows a cylinder of a CAD file, and the same as a B-spline", "[curvature_limits]") {
  const test::TemporaryFolder folder;
  for (const test::Sample sample : {test::Sample::Cylinder, test::Sample::SplineSolid}) {
    test::write_sample(sample, folder / "x.brep");
    const auto model = std::move(read_model(folder / "x.brep").model);
    const Mesh mesh = facets_of(*model);
    MetricField metric = test::uniform_metric(mesh, 4);
    limit_by_curvature(metric, mesh, *model, {24, 0}, TaskRunner(2));
    std::vector<Box3> boxes(model->topology().face_count());
    std::vector<std::uint32_t> point_to_face(mesh.points.size(), kNone);
    for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
      for (const std::uint32_t v : mesh.tri_to_vert[t]) {
        point_to_face[v] = mesh.tri_to_entity[t];
        boxes[mesh.tri_to_entity[t]].add(mesh.points[v]);
      }
    std::size_t curved = 0;
    for (std::size_t v = 0; v < mesh.points.size(); ++v) {
      if (point_to_face[v] == kNone) continue;
      const Vec3 p = mesh.points[v];
      const Box3& box = boxes[point_to_face[v]];
      const bool on_side = box.hi.z - box.lo.z > 1;
      curved += on_side;
      CHECK(size_along(metric, v, {-p.y, p.x, 1e-9}) == Approx(on_side ? 6 * 5 / 24. : 4).epsilon(1e-3));
      CHECK(size_along(metric, v, {0, 0, 1}) == Approx(4).epsilon(1e-3));
    }
    CHECK(curved > 16);
  }
}

TEST_CASE("the metric follows a torus in both directions", "[curvature_limits]") {
  const test::TemporaryFolder folder;
  test::write_sample(test::Sample::Torus, folder / "x.brep");
  const auto model = std::move(read_model(folder / "x.brep").model);
  const Mesh mesh = facets_of(*model);
  MetricField metric = test::uniform_metric(mesh, 1e6);
  CHECK(limit_by_curvature(metric, mesh, *model, {24, 0}, TaskRunner(2)) == mesh.points.size());
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    const Vec3 p = mesh.points[v];
    const double rho = std::hypot(p.x, p.y);
    const Vec3 around{-p.y / rho, p.x / rho, 0}, outwards{p.x / rho, p.y / rho, 0};
    const Vec3 normal = (rho - 10) / 3 * outwards + Vec3{0, 0, p.z / 3};
    const double k1 = 1. / 3, k2 = std::abs((rho - 10) / 3 / rho);  // of the tube, and around the axis
    const double h = 6 / (24 * std::sqrt(k1 * k1 + k1 * k2 + k2 * k2));
    CHECK(size_along(metric, v, cross(normal, around)) == Approx(h).epsilon(1e-3));
    if (k2 > 1e-3) CHECK(size_along(metric, v, around) == Approx(h * k1 / k2).epsilon(1e-2));
  }
}
