// Layers on curved faces beside walls.
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>

#include "mesher/surface/face_plane.hpp"
#include "mesher/surface/rim_mesh.hpp"
#include "tests/mesher/layers_fixture.hpp"

using namespace tetloom;
using namespace tetloom::test_layers;
using namespace tetloom::test_models;

namespace {

constexpr std::uint32_t kSide = 0, kBottom = 1;  // of cylinders and cones

// Whether everything on the face lies on the surface where `distance` is 0, and quadrilaterals are there.
void check_side(const Mesh& mesh, std::uint32_t face, std::size_t least_quads,
                const std::function<double(const Vec3&)>& distance) {
  double farthest = 0;
  std::size_t quads = 0;
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    if (mesh.point_to_entity[p] == ModelEntity(2, face))
      farthest = std::max(farthest, std::abs(distance(mesh.points[p])));
  for (std::size_t q = 0; q < mesh.quad_to_vert.size(); ++q) {
    if (mesh.quad_to_entity[q] != face) continue;
    ++quads;
    for (const std::uint32_t v : mesh.quad_to_vert[q])
      farthest = std::max(farthest, std::abs(distance(mesh.points[v])));
  }
  CHECK(farthest < 1e-9);
  CHECK(quads >= least_quads);
}

double area_on(const Mesh& mesh, std::uint32_t face) {
  double area = 0;
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) { area += 0.5 * norm(cross(b - a, c - a)); };
  const auto at = [&](std::uint32_t v) { return mesh.points[v]; };
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
    if (const auto& v = mesh.tri_to_vert[t]; mesh.tri_to_entity[t] == face) add(at(v[0]), at(v[1]), at(v[2]));
  for (std::size_t q = 0; q < mesh.quad_to_vert.size(); ++q)
    if (const auto& v = mesh.quad_to_vert[q]; mesh.quad_to_entity[q] == face)
      add(at(v[0]), at(v[1]), at(v[2])), add(at(v[0]), at(v[2]), at(v[3]));
  return area;
}

}  // namespace

TEST_CASE("layers on the bottom of a cylinder stand on its round side and follow the seam") {
  const auto cylinder = make_cylinder(1, 2);
  MeshOptions options = options_of_size(0.25);
  options.layers = on_faces(*cylinder, heights(0.03, 6), {kSide});
  const MeshResult result = meshed(*cylinder, options);
  CHECK(result.layers.coverage.full_count == Approx(1));
  CHECK(result.layers.coverage.first_height_within_10pct == Approx(1));
  check_side(result.mesh, kSide, 2 * 6 * 20, [](const Vec3& x) { return std::hypot(x.x, x.y) - 1; });
  CHECK(area_on(result.mesh, kSide) == Approx(4 * std::numbers::pi).epsilon(0.02));
  // The seam is as long as before.
  double seam = 0;
  for (std::size_t e = 0; e < result.mesh.edge_to_vert.size(); ++e)
    if (const auto& [a, b] = result.mesh.edge_to_vert[e]; result.mesh.edge_to_entity[e] == 2)
      seam += distance(result.mesh.points[a], result.mesh.points[b]);
  CHECK(seam == Approx(2));
}

TEST_CASE("layers on the base of a cone stand on its side, below the apex") {
  const auto cone = make_cone(1, 2);
  MeshOptions options = options_of_size(0.2);
  options.layers = on_faces(*cone, heights(0.02, 5), {kSide});
  const MeshResult result = meshed(*cone, options);
  CHECK(result.layers.coverage.full_count == Approx(1));
  check_side(result.mesh, kSide, 5 * 25,
             [](const Vec3& x) { return (std::hypot(x.x, x.y) - (1 - x.z / 2)) * 2 / std::sqrt(5.0); });
}

TEST_CASE("layers on the round side of a cone end above its apex and stand on its base") {
  const auto cone = make_cone(1, 2);
  MeshOptions options = options_of_size(0.2);
  options.layers = on_faces(*cone, heights(0.02, 5), {kBottom});
  const MeshResult result = meshed(*cone, options);
  CHECK(result.layers.coverage.full_count > 0.9);
  check_side(result.mesh, kBottom, 5 * 25, [](const Vec3& x) { return x.z; });
}

TEST_CASE("where a side face turns away from the wall, no layers stand on it, and the reason is told") {
  for (const bool is_round : {true, false}) {
    const std::shared_ptr<const GeometricModel> body =
        is_round ? make_cylinder(1, 2) : make_box({-1, -1, 0}, {1, 1, 2});
    const auto model = put_into_box(body, 3);
    MeshOptions options = options_of_size(0.4);
    options.layers.walls = {heights(0.04, 5)};
    options.layers.walls[0].face = ModelFaceId(is_round ? kBottom : 4u);
    const MeshResult result = meshed(*model, options);
    CHECK(result.layers.coverage.at_least_one > 0.3);
    CHECK(result.layers.coverage.at_least_one < 0.9);
    double uncovered = 0;
    for (const LimitedLayers& limited : result.layers.limited) uncovered += limited.uncovered;
    CHECK(uncovered / result.layers.coverage.area == Approx(1 - result.layers.coverage.at_least_one));
    CHECK(result.mesh.quad_to_vert.empty());
    CHECK(std::ranges::any_of(result.layers.limited,
                              [](const LimitedLayers& limited) { return limited.reason == LayerLimit::SideAngle; }));
  }
}

TEST_CASE("meshes with layers on round side faces are the same on any number of threads") {
  const auto cone = make_cone(1, 2);
  MeshOptions options = options_of_size(0.3, 1);
  options.layers = on_faces(*cone, heights(0.03, 5), {kSide});
  const std::string digest = mesh_digest(meshed(*cone, options).mesh);
  options.threads = 2;
  CHECK(mesh_digest(meshed(*cone, options).mesh) == digest);
}

TEST_CASE("a rim that crosses itself is refused with its nodes") {
  const auto plate = make_plate(1, 1);
  const auto geometry = plate->face_geometry(ModelFaceId(0u));
  const auto mesh_of = [&](const std::vector<Vec3>& nodes) {
    FaceRim rim;
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      rim.vertices.push_back({i, {nodes[i].x, nodes[i].y}});
      rim.segments.push_back({i, static_cast<std::uint32_t>((i + 1) % nodes.size())});
      rim.segment_to_edge.emplace_back();
    }
    const MeshResult coarse = make_mesh(*plate, options_of_size(0.5));
    return mesh_in_rim(rim, *geometry, nodes, coarse.sizes, [] { return true; });
  };
  const RimMesh square = mesh_of({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}});
  CHECK(square.mesh.verdict == FaceVerdict::Ok);
  CHECK(square.crossing.empty());
  const RimMesh bow = mesh_of({{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}});
  CHECK(bow.mesh.verdict == FaceVerdict::RimCrosses);
  CHECK(bow.crossing.size() == 4);
  CHECK(mesh_of({{0, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 0, 0}}).mesh.verdict != FaceVerdict::RimCrosses);
}
