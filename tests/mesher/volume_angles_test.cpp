// Small angles that the surface forces, and what is told of them.
#include <map>
#include <numbers>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

/// A prism along z whose faces 3 and 5 meet at `angle` (radians) at the z axis, in n x n squares each; 0, 1 and 2 are
/// its other faces.
Surface wedge_surface(double angle, int n) {
  Surface wedge;
  std::map<std::array<int, 3>, std::uint32_t> ids;
  const auto point = [&](int i, int side, int k) {
    const std::array<int, 3> key{i, i == 0 ? 0 : side, k};
    const auto [entry, is_new] = ids.emplace(key, static_cast<std::uint32_t>(wedge.points.size()));
    const double radius = double(i) / n, turn = key[1] == 0 ? 0 : angle;
    if (is_new) wedge.points.push_back({radius * std::cos(turn), radius * std::sin(turn), double(k) / n});
    return entry->second;
  };
  const Vec3 middle{0.5 * std::cos(angle / 2), 0.5 * std::sin(angle / 2), 0.5};
  const auto add = [&](std::array<std::uint32_t, 3> t, std::uint32_t face) {
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) return;
    const Vec3 &a = wedge.points[t[0]], &b = wedge.points[t[1]], &c = wedge.points[t[2]];
    if (orient3d(a, b, c, middle) > 0) std::swap(t[1], t[2]);
    wedge.add(t, kOutside, 0, face);
  };
  const auto add_square = [&](std::array<std::uint32_t, 4> q, std::uint32_t face) {
    add({q[0], q[1], q[2]}, face), add({q[0], q[2], q[3]}, face);
  };
  for (int i = 0; i < n; ++i) {
    for (int k = 0; k < n; ++k) {
      for (const int side : {0, 1})
        add_square({point(i, side, k), point(i + 1, side, k), point(i + 1, side, k + 1), point(i, side, k + 1)},
                   side == 0 ? 3 : 5);
    }
    for (const int end : {0, 1})
      add_square({point(i, 0, end * n), point(i + 1, 0, end * n), point(i + 1, 1, end * n), point(i, 1, end * n)},
                 static_cast<std::uint32_t>(end));
  }
  for (int k = 0; k < n; ++k) add_square({point(n, 0, k), point(n, 1, k), point(n, 1, k + 1), point(n, 0, k + 1)}, 2);
  return wedge;
}

}  // namespace

TEST_CASE("a wedge of 5 degrees is named by its two faces and its edge as what forces small angles") {
  const Surface wedge = wedge_surface(5 * std::numbers::pi / 180, 10);
  std::vector<ModelEntity> point_to_entity;
  for (const Vec3& x : wedge.points) {
    const bool is_end = x.z == 0 || x.z == 1;
    point_to_entity.push_back(norm2({x.x, x.y, 0}) > 0 ? ModelEntity(2, 3)
                              : is_end                 ? ModelEntity(0, 0)
                                                       : ModelEntity(1, 7));
  }
  const SizeField sizes = SizeField::uniform(0.1);
  VolumeInput input = wedge.input(sizes);
  input.point_to_entity = point_to_entity;
  const VolumeMesh mesh = fill_volume(input, {}, TaskRunner(1));
  REQUIRE(mesh.errors.empty());
  const tets::OptimizeReport& report = mesh.figures.optimizer;
  const auto points = all_points(wedge, mesh);
  CHECK(report.below_dihedral == report.forced);
  CHECK(report.forced == report.forced_by_angles + report.forced_by_triangles + report.forced_by_points);
  CHECK(report.forced_by_angles >= 10);  // one tet at least at each piece of the edge
  REQUIRE(report.acute_tets.size() == std::min(report.below_dihedral, kMostAcuteTets));
  std::size_t at_edge = 0;
  for (const AcuteTet& tet : report.acute_tets) {
    CHECK(tet.angle < 15);
    for (const auto& triangle : tet.triangles)
      for (const std::uint32_t v : triangle) REQUIRE(v < wedge.points.size());
    if (tet.cause == AngleCause::SurfacePoints) CHECK(!tet.entities.empty());
    if (tet.cause != AngleCause::SurfaceAngle) continue;
    CHECK(tet.cause_angle == Approx(5));
    REQUIRE(tet.entities.size() == 3);
    CHECK(tet.entities[0].entity == ModelEntity(2, 3));
    CHECK(tet.entities[1].entity == ModelEntity(2, 5));
    CHECK(tet.entities[2].entity == ModelEntity(1, 7));
    ++at_edge;
  }
  CHECK(at_edge >= 10);
}

TEST_CASE("where every angle is as large as asked for nothing is told") {
  const Surface cube = cube_surface(5);
  const SizeField sizes = SizeField::uniform(0.2);
  const VolumeMesh mesh = fill_volume(cube.input(sizes), {}, TaskRunner(2));
  CHECK(mesh.figures.optimizer.least_dihedral > 15);
  CHECK(mesh.figures.optimizer.acute_tets.empty());
}
