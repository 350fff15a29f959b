// Where a surface lies, how it is turned and in which unit its lengths are does not matter.
#include <cmath>
#include <numbers>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

struct Motion {
  double scale = 1;
  Vec3 axis{0, 0, 1};  // of unit length
  double angle = 0;
  Vec3 shift{};  // before scaling

  Vec3 operator()(const Vec3& p) const {
    const double c = std::cos(angle), s = std::sin(angle);
    return scale * (shift + c * p + s * cross(axis, p) + (1 - c) * dot(axis, p) * axis);
  }
};

Surface moved(Surface surface, const Motion& motion) {
  for (Vec3& p : surface.points) p = motion(p);
  return surface;
}

// Sizes from `size` down to a third of it towards the origin, linear between the corners of eight cubes.
SizeField graded_sizes(double size, double scale) {
  SizeOctree tree;
  tree.origin = scale * Vec3{-2, -2, -2}, tree.width = scale * 4;
  tree.domain = {tree.origin, -tree.origin};
  tree.size = scale * size, tree.gradation = 0.3;
  std::vector<std::array<float, 8>> leaf_to_ratios;
  for (std::uint32_t cell = 0; cell < 8; ++cell) {
    tree.cells.push_back(SizeOctree::kLeafBit + cell);
    // The corner at the origin is the one opposite to the octant.
    std::array<float, 8> ratios;
    ratios.fill(1);
    ratios[7 - cell] = 1.0f / 3;
    leaf_to_ratios.push_back(ratios);
  }
  set_corner_ratios(tree, leaf_to_ratios);
  return SizeField::from_octree(tree);
}

struct Figures {
  double tets = 0, volume = 0, mean_quality = 0, low_quality = 0;  // the last: of the worst hundredth
};

Figures figures_of(const Surface& surface, const VolumeMesh& mesh, double scale) {
  const std::vector<Vec3> points = all_points(surface, mesh);
  std::vector<double> qualities;
  Figures figures{static_cast<double>(mesh.tet_to_vert.size())};
  for (const auto& t : mesh.tet_to_vert) {
    double squares = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) squares += norm2((points[t[i]] - points[t[j]]) / scale);
    }
    const double volume = volume_of(points, t) / (scale * scale * scale);
    figures.volume += volume;
    qualities.push_back(12 * std::pow(3 * volume, 2.0 / 3) / squares);
    figures.mean_quality += qualities.back() / figures.tets;
  }
  std::sort(qualities.begin(), qualities.end());
  figures.low_quality = qualities[qualities.size() / 100];
  return figures;
}

Figures fill_moved(const Surface& surface, double size, const Motion& motion) {
  const Surface there = moved(surface, motion);
  const SizeField sizes = SizeField::uniform(size * motion.scale);
  const VolumeMesh mesh = fill_volume(there.input(sizes), {}, TaskRunner(2));
  CHECK(mesh.errors.empty());
  CHECK(mesh.figures.worker_complexes == 0);
  check_filling(there, mesh);
  return figures_of(there, mesh, motion.scale);
}

}  // namespace

TEST_CASE("turned, moved and scaled by any amount, a surface gets as many tetrahedra of the same quality") {
  const int levels = test::kSanitized ? 4 : 5;
  const double size = test::kSanitized ? 0.1 : 0.06;
  const Surface body = ball_surface(levels, {0, 0, 0}, 0, [](const Vec3& d) { return 1 + 0.2 * d.x * d.y * d.z; });
  const Figures rest = fill_moved(body, size, {});
  CAPTURE(rest.tets, rest.mean_quality, rest.low_quality);
  const Vec3 axis = normalized({1, 2, -3});
  for (const Motion& motion :
       {Motion{1e-6, axis, 0.3, {}}, Motion{1e-3, axis, 1, {7, -3, 2}}, Motion{1 / 25.4, {1, 0, 0}, 0, {}},
        Motion{1, {0, 1, 0}, 0.5, {}}, Motion{1, axis, 2, {100, 0, -50}}, Motion{1e3, axis, 2.5, {0.1, 0.2, 0.3}},
        Motion{1e6, {0, 0, 1}, 0.01, {}}}) {
    CAPTURE(motion.scale, motion.angle, motion.shift.x);
    const Figures there = fill_moved(body, size, motion);
    CHECK(there.tets == Approx(rest.tets).epsilon(0.01));
    CHECK(there.volume == Approx(rest.volume).epsilon(1e-9));
    CHECK(there.mean_quality == Approx(rest.mean_quality).margin(0.005));
    CHECK(there.low_quality == Approx(rest.low_quality).margin(0.01));
  }
}

TEST_CASE("scaling by powers of two changes nothing but coordinates, with graded sizes and surfaces that change too") {
  const Surface body = ball(3);
  const Surface blocks = voxel_surface({2, 2, 1}, 4, [](int i, int j, int) { return i == 1 && j == 1 ? 1u : 0u; });
  for (const Surface& surface : {body, blocks}) {
    for (const bool improve : {false, true}) {
      VolumeOptions options;
      options.improve_surface = improve;
      const auto fill = [&](double scale) {
        const SizeField sizes = graded_sizes(0.3, scale);
        const Surface there = moved(surface, {scale});
        return fill_volume(there.input(sizes), options, TaskRunner(1));
      };
      const VolumeMesh mesh = fill(1);
      REQUIRE(mesh.errors.empty());
      CHECK(mesh.new_points.size() > 50);
      for (const double scale : {0x1p-20, 0x1p-3, 0x1p20}) {
        CAPTURE(scale, improve);
        const VolumeMesh there = fill(scale);
        CHECK((there.tet_to_vert == mesh.tet_to_vert));
        CHECK(there.changed_triangles.size() == mesh.changed_triangles.size());
        REQUIRE(there.new_points.size() == mesh.new_points.size());
        for (std::size_t i = 0; i < mesh.new_points.size(); ++i)
          REQUIRE(there.new_points[i] == scale * mesh.new_points[i]);
      }
    }
  }
}
