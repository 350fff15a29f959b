#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <limits>
#include <set>

#include "tests/core/mesh_fixtures.hpp"
#include "tetloom/check.hpp"
#include "tetloom/error.hpp"

using namespace tetloom;

namespace {

Mesh one_tet(const Vec3& apex) {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {0.5, std::sqrt(0.75), 0}, apex};
  mesh.point_to_entity.resize(4);
  mesh.tet_to_vert = {{0, 1, 2, 3}};
  mesh.tet_to_entity = {0};
  return mesh;
}

const Vec3 kRegularApex{0.5, std::sqrt(0.75) / 3, std::sqrt(2.0 / 3)};

std::size_t brute_force_edges(const Mesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (const auto& tet : mesh.tet_to_vert)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) edges.insert(std::minmax(tet[i], tet[j]));
  return edges.size();
}

}  // namespace

TEST_CASE("the regular tet has mean ratio 1 and the dihedral angle of arccos 1/3") {
  const SizeField sizes = SizeField::uniform(1);
  const TetQuality quality = compute_quality(one_tet(kRegularApex), &sizes).tets;
  CHECK(quality.count == 1);
  CHECK(quality.inverted == 0);
  CHECK(quality.mean_ratio_min == Approx(1));
  CHECK(quality.mean_ratio_p1 == Approx(1));
  CHECK(quality.mean_ratio_mean == Approx(1));
  CHECK(quality.min_dihedral_deg == Approx(std::acos(1.0 / 3) * 180 / 3.14159265358979));
  CHECK(quality.volume == Approx(std::sqrt(2.0) / 12));
  CHECK(quality.mean_ratio_histogram[9] == 1);
  CHECK(quality.dihedral_histogram[7] == 6);
  CHECK(quality.edges.edges == 6);
  CHECK(quality.edges.mean_length_ratio == Approx(1));
  CHECK(quality.edges.in_band == 1);
}

TEST_CASE("flat and inverted tets count as inverted and have quality 0") {
  for (const double z : {0.0, -0.8}) {
    const TetQuality quality = compute_quality(one_tet({0.5, 0.3, z})).tets;
    CHECK(quality.inverted == 1);
    CHECK(quality.mean_ratio_min == 0);
    CHECK(quality.min_dihedral_deg == 0);
  }
}

TEST_CASE("a mesh with points that are not finite is measured without harm") {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    Mesh mesh = one_tet({0.5, bad, 1});
    mesh.tri_to_vert = {{0, 1, 3}};
    mesh.tri_to_entity = {0};
    const QualityReport report = compute_quality(mesh);
    CHECK(report.tets.inverted == 1);
    CHECK(report.triangles.shape_min == 0);
  }
}

TEST_CASE("an empty mesh has a report of zeros") {
  const QualityReport report = compute_quality(Mesh{});
  CHECK(report.tets.count == 0);
  CHECK(report.triangles.count == 0);
}

TEST_CASE("measuring a mesh with broken indices is refused") {
  Mesh mesh = one_tet(kRegularApex);
  mesh.tet_to_vert[0][2] = 4;
  CHECK_THROWS_AS(compute_quality(mesh), Error);
  mesh = one_tet(kRegularApex);
  mesh.tet_to_entity.clear();
  CHECK_THROWS_AS(compute_quality(mesh), Error);
}

TEST_CASE("edges are counted once each, and regions and faces have their own sums") {
  const Mesh mesh = test::make_box(6, 3, 4, true, 0.5);
  const SizeField sizes = SizeField::uniform(0.5);
  const QualityReport report = compute_quality(mesh, &sizes);
  CHECK(report.tets.edges.edges == brute_force_edges(mesh));
  CHECK(report.tets.volume == Approx(6 * 3 * 4 * 0.125));
  REQUIRE(report.cells.regions.size() == 2);
  CHECK(report.cells.regions[0].volume == Approx(3 * 3 * 4 * 0.125));
  CHECK(report.cells.regions[1].tets == 3 * 3 * 4 * 6);
  REQUIRE(report.triangles.faces.size() == mesh.face_to_sides.size());
  double area = 0;
  for (const FaceQuality& face : report.triangles.faces) {
    CHECK(face.min_angle_deg == Approx(45));
    area += face.area;
  }
  CHECK(area == Approx(2 * (3 * 1.5 + 3 * 2 + 1.5 * 2) + 1.5 * 2));
  CHECK(report.triangles.area == Approx(area));
  CHECK(report.triangles.shape_mean == Approx(std::sqrt(3.0) / 2));
  // Of the lengths 1, sqrt 2 and sqrt 3 the last is out of the band; sqrt 2 itself lies just beyond 1.41421356.
  CHECK(report.tets.edges.in_band > 0.2);
  CHECK(report.tets.edges.in_band < 0.6);
}

TEST_CASE("the first percentile interpolates between neighbours") {
  Mesh mesh;
  for (int i = 0; i <= 100; ++i) {
    const Mesh tet = one_tet({0.5, std::sqrt(0.75) / 3, 0.01 * (i + 1)});
    const auto base = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), tet.points.begin(), tet.points.end());
    mesh.tet_to_vert.push_back({base, base + 1, base + 2, base + 3});
    mesh.tet_to_entity.push_back(0);
  }
  const double expected = compute_quality(one_tet({0.5, std::sqrt(0.75) / 3, 0.02})).tets.mean_ratio_min;
  CHECK(compute_quality(mesh).tets.mean_ratio_p1 == Approx(expected));
}

TEST_CASE("angles of needle triangles are accurate") {
  Mesh mesh;
  mesh.points = {{0, 0, 0}, {1, 0, 0}, {1, 1e-9, 0}};
  mesh.point_to_entity.resize(3);
  for (const auto& triangle : {std::array<std::uint32_t, 3>{0, 1, 2}, {1, 2, 0}, {2, 0, 1}}) {
    mesh.tri_to_vert = {triangle};
    mesh.tri_to_entity = {0};
    CHECK(compute_quality(mesh).triangles.min_angle_deg == Approx(1e-9 * 180 / 3.14159265358979));
  }
}
