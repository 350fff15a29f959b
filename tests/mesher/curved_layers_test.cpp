// Boundary layers of second order.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/mesh/curved_cell.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "tests/mesher/layers_fixture.hpp"

using namespace tetloom;
using namespace tetloom::test_layers;
using namespace tetloom::test_models;

namespace {

MeshOptions curved_layers(const GeometricModel& model, double size, const WallLayers& layers,
                          const std::vector<std::uint32_t>& but = {}) {
  MeshOptions options = options_of_size(size);
  options.order = 2;
  options.layers = on_faces(model, layers, but);
  return options;
}

Vec3 bend_of(const Mesh& mesh, std::uint32_t mid) {
  return mesh.points[vertex_count(mesh) + mid] - middle_of_edge(mesh, mid);
}

/// The largest difference between the bends of edges below and above in prisms, over the lower one's.
double most_change_in_layers(const Mesh& mesh) {
  const MidNodes mids(mesh);
  double most = 0;
  for (const auto& prism : mesh.prism_to_vert) {
    const CellMids own(CellKind::Prism, prism, mids);
    for (std::size_t e = 0; e < 3; ++e)
      most = std::max(most, distance(bend_of(mesh, own[e]), bend_of(mesh, own[3 + e])) / norm(bend_of(mesh, own[e])));
  }
  return most;
}

}  // namespace

TEST_CASE("the layers on a ball are bent as the ball is, and all cells are valid") {
  const auto ball = make_sphere({1, 2, 3}, 1);
  const MeshResult result = meshed(*ball, curved_layers(*ball, 0.3, heights(0.005, 8)));
  CHECK(result.second_order.off_model.empty());
  CHECK(result.second_order.invalid == 0);
  CHECK(result.second_order.min_scaled_jacobian > 0.5);
  CHECK(most_change_in_layers(result.mesh) < 1e-9);
  const QualityReport quality = compute_quality(result.mesh);
  CHECK(quality.curved.count > result.mesh.prism_to_vert.size());
  CHECK(quality.curved.not_positive == 0);
  CHECK(quality.curved.volume == Approx(4 * std::numbers::pi / 3).epsilon(1e-3));
  CHECK(quality.curved.min_scaled_jacobian == Approx(result.second_order.min_scaled_jacobian).margin(2e-3));
}

TEST_CASE("on a side face the mid nodes of layers stay on the face and follow the wall's") {
  const auto pipe = make_cylinder(1, 4);
  const std::vector<std::uint32_t> caps = caps_of(*pipe, 1);
  const MeshResult result = meshed(*pipe, curved_layers(*pipe, 0.4, heights(0.004, 8), caps));
  const Mesh& mesh = result.mesh;
  CHECK(result.second_order.off_model.empty());
  CHECK(result.second_order.min_scaled_jacobian > 0.5);
  CHECK(most_change_in_layers(mesh) < 1e-6);
  std::size_t bent_on_caps = 0;
  for (std::uint32_t m = 0; m < mesh.mid_to_vert.size(); ++m) {
    const ModelEntity entity = mesh.point_to_entity[vertex_count(mesh) + m];
    if (entity.dim != 2 || std::ranges::count(caps, entity.index) == 0) continue;
    CHECK(std::abs(bend_of(mesh, m).z) < 1e-12);
    bent_on_caps += norm(bend_of(mesh, m)) > 1e-3;
  }
  CHECK(bent_on_caps >= 8 * 2 * 12);
  CHECK(compute_quality(mesh).curved.volume == Approx(4 * std::numbers::pi).epsilon(2e-3));
}

TEST_CASE("curved layers do not depend on the number of threads") {
  const auto pipe = make_cylinder(1, 2);
  MeshOptions options = curved_layers(*pipe, 0.3, heights(0.02, 6));
  options.threads = 1;
  const std::string digest = mesh_digest(meshed(*pipe, options).mesh);
  options.threads = 4;
  CHECK(mesh_digest(meshed(*pipe, options).mesh) == digest);
}

TEST_CASE("flat walls leave all layers straight") {
  const auto box = make_box({0, 0, 0}, {2, 2, 2});
  const MeshResult result = meshed(*box, curved_layers(*box, 0.5, heights(0.02, 4)));
  CHECK(result.second_order.curved == 0);
  CHECK(result.second_order.moved == 0);
  CHECK(compute_quality(result.mesh).curved.count == 0);
}
