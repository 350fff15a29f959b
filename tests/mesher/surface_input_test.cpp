// The surface that a volume is filled for, in a mesh or where somebody keeps it.
#include "mesher/surface_input.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>
#include <stdexcept>
#include <vector>

#include "tests/support/analytic_model.hpp"

using namespace tetloom;

namespace {

/// Two triangles on two faces.
Mesh two_triangles() {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 1}};
  mesh.point_to_entity = {ModelEntity(0, 0), ModelEntity(0, 1), ModelEntity(0, 2), ModelEntity(2, 1)};
  mesh.edge_to_vert = {{0, 1}};
  mesh.edge_to_entity = {0};
  mesh.tri_to_vert = {{0, 1, 2}, {1, 3, 2}};
  mesh.tri_to_entity = {0, 1};
  return mesh;
}

ModelTopology two_faces() {
  ModelTopology topology;
  topology.face_to_sides = {{ModelRegionId(), ModelRegionId(0)}, {ModelRegionId(0), ModelRegionId(1)}};
  return topology;
}

std::shared_ptr<const std::byte> copy_of(std::span<const std::byte> bytes) {
  const auto copy = std::make_shared<std::vector<std::byte>>(bytes.begin(), bytes.end());
  return {copy, copy->data()};
}

void check_same(const Mesh& mesh, const Mesh& expected) {
  CHECK(mesh.points == expected.points);
  CHECK(mesh.point_to_entity == expected.point_to_entity);
  CHECK(mesh.edge_to_vert == expected.edge_to_vert);
  CHECK(mesh.tri_to_vert == expected.tri_to_vert);
  CHECK(mesh.tri_to_entity == expected.tri_to_entity);
}

void check_input(const SurfaceInput& surface, const Mesh& expected) {
  const SizeField sizes = SizeField::uniform(1);
  const auto model = test_models::make_box({0, 0, 0}, {1, 1, 1});
  const VolumeInput input = surface.input(*model, sizes);
  CHECK(std::ranges::equal(input.points, expected.points));
  CHECK(std::ranges::equal(input.point_to_entity, expected.point_to_entity));
  CHECK(std::ranges::equal(input.edge_to_vert, expected.edge_to_vert));
  CHECK(std::ranges::equal(input.tri_to_vert, expected.tri_to_vert));
  CHECK(std::ranges::equal(input.tri_to_face, expected.tri_to_entity));
  const auto sides = two_faces().face_to_sides;
  REQUIRE(input.tri_to_sides.size() == 2);
  for (std::size_t t = 0; t < 2; ++t) {
    CHECK(input.tri_to_sides[t].front == sides[t].front);
    CHECK(input.tri_to_sides[t].back == sides[t].back);
  }
}

}  // namespace

TEST_CASE("a surface that is kept elsewhere comes back to its mesh") {
  const Mesh expected = two_triangles();
  Mesh mesh = expected;
  {
    const SurfaceInput surface(mesh, two_faces(), copy_of);
    CHECK(mesh.points.empty());
    CHECK(mesh.tri_to_vert.empty());
    check_input(surface, expected);
  }
  check_same(mesh, expected);
}

TEST_CASE("a surface that nobody keeps stays in its mesh") {
  const Mesh expected = two_triangles();
  Mesh mesh = expected;
  const SurfaceInput surface(mesh, two_faces(), [](std::span<const std::byte>) { return nullptr; });
  check_same(mesh, expected);
  check_input(surface, expected);
}

TEST_CASE("where a surface cannot be kept as a whole the mesh is as it was") {
  const Mesh expected = two_triangles();
  for (int good = 0; good < 6; ++good) {
    Mesh mesh = expected;
    int asked = 0;
    const auto keep = [&](std::span<const std::byte> bytes) {
      if (asked++ == good) throw std::runtime_error("stopped");
      return copy_of(bytes);
    };
    CHECK_THROWS_AS(SurfaceInput(mesh, two_faces(), keep), std::runtime_error);
    check_same(mesh, expected);
  }
}
