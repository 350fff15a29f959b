// Mid nodes on the model, and tets that stay valid.
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "core/mesh/curved_tet.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "mesher/second_order/straighten.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"

using namespace tetloom;
using namespace tetloom::second_order;
using namespace tetloom::test_models;

namespace {

MeshOptions second_order_of_size(double size, int threads = 2) {
  MeshOptions options;
  options.sizes.size = size;
  options.order = 2;
  options.threads = threads;
  return options;
}

Mesh meshed_second_order(const GeometricModel& model, const MeshOptions& options) {
  MeshResult result = make_mesh(model, options);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(result.second_order.mid_nodes == result.mesh.mid_to_vert.size());
  CHECK(validate_mesh(result.mesh).valid());
  return std::move(result.mesh);
}

double volume_error(double size) {
  const Mesh mesh = meshed_second_order(*make_sphere({1, 2, 3}, 1), second_order_of_size(size));
  return std::abs(compute_quality(mesh).curved.volume - 4 * std::numbers::pi / 3);
}

/// A box whose mid nodes on its surface are to be moved by `displacement`.
struct BentBox {
  Mesh mesh;
  std::vector<CurvedNode> curved;
  BentBox(int n, const std::function<Vec3(const Vec3&)>& displacement)
      : mesh(test::with_mid_nodes(test::make_tet_box(n, n, n))) {
    for (std::uint32_t m = 0; m < mesh.mid_to_vert.size(); ++m) {
      const Vec3 middle = middle_of_edge(mesh, m);
      if (mesh.point_to_entity[vertex_count(mesh) + m].dim == 2) curved.push_back({m, middle + displacement(middle)});
    }
  }
};

}  // namespace

TEST_CASE("mid nodes of surface edges lie on the model, those inside in the middle") {
  const Mesh mesh = meshed_second_order(*make_sphere({1, 2, 3}, 1), second_order_of_size(0.3));
  std::size_t on_sphere = 0;
  for (std::size_t m = 0; m < mesh.mid_to_vert.size(); ++m) {
    const std::size_t p = vertex_count(mesh) + m;
    if (mesh.point_to_entity[p].dim == 3) {
      CHECK(mesh.points[p] == middle_of_edge(mesh, m));
    } else {
      CHECK(distance(mesh.points[p], {1, 2, 3}) == Approx(1).epsilon(1e-9));
      ++on_sphere;
    }
  }
  CHECK(on_sphere == mesh.tri_to_vert.size() * 3 / 2);
}

TEST_CASE("the volume of a ball converges with the fourth power of the size") {
  const double coarse = volume_error(0.4), fine = volume_error(0.2);
  CHECK(std::log2(coarse / fine) > 3.5);
}

TEST_CASE("volumes are compared with the model's as the curved triangles bound them") {
  MeshOptions options = second_order_of_size(0.5);
  const auto model = make_sphere({1, 2, 3}, 1);
  CHECK(make_mesh(*model, options).warnings.empty());
  options.order = 1;
  const MeshResult straight = make_mesh(*model, options);
  REQUIRE(straight.warnings.size() == 1);
  CHECK(straight.warnings[0].code == ErrorCode::VolumeDiffers);
}

TEST_CASE("the mesh of second order does not depend on the number of threads") {
  const auto model = make_torus(3, 1);
  const std::string digest = mesh_digest(meshed_second_order(*model, second_order_of_size(0.5, 1)));
  for (const int threads : {2, 5})
    CHECK(mesh_digest(meshed_second_order(*model, second_order_of_size(0.5, threads))) == digest);
}

TEST_CASE("flat faces and straight edges leave all tets straight") {
  const Mesh mesh = meshed_second_order(*make_box({0, 0, 0}, {1, 2, 3}), second_order_of_size(0.5));
  CHECK(compute_quality(mesh).curved.count == 0);
}

TEST_CASE("a surface alone has mid nodes as well") {
  MeshOptions options = second_order_of_size(0.4);
  options.surface_only = true;
  const Mesh mesh = meshed_second_order(*make_cylinder(1, 2), options);
  CHECK(mesh.tet_to_vert.empty());
  CHECK(mesh.mid_to_vert.size() == mesh.tri_to_vert.size() * 3 / 2);
}

TEST_CASE("sizes far too coarse for the curves give valid tets all the same") {
  for (const double size : {2.0, 1.0}) {
    const MeshResult result = make_mesh(*make_torus(2, 1), second_order_of_size(size));
    REQUIRE(result.status == MeshStatus::Ok);
    CHECK(result.second_order.invalid == 0);
    CHECK(result.second_order.min_scaled_jacobian >= 0.1);
    CHECK(validate_mesh(result.mesh).valid());
  }
}

TEST_CASE("mid nodes that would invert tets are pulled back as little as it takes, and listed") {
  for (const double by : {0.05, 0.2, 0.5, 1.5}) {
    INFO(by);
    BentBox box(3, [by](const Vec3& x) { return by * Vec3{std::sin(9 * x.y), std::cos(7 * x.z), std::sin(8 * x.x)}; });
    const Mesh before = box.mesh;
    const Straightening result = straighten(box.curved, 0.2, box.mesh, TaskRunner(2));
    CHECK(result.not_positive == 0);
    CHECK(result.min_scaled_jacobian >= 0.2);
    CHECK(compute_quality(box.mesh).curved.min_scaled_jacobian >= 0.2 - 1e-3);
    const std::size_t first = vertex_count(box.mesh);
    std::size_t off = 0;
    for (const CurvedNode& node : box.curved) off += box.mesh.points[first + node.mid] != node.place;
    CHECK(off == result.off_model.size());
    if (by < 0.1) CHECK(off == 0);
    if (by > 0.3) CHECK(off > 0);
    for (std::size_t p = 0; p < first; ++p) CHECK(box.mesh.points[p] == before.points[p]);
  }
}

TEST_CASE("mid nodes inside of a region give way before those on the model do") {
  // The middle of one face of a box is pushed towards the inside, over the mid nodes behind it.
  BentBox box(1, [](const Vec3& x) { return x.z > 0.999 ? Vec3{0, 0, -0.42} : Vec3{}; });
  std::erase_if(box.curved, [&](const CurvedNode& node) { return node.place == middle_of_edge(box.mesh, node.mid); });
  REQUIRE_FALSE(box.curved.empty());
  const Straightening result = straighten(box.curved, 0.1, box.mesh, TaskRunner(1));
  CHECK(result.moved.size() > 0);
  CHECK(result.off_model.empty());
  CHECK(result.min_scaled_jacobian >= 0.1);
}

TEST_CASE("orders and bounds out of range are refused by name") {
  const auto model = make_box({0, 0, 0}, {1, 1, 1});
  MeshOptions options = second_order_of_size(0.5);
  options.order = 3;
  CHECK_THROWS_WITH(make_mesh(*model, options), Catch::Contains("order"));
  options.order = 2;
  for (const double bound : {-0.1, 0.95, std::nan("")}) {
    options.min_scaled_jacobian = bound;
    CHECK_THROWS_WITH(make_mesh(*model, options), Catch::Contains("min_scaled_jacobian"));
  }
}
