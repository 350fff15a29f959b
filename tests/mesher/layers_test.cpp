// Boundary layers: cells, growth, imprint, refusals.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "mesher/layers/face_skewness.hpp"
#include "mesher/layers/front_spreading.hpp"
#include "mesher/layers/growth_direction.hpp"
#include "mesher/layers/layer_cells.hpp"
#include "mesher/layers/sound_stacks.hpp"
#include "tests/mesher/layers_fixture.hpp"
#include "tests/support/error_of.hpp"

using namespace tetloom;
using namespace tetloom::layers;
using namespace tetloom::test_layers;
using namespace tetloom::test_models;
using test::error_of;

namespace {

// Columns of different counts above one triangle.
struct Column {
  std::array<Vec3, 3> foot{Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  Vec3 at(const LevelCorner& corner) const { return foot[corner.corner] + Vec3{0, 0, 0.1 * corner.level}; }
};

// Two triangles at an edge, which turn by so many degrees there; away from it, fronts become narrower by a factor from
// level to level.
constexpr int kSqueezedLevels = 20;

Walls two_triangles() {
  Walls walls;
  walls.triangles = {{0, 0, true, {1, 0, 2}, {1, 0, 2}}, {1, 0, true, {0, 1, 3}, {0, 1, 3}}};
  walls.curve_to_vert = {0, 1, 2, 3};
  walls.curve_begin = {0, 2, 4, 5, 6};
  walls.curve_triangles = {0, 1, 0, 1, 0, 1};
  walls.curve_is_late.assign(4, 0);
  walls.curve_to_fan_vertex.assign(4, kNone);
  return walls;
}

double least_sine(const std::array<Vec3, 3>& x) {
  std::array<double, 3> lengths{distance(x[0], x[1]), distance(x[1], x[2]), distance(x[2], x[0])};
  std::ranges::sort(lengths);
  return norm(cross(x[1] - x[0], x[2] - x[0])) / (lengths[1] * lengths[2]);
}

// Levels that are sound above the first triangle, the sine of its front there, and that one level further up.
std::array<double, 3> squeezed_stack(double degrees, double factor) {
  const double turn = degrees * std::numbers::pi / 180;
  const auto point = [&](std::uint32_t curve, int level) -> Vec3 {
    const double up = 0.3 * level, across = 0.8 * std::pow(factor, level);
    if (curve < 2) return {0, curve == 0 ? 0.0 : 1.0, up};
    const Vec3 away = curve == 2 ? Vec3{1, 0, 0} : Vec3{-std::cos(turn), 0, std::sin(turn)};
    return across * away + Vec3{0, 0.5, up};
  };
  const std::array<Vec3, 4> feet{point(0, 0), point(1, 0), point(2, 0), point(3, 0)};
  const Walls walls = two_triangles();
  const SoundStacks stacks(walls, feet, TaskRunner(1, {}));
  const int levels = stacks.levels(
      0, [](std::uint32_t) { return kSqueezedLevels; }, point);
  const auto sine_at = [&](int level) { return least_sine({point(0, level), point(1, level), point(2, level)}); };
  return {static_cast<double>(levels), sine_at(levels), sine_at(levels + 1)};
}

}  // namespace

TEST_CASE("cells above a triangle are positive and fill what its columns bound, whatever their counts") {
  const Column column;
  for (int a = 0; a <= 3; ++a)
    for (int b = 0; b <= 3; ++b)
      for (int c = 0; c <= 3; ++c) {
        double volume = 0;
        int cells = 0;
        for_each_cell({a, b, c}, [&](CellKind kind, const auto& corners) {
          std::array<Vec3, std::tuple_size_v<std::decay_t<decltype(corners)>>> x;
          for (std::size_t i = 0; i < x.size(); ++i) x[i] = column.at(corners[i]);
          CHECK(is_positive(x));
          CHECK(scaled_jacobian(x) > 0.05);
          ++cells;
          if (kind == CellKind::Tet) volume += 0.1 * 0.5 / 3;
          if (kind == CellKind::Pyramid) volume += 0.1 * 0.5 * 2 / 3;
          if (kind == CellKind::Prism) volume += 0.1 * 0.5;
        });
        CHECK(cells == std::max({a, b, c}));
        CHECK(volume == Approx(0.5 * 0.1 * (a + b + c) / 3));
      }
}

TEST_CASE("a cell that a split would turn over is not positive") {
  std::array<Vec3, 6> prism{Vec3{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}};
  CHECK(is_positive(prism));
  CHECK(scaled_jacobian(prism) == Approx(std::sqrt(0.5) / (std::sqrt(3.0) / 2)));
  prism[5] = {0.9, -0.4, 1};  // the top triangle is turned over
  CHECK_FALSE(is_positive(prism));
  prism[5] = {0, 1, -0.1};
  CHECK_FALSE(is_positive(prism));
}

TEST_CASE("centres of cells between fronts are centroids, whether all corners grow or not") {
  const std::array<Vec3, 3> foot{Vec3{0, 0, 0}, {3, 0, 0}, {0, 3, 0}};
  const auto above = [&](double share, double height) {
    std::array<Vec3, 3> front;
    for (std::size_t i = 0; i < 3; ++i) front[i] = share * foot[i] + Vec3{1 - share, 1 - share, height};
    return front;
  };
  CHECK(distance(centre_of({foot, above(1, 2)}), {1, 1, 1}) < 1e-12);
  // Of a frustum whose top has half of the width (Archimedes): (1 + 2/2 + 3/4) / (1 + 1/2 + 1/4) / 4 of the height.
  CHECK(distance(centre_of({foot, above(0.5, 2)}), {1, 1, 11.0 / 14}) < 1e-12);
  CHECK(distance(rough_centre_of({foot, above(0.5, 2)}), {1, 1, 1}) < 1e-12);
  const std::array<Vec3, 3> top = above(1, 2);
  for (const auto& cell : {FrontCell{foot, {top[0], foot[1], foot[2]}}, FrontCell{foot, {foot[0], top[1], top[2]}}})
    CHECK(distance(centre_of(cell), rough_centre_of(cell)) < 1e-12);
}

TEST_CASE("a face is skewed by how far the line between two centres misses it") {
  const std::array<Vec3, 4> square{Vec3{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  CHECK(skewness(square, {0, 0, -1}, {0, 0, 1}) == Approx(0).margin(1e-12));
  CHECK(skewness(square, {3, 0, -1}, {3, 0, 1}) == Approx(3));
  CHECK(skewness(square, {3, 3, -1}, {3, 3, 1}) == Approx(3));
  CHECK(skewness(square, {0, 0, -1}, {0, 12, 2}) == Approx(4 / (0.2 * std::sqrt(153))));  // the way counts
  const std::array<Vec3, 4> triangle{Vec3{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {0, 3, 0}};
  CHECK(skewness(triangle, {1, 1, -1}, {1, 1, 1}) == Approx(0).margin(1e-12));
}

TEST_CASE("the most normal direction is the middle of the smallest cone") {
  CHECK(most_normal_direction({}).visibility == 0);
  const std::array<Vec3, 1> one{Vec3{0, 0, 1}};
  CHECK(most_normal_direction(one).visibility == 1);
  // Two faces at a right angle, one of them in many triangles.
  const std::array<Vec3, 5> edge{Vec3{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}};
  const GrowthDirection between = most_normal_direction(edge);
  CHECK(between.visibility == Approx(std::sqrt(0.5)));
  CHECK(distance(between.direction, normalized(Vec3{1, 0, 1})) < 1e-12);
  const std::array<Vec3, 4> corner{Vec3{0, 0, 1}, {0, 1, 0}, {1, 0, 0}, normalized(Vec3{1, 1, 1})};
  CHECK(most_normal_direction(corner).visibility == Approx(1 / std::sqrt(3.0)));
  const std::array<Vec3, 2> opposite{Vec3{0, 0, 1}, {0, 0, -1}};
  CHECK(most_normal_direction(opposite).visibility <= 0);
}

TEST_CASE("a stack ends where its front is too narrow, and sooner above a wall that bends") {
  const std::array straight = squeezed_stack(0, 0.9), bent = squeezed_stack(15, 0.9), sharp = squeezed_stack(60, 0.9);
  CHECK(straight[0] > bent[0]);
  CHECK(sharp[0] == straight[0]);
  for (const auto& [levels, sine, next_sine] : {straight, bent}) {
    CHECK(levels > 1);
    CHECK(levels < kSqueezedLevels);
    CHECK(next_sine < sine);
  }
  CHECK(straight[1] >= std::sin(15 * std::numbers::pi / 180));
  CHECK(straight[2] < std::sin(15.5 * std::numbers::pi / 180));
  CHECK(bent[1] >= std::sin(22.5 * std::numbers::pi / 180));
  CHECK(bent[2] < std::sin(23 * std::numbers::pi / 180));
}

TEST_CASE("a stack ends where the pyramid beside a lower curve is too steep, sooner where more is asked of it") {
  const Walls walls = two_triangles();
  const double third = std::sqrt(0.75);
  const std::vector<Vec3> feet{{0, 0, 0}, {1, 0, 0}, {0.5, -third, 0}, {0.5, third, 0}};
  const TaskRunner runner(1, {});
  const SoundStacks sound(walls, feet, runner);
  // Of two layers, the second one so high, and not above vertex 3.
  const auto levels = [&](double height, double least) {
    return sound.levels(
        1, [](std::uint32_t curve) { return curve == 3 ? 1 : 2; },
        [&](std::uint32_t curve, int level) {
          return feet[curve] + Vec3{0, 0, level == 0 ? 0.0 : level == 1 ? 0.1 : 0.1 + height};
        },
        least);
  };
  // The scaled Jacobian of the pyramid is 1 / sqrt(1 + height²).
  CHECK(levels(2.2, 0.4) == 2);
  CHECK(levels(2.4, 0.4) == 1);
  CHECK(levels(2.4, SoundStacks::kLeastAbove) == 2);
  CHECK(levels(4, SoundStacks::kLeastAbove) == 1);
}

TEST_CASE("a stack goes on where its front stretches, however narrow it becomes") {
  const std::array stretched = squeezed_stack(15, 1.06);
  CHECK(stretched[0] == kSqueezedLevels);
  CHECK(stretched[1] < std::sin(22.5 * std::numbers::pi / 180));
}

TEST_CASE("layers that are thicker than their triangles are wide lean away from concave edges") {
  const auto box = make_box({0, 0, 0}, {4, 4, 4});
  MeshOptions options = options_of_size(0.4);
  options.layers = on_faces(*box, heights(0.008, 14));  // 1.2 edges together
  const MeshResult result = meshed(*box, options);
  CHECK(result.layers.coverage.full_count > 0.98);
  CHECK(result.layers.coverage.first_height_within_10pct > 0.95);
}

TEST_CASE("layers that leave a third of a box's width have all of their thickness") {
  const auto box = make_box({0, 0, 0}, {4, 4, 4});
  MeshOptions options = options_of_size(0.25);
  options.layers = on_faces(*box, heights(0.005, 20));  // 3.7 edges together
  const LayerFigures figures = meshed(*box, options).layers;
  CHECK(figures.coverage.full_count > 0.9);
  CHECK(figures.coverage.thickness > 0.95);
  CHECK(figures.scaled_jacobian_p1 > 0.4);
}

TEST_CASE("what is beside the direction of growth narrows no gap") {
  // Across the square ends, layers along the edges are 1.4 times as long as they are high.
  const auto bar = make_box({0, 0, 0}, {3, 3, 4});
  MeshOptions options = options_of_size(0.25);
  options.layers = on_faces(*bar, heights(0.005, 20));
  const MeshResult result = meshed(*bar, options);
  CHECK(std::ranges::none_of(result.layers.limited,
                             [](const LimitedLayers& limited) { return limited.reason == LayerLimit::Gap; }));
}

TEST_CASE("a front is free along its edges, and nowhere at its corners") {
  const std::array<Vec3, 3> flat{Vec3{0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  const Vec3 way{1, 2, 3};
  CHECK(distance(find_freedom(flat).within(way), Vec3{1, 2, 0}) < 1e-12);
  const std::array<Vec3, 5> edge{Vec3{0, 0, 1}, {0, 0, 1}, {1, 0, 0}, {0, 0, 1}, {0, 0, 1}};
  CHECK(distance(find_freedom(edge).within(way), Vec3{0, 2, 0}) < 1e-12);
  const std::array<Vec3, 3> corner{Vec3{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
  CHECK(norm(find_freedom(corner).within(way)) < 1e-12);
  const std::array<Vec3, 2> opposite{Vec3{0, 0, 1}, {0, 0, -1}};
  CHECK(norm(find_freedom(opposite).within(way)) == 0);
}

TEST_CASE("a front is spread where it shrinks unevenly, and stays where it shrinks evenly") {
  for (const bool is_even : {true, false}) {
    const auto pipe = make_cylinder(1, 4);
    MeshOptions options = options_of_size(0.25);
    options.surface_only = true;
    const Mesh mesh = meshed(*pipe, options).mesh;
    options.layers = on_faces(*pipe, heights(0.02, 6), caps_of(*pipe, 1));
    const Walls walls = find_walls(mesh, pipe->topology().face_to_sides, options.layers);
    std::vector<Vec3> feet, front, normals;
    std::vector<FrontFreedom> freedom;
    for (const std::uint32_t v : walls.curve_to_vert) {
      const Vec3 foot = mesh.points[v], in = -normalized(Vec3{foot.x, foot.y, 0});
      feet.push_back(foot);
      normals.push_back(in);
      freedom.push_back(find_freedom({&in, 1}));
      front.push_back(foot + 0.3 * in);
      if (!is_even) front.back().z += foot.z < 1 ? 0.2 * (1 - foot.z) : 0;  // pushed together from below
    }
    const std::vector<std::uint8_t> is_free(feet.size(), 1);
    const std::vector<double> most(feet.size(), 1);
    const TaskRunner runner(2, {});
    const std::vector<Vec3> shifts = FrontSpreading(walls, feet).find_shifts({front, is_free, freedom, most}, runner);
    double along = 0, out = 0;
    for (std::size_t c = 0; c < feet.size(); ++c) {
      if (feet[c].z > 0.8 && feet[c].z < 1.2) along = std::max(along, shifts[c].z);
      out = std::max(out, std::abs(dot(shifts[c], normals[c])));
      if (is_even) CHECK(norm(shifts[c]) < 0.03);
    }
    CHECK(out < 1e-12);
    if (!is_even) CHECK(along > 0.01);
  }
}

TEST_CASE("layers on all faces of a box leave room in the middle, and the volume stays") {
  const auto box = make_box({0, 0, 0}, {4, 4, 4});
  MeshOptions options = options_of_size(0.4);
  options.layers = on_faces(*box, heights(0.02, 6));
  const MeshResult result = meshed(*box, options);
  CHECK(compute_quality(result.mesh).cells.volume == Approx(64).epsilon(1e-12));
  const LayerFigures& figures = result.layers;
  CHECK(figures.prisms == result.mesh.prism_to_vert.size());
  CHECK(figures.pyramids == result.mesh.pyramid_to_vert.size());
  CHECK(figures.coverage.area == Approx(96));
  CHECK(figures.coverage.at_least_one == Approx(1));
  CHECK(figures.coverage.full_count > 0.99);
  CHECK(figures.coverage.first_height_within_10pct > 0.9);
  CHECK(figures.by_face.size() == 6);
  CHECK(figures.min_scaled_jacobian >= 0.02);
}

TEST_CASE("tets above layers get as many rounds of repairs as a surface that may change") {
  const auto pipe = make_cylinder(1, 4);
  MeshOptions options = options_of_size(0.2);
  options.layers = on_faces(*pipe, heights(0.01, 14));  // three edges together
  const MeshResult result = meshed(*pipe, options);
  CHECK(result.layers.coverage.thickness > 0.9);
  CHECK(result.filling.optimizer.below_dihedral <= 2);  // with two rounds: 5
}

TEST_CASE("heights above the middle of a flat wall are those asked for") {
  const auto box = make_box({0, 0, 0}, {4, 4, 4});
  MeshOptions options = options_of_size(0.4);
  options.layers = on_faces(*box, heights(0.01, 8, 1.3));
  const Mesh mesh = meshed(*box, options).mesh;
  // Prisms one above the other share the ends of their edges.
  std::size_t looked_at = 0;
  for (std::size_t p = 0; p < mesh.prism_to_vert.size(); ++p) {
    const auto& prism = mesh.prism_to_vert[p];
    const Vec3 &low = mesh.points[prism[0]], &high = mesh.points[prism[3]];
    if (mesh.point_to_entity[prism[0]].dim != 2 || low.z != 0 ||
        std::max(std::abs(low.x - 2), std::abs(low.y - 2)) > 0.8)
      continue;
    ++looked_at;
    CHECK(high.z - low.z == Approx(0.01).epsilon(1e-3));
  }
  CHECK(looked_at > 10);
  REQUIRE(mesh.cell_fields.size() == 3);
  CHECK(mesh.cell_fields[0].name == "layer");
  CHECK(mesh.cell_fields[1].name == "height");
  CHECK(mesh.cell_fields[2].name == "stack");
  const auto& layer = mesh.cell_fields[0].values;
  CHECK(*std::ranges::max_element(layer) == 8);
  CHECK(layer.size() == mesh.tet_to_vert.size() + mesh.pyramid_to_vert.size() + mesh.prism_to_vert.size());
}

TEST_CASE("layers in a pipe stand on its ends, which stay flat to the last bit") {
  const auto pipe = make_cylinder(1, 4);
  const std::vector<std::uint32_t> caps = caps_of(*pipe, 1);
  REQUIRE(caps.size() == 2);
  MeshOptions options = options_of_size(0.25);
  options.layers = on_faces(*pipe, heights(0.02, 6), caps);
  const MeshResult result = meshed(*pipe, options);
  const Mesh& mesh = result.mesh;
  CHECK(result.layers.coverage.full_count > 0.99);
  CHECK(mesh.quad_to_vert.size() > 6 * 2 * 20);
  for (std::size_t q = 0; q < mesh.quad_to_vert.size(); ++q) {
    CHECK(std::ranges::count(caps, mesh.quad_to_entity[q]) == 1);
    const double z = mesh.points[mesh.quad_to_vert[q][0]].z;
    for (const std::uint32_t v : mesh.quad_to_vert[q]) CHECK(mesh.points[v].z == z);
  }
  for (std::size_t p = 0; p < mesh.points.size(); ++p)
    if (mesh.point_to_entity[p].dim == 2 && std::ranges::count(caps, mesh.point_to_entity[p].index) == 1)
      CHECK((std::abs(mesh.points[p].z) < 1e-300 || mesh.points[p].z == 4 || std::abs(mesh.points[p].z) == 2));
}

TEST_CASE("on two faces of a box, layers run along the edges between the other faces") {
  const auto box = make_box({0, 0, 0}, {4, 4, 4});
  MeshOptions options = options_of_size(0.4);
  options.layers = on_faces(*box, heights(0.05, 5));
  options.layers.walls.resize(1);
  const MeshResult result = meshed(*box, options);
  CHECK(result.layers.coverage.full_count == Approx(1));
  CHECK(compute_quality(result.mesh).cells.volume == Approx(64).epsilon(1e-12));
  // 5 layers on each of 4 sides, and an edge of each layer at 4 corners.
  CHECK(result.mesh.quad_to_vert.size() % 20 == 0);
  CHECK(result.mesh.pyramid_to_vert.empty());
}

TEST_CASE("meshes with layers are the same on any number of threads") {
  const auto pipe = make_cylinder(1, 2);
  MeshOptions options = options_of_size(0.3, 1);
  options.layers = on_faces(*pipe, heights(0.03, 5));
  const std::string digest = mesh_digest(meshed(*pipe, options).mesh);
  for (const int threads : {2, 4}) {
    options.threads = threads;
    CHECK(mesh_digest(meshed(*pipe, options).mesh) == digest);
  }
}

TEST_CASE("layers are split into tets that fit") {
  const auto pipe = make_cylinder(1, 2);
  MeshOptions options = options_of_size(0.3);
  options.layers = on_faces(*pipe, heights(0.03, 5), caps_of(*pipe, 1));
  const Mesh whole = meshed(*pipe, options).mesh;
  options.layers.all_tets = true;
  const Mesh split = meshed(*pipe, options).mesh;
  CHECK(split.prism_to_vert.empty());
  CHECK(split.pyramid_to_vert.empty());
  CHECK(split.quad_to_vert.empty());
  CHECK(split.tet_to_vert.size() ==
        whole.tet_to_vert.size() + 2 * whole.pyramid_to_vert.size() + 3 * whole.prism_to_vert.size());
  CHECK(compute_quality(split).cells.volume == Approx(compute_quality(whole).cells.volume).epsilon(1e-12));
}

TEST_CASE("where walls are near each other there are fewer layers, and the reason is told") {
  const auto plate = make_box({0, 0, 0}, {4, 4, 0.5});
  MeshOptions options = options_of_size(0.2);
  options.layers = on_faces(*plate, heights(0.05, 12));
  const MeshResult result = meshed(*plate, options);
  CHECK(result.layers.coverage.at_least_one > 0.95);
  CHECK(result.layers.coverage.full_count < 0.1);
  REQUIRE_FALSE(result.layers.limited.empty());
  CHECK(std::ranges::any_of(result.layers.limited,
                            [](const LimitedLayers& limited) { return limited.reason == LayerLimit::Gap; }));
}

TEST_CASE("layers grow on both sides of a ball, inwards and outwards") {
  const auto ball = make_sphere({0, 0, 0}, 1);
  MeshOptions options = options_of_size(0.2);
  options.layers = on_faces(*ball, heights(0.01, 10));
  const MeshResult result = meshed(*ball, options);
  CHECK(result.layers.coverage.full_count > 0.99);
  CHECK(result.layers.coverage.first_height_within_10pct > 0.95);
}

TEST_CASE("layers without a number end where they are as high as wide") {
  const auto box = make_box({0, 0, 0}, {8, 8, 8});
  MeshOptions options = options_of_size(0.5);
  options.layers = on_faces(*box, heights(0.05, 0, 1.5));
  const MeshResult result = meshed(*box, options);
  const auto& height = result.mesh.cell_fields[1].values;
  CHECK(*std::ranges::max_element(height) > 0.3);
  options.layers = on_faces(*box, heights(0.05, 0, 1.5));
  for (WallLayers& wall : options.layers.walls) wall.thickness = 0.2;
  const MeshResult thin = meshed(*box, options);
  CHECK(*std::ranges::max_element(thin.mesh.cell_fields[0].values) == 2);
}

TEST_CASE("layers that cannot be are refused with the face") {
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  const auto refusal = [&](const std::function<void(WallLayers&)>& spoil) {
    MeshOptions options = options_of_size(0.2);
    options.layers = on_faces(*box, heights(0.01, 5));
    spoil(options.layers.walls[2]);
    const Diagnostic diagnostic = error_of([&] { make_mesh(*box, options); });
    CHECK(diagnostic.code == ErrorCode::InvalidArgument);
    CHECK(diagnostic.entities.size() == 1);
    return diagnostic;
  };
  const Diagnostic flat = refusal([](WallLayers& wall) { wall.first_height = -1; });
  REQUIRE(flat.point);
  CHECK(distance(*flat.point, Vec3{0.5, 0.5, 0.5}) == Approx(0.5));  // the middle of a side
  CHECK(refusal([](WallLayers& wall) { wall.first_height = 0; }).entities.at(0).entity.tag() == 3);
  refusal([](WallLayers& wall) { wall.first_height = NAN; });
  refusal([](WallLayers& wall) { wall.first_height = 100; });
  refusal([](WallLayers& wall) { wall.growth = 0.9; });
  refusal([](WallLayers& wall) { wall.growth = INFINITY; });
  refusal([](WallLayers& wall) { wall.count = -1; });
  refusal([](WallLayers& wall) { wall.count = 1001; });
  refusal([](WallLayers& wall) { wall.thickness = -1; });
  refusal([](WallLayers& wall) { wall.face = ModelFaceId(17u); });
  refusal([](WallLayers& wall) { wall.face = ModelFaceId(0u); });
  refusal([](WallLayers& wall) { wall.in_front = wall.behind = false; });
  MeshOptions options = options_of_size(0.2);
  options.layers = on_faces(*box, heights(0.01, 5));
  options.order = 2;
  options.layers.all_tets = true;  // of tets alone they are of first order
  CHECK(error_of([&] { make_mesh(*box, options); }).code == ErrorCode::InvalidArgument);
  options.order = 1;
  options.surface_only = true;
  CHECK(error_of([&] { make_mesh(*box, options); }).code == ErrorCode::InvalidArgument);
}

TEST_CASE("layers that memory cannot hold are refused with a face and a point before they grow") {
  const auto box = make_box({0, 0, 0}, {1, 1, 1});
  MeshOptions options = options_of_size(0.1);
  options.layers = on_faces(*box, heights(1e-5, 1000, 1.0));
  options.max_memory = 64 << 20;
  const MeshResult result = make_mesh(*box, options);
  CHECK(result.status == MeshStatus::Failed);
  REQUIRE(result.errors.size() == 1);
  CHECK(result.errors[0].code == ErrorCode::OutOfMemory);
  CHECK(result.errors[0].entities.size() == 1);
  CHECK(result.errors[0].point.has_value());
  CHECK(result.mesh.prism_to_vert.empty());
}

TEST_CASE("figures of layers tell heights, growth and angles at the wall") {
  const auto box = make_box({0, 0, 0}, {4, 4, 4});
  MeshOptions options = options_of_size(0.4);
  options.layers = on_faces(*box, heights(0.05, 5));
  options.layers.walls.resize(1);
  const LayerFigures figures = meshed(*box, options).layers;
  CHECK(figures.coverage.first_height_error < 1e-9);
  CHECK(figures.coverage.growth_error < 1e-6);
  CHECK(figures.first_angle_p99 < 1e-3);
  REQUIRE(figures.by_face.size() == 1);
  CHECK(figures.by_face[0].coverage.first_height_error == figures.coverage.first_height_error);
  const auto ball = make_sphere({0, 0, 0}, 1);
  options = options_of_size(0.3);
  options.layers = on_faces(*ball, heights(0.02, 6));
  const LayerFigures round = meshed(*ball, options).layers;
  CHECK(round.coverage.first_height_error > 0);
  CHECK(round.coverage.first_height_error < 0.1);
  CHECK(round.first_angle_p99 > 0.5);
  CHECK(round.first_angle_p99 < 15);
}

TEST_CASE("first cells stay near the wall's normal beside edges") {
  const auto pipe = make_cylinder(1, 2);  // its side bends by 20 degrees from triangle to triangle
  for (const double size : {0.35, 0.4}) {
    MeshOptions options = options_of_size(size);
    options.layers = on_faces(*pipe, heights(0.015, 6));
    const LayerFigures figures = meshed(*pipe, options).layers;
    CHECK(figures.coverage.thickness > 0.99);
    CHECK(figures.first_angle_p99 < 15);
  }
}
