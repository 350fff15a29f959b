// Layers on random walls of random models: valid, filling the model to the last bit of its volume, the same on any
// number of threads.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <memory>
#include <numbers>
#include <random>

#include "mesher/layers/layer_counts.hpp"
#include "mesher/layers/room_above.hpp"
#include "tests/mesher/layers_fixture.hpp"
#include "tests/support/error_of.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using namespace tetloom::layers;
using namespace tetloom::test_layers;
using namespace tetloom::test_models;

namespace {

class Dice {
 public:
  explicit Dice(std::uint32_t seed) : engine_(seed) {}
  double between(double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(engine_()) / static_cast<double>(std::mt19937::max());
  }
  int below(int end) { return static_cast<int>(engine_() % static_cast<std::uint32_t>(end)); }

 private:
  std::mt19937 engine_;
};

std::unique_ptr<GeometricModel> random_model(Dice& dice) {
  const auto degrees = [](double angle) { return angle * std::numbers::pi / 180; };
  switch (dice.below(6)) {
    case 0: return make_box({0, 0, 0}, {dice.between(0.5, 2), dice.between(0.5, 2), dice.between(0.5, 2)});
    case 1: return make_cylinder(dice.between(0.4, 1), dice.between(0.5, 2));
    case 2: return make_cone(dice.between(0.4, 1), dice.between(0.5, 2));
    case 3: {  // a cusp
      const double rise = std::tan(degrees(dice.between(2, 30)));
      return bar({{0, 0}, {1.5, 0}, {1.5, 1.5 * rise}}, dice.between(0.5, 1));
    }
    case 4: {  // a gap
      return make_box({0, 0, 0}, {dice.between(0.6, 1.2), dice.between(0.6, 1.2), 0.3 * dice.between(0.05, 2)});
    }
    default: {  // faces beside each other at this angle
      const double angle = degrees(dice.between(25, 155)), lean = std::cos(angle) / std::sin(angle);
      return bar({{0, 0}, {1.5, 0}, {1.5 + lean * 0.6 + 0.1, 0.6}, {lean * 0.6, 0.6}}, dice.between(0.5, 1));
    }
  }
}

LayerOptions random_walls(const GeometricModel& model, Dice& dice) {
  LayerOptions options;
  for (std::uint32_t f = 0; f < model.topology().face_count(); ++f) {
    WallLayers wall = heights(0.3 * std::pow(10, dice.between(-3, -0.5)), dice.below(12), dice.between(1, 1.6));
    wall.face = ModelFaceId(f);
    if (dice.below(3) > 0) options.walls.push_back(wall);
  }
  return options;
}

// What the triangles and bilinear quadrilaterals of the boundary enclose; their normals point out of the one region.
double enclosed_volume(const Mesh& mesh) {
  double volume = 0;
  const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, double share) {
    volume += share * dot(mesh.points[a], cross(mesh.points[b], mesh.points[c])) / 6;
  };
  for (const auto& [a, b, c] : mesh.tri_to_vert) add(a, b, c, 1);
  for (const auto& [a, b, c, d] : mesh.quad_to_vert) {
    add(a, b, c, 0.5), add(a, c, d, 0.5);
    add(a, b, d, 0.5), add(b, c, d, 0.5);
  }
  return volume;
}

struct CellFace {
  std::vector<Vec3> points;
  Vec3 area, middle;
  std::vector<Vec3> cells;  // centroids
};

void measure(CellFace& face) {
  Vec3 mean, sum;
  for (const Vec3& x : face.points) mean += x / static_cast<double>(face.points.size());
  double areas = 0;
  for (std::size_t i = 0; i < face.points.size(); ++i) {
    const Vec3 &a = face.points[i], &b = face.points[(i + 1) % face.points.size()];
    const Vec3 area = 0.5 * cross(b - a, mean - a);
    face.area += area, areas += norm(area), sum += norm(area) / 3 * (a + b + mean);
  }
  face.middle = sum / areas;
}

// As OpenFOAM has it: centroids of cells by the pyramids on their faces.
void add_faces(const Mesh& mesh, CellKind kind, std::span<const std::uint32_t> cell,
               std::map<std::vector<std::uint32_t>, CellFace>& faces) {
  std::vector<std::pair<std::vector<std::uint32_t>, CellFace>> around;
  Vec3 inside, sum;
  for (const LocalFace& local : shape_of(kind).faces()) {
    auto& [verts, face] = around.emplace_back();
    for (const std::uint8_t i : local.vertices()) verts.push_back(cell[i]), face.points.push_back(mesh.points[cell[i]]);
    measure(face);
    std::ranges::sort(verts);
    inside += face.middle / static_cast<double>(shape_of(kind).face_count);
  }
  double volume = 0;
  for (const auto& [verts, face] : around) {
    const double pyramid = dot(face.area, face.middle - inside);
    volume += pyramid, sum += pyramid * (0.75 * face.middle + 0.25 * inside);
  }
  for (const auto& [verts, face] : around) faces.try_emplace(verts, face).first->second.cells.push_back(sum / volume);
}

// A flat lens with a tip, its rim in the plane z = 0, thickest so far from the tip.
std::shared_ptr<const GeometricModel> lens(double degrees_at_tip, double thickest = 2.7) {
  const double half = 4 * std::tan(degrees_at_tip / 2 * std::numbers::pi / 180);
  const std::array<Vec3, 5> points{
      Vec3{0, 0, 0}, {-half, -4, 0}, {half, -4, 0}, {0, -thickest, 0.3}, {0, -thickest, -0.3}};
  const std::vector<std::vector<std::uint32_t>> faces{{0, 1, 3}, {1, 2, 3}, {2, 0, 3}, {1, 0, 4}, {2, 1, 4}, {0, 2, 4}};
  return make_polyhedron(points, faces);
}

// On all faces but the six of the box, which come last.
MeshResult layers_around(const GeometricModel& in_box, double first_height) {
  MeshOptions options = options_of_size(0.4);
  const auto faces = static_cast<std::uint32_t>(in_box.topology().face_count());
  options.layers =
      on_faces(in_box, heights(first_height, 8), {faces - 6, faces - 5, faces - 4, faces - 3, faces - 2, faces - 1});
  return meshed(in_box, options);
}

// Of faces between two cells, as OpenFOAM measures it.
double largest_skewness(const Mesh& mesh) {
  std::map<std::vector<std::uint32_t>, CellFace> faces;
  for (const auto& cell : mesh.tet_to_vert) add_faces(mesh, CellKind::Tet, cell, faces);
  for (const auto& cell : mesh.pyramid_to_vert) add_faces(mesh, CellKind::Pyramid, cell, faces);
  for (const auto& cell : mesh.prism_to_vert) add_faces(mesh, CellKind::Prism, cell, faces);
  for (const auto& cell : mesh.hex_to_vert) add_faces(mesh, CellKind::Hex, cell, faces);
  double largest = 0;
  for (const auto& [verts, face] : faces) {
    if (face.cells.size() != 2) continue;
    const Vec3 way = face.cells[1] - face.cells[0], to_face = face.middle - face.cells[0];
    const Vec3 off = to_face - dot(face.area, to_face) / dot(face.area, way) * way;
    double extent = 0.2 * norm(way);
    for (const Vec3& x : face.points) extent = std::max(extent, std::abs(dot(normalized(off), x - face.middle)));
    largest = std::max(largest, norm(off) / extent);
  }
  return largest;
}

}  // namespace

TEST_CASE("random layers on random models are valid and fill them") {
  for (std::uint32_t seed = 1; seed <= 40; ++seed) {
    CAPTURE(seed);
    Dice dice(seed);
    const auto model = random_model(dice);
    MeshOptions options = options_of_size(0.3, 1);
    options.layers = random_walls(*model, dice);
    options.layers.all_tets = dice.below(4) == 0;
    const MeshResult result = meshed(*model, options);
    CHECK(compute_quality(result.mesh).cells.volume == Approx(enclosed_volume(result.mesh)).epsilon(1e-12));
    if (result.layers.prisms > 0) CHECK(result.layers.min_scaled_jacobian >= 0.02 * (1 - 1e-6));
    if (seed % 8 != 0) continue;
    const std::string digest = mesh_digest(result.mesh);
    options.threads = 2;
    CHECK(mesh_digest(meshed(*model, options).mesh) == digest);
  }
}

TEST_CASE("where no layer fits, the mesh is that without layers") {
  for (const bool is_round : {false, true}) {
    const auto model = is_round ? make_cylinder(0.5, 1) : make_box({0, 0, 0}, {1, 1, 1});
    MeshOptions options = options_of_size(0.3);
    const std::string digest = mesh_digest(meshed(*model, options).mesh);
    options.layers = on_faces(*model, heights(0.9, 3));
    const MeshResult result = meshed(*model, options);
    CHECK(result.layers.coverage.at_least_one == 0);
    CHECK(mesh_digest(result.mesh) == digest);
  }
}

TEST_CASE("narrow faces between wide ones keep their layers, but where more than one cell in a hundred would be poor") {
  const auto chamfered = bar({{0, 0}, {2, 0}, {2, 1.95}, {1.95, 2}, {0, 2}}, 2);
  MeshOptions options = options_of_size(0.4);
  options.layers = on_faces(*chamfered, heights(0.02, 6));
  const LayerFigures figures = meshed(*chamfered, options).layers;
  CHECK(figures.coverage.at_least_one == Approx(1));
  CHECK(figures.coverage.full_count > 0.85);
  CHECK(figures.coverage.thickness > 0.94);
  CHECK(figures.scaled_jacobian_p1 >= 0.4);
}

TEST_CASE("where layers are lowered late, those around them stay") {
  const auto block = bar({{0, 0}, {24, 0}, {24, 12}, {12, 12}, {12, 24}, {0, 24}}, 12);
  MeshOptions options = options_of_size(1);
  options.surface_only = true;
  const Mesh mesh = meshed(*block, options).mesh;
  const auto& sides_of_faces = block->topology().face_to_sides;
  const Walls walls = find_walls(mesh, sides_of_faces, on_faces(*block, heights(0.02, 20)));  // 3.7 edges together
  const TaskRunner runner(2, {});
  const SideFaces sides(*block, mesh, walls, runner);
  LayerCounts counts(walls, sides, make_paths({mesh, sides_of_faces, walls, sides}, runner), runner);
  counts.settle(runner);
  for (std::uint32_t c = 0; c < walls.curve_count(); c += 100)
    counts.lower(c, counts.count(c) / 2, LayerLimit::Crossing);
  counts.settle(runner);
  for (std::uint32_t c = 0; c < walls.curve_count(); ++c) REQUIRE(counts.count(c) > 0);
}

TEST_CASE("no face between two layer cells is skewed by four or more, in no layer") {
  for (const double degrees : {42.0, 60.0, 64.0, 68.0, 71.0, 75.0, 77.0}) {
    INFO("an edge of " << degrees << " degrees");
    const double rise = std::tan(degrees * std::numbers::pi / 180);
    const std::array<double, 2> tip = rise < 1 ? std::array{4.0, 4 * rise} : std::array{4 / rise, 4.0};
    const auto wedge = bar({{0, 0}, {4, 0}, tip}, 3);
    MeshOptions options = options_of_size(0.5);
    options.layers = on_faces(*wedge, heights(5e-5, 42));
    CHECK(largest_skewness(meshed(*wedge, options).mesh) < 4);
  }
}

TEST_CASE("no face of a fan is skewed by four or more where its edge turns at a tip") {
  for (const double degrees : {30.0, 52.0, 70.0}) {
    INFO("a tip of " << degrees << " degrees");
    const MeshResult result = layers_around(*put_into_box(lens(degrees), 3), 0.02);
    CHECK(result.layers.fans > 0);
    CHECK(largest_skewness(result.mesh) < 4);
  }
}

TEST_CASE("no face of a first layer is skewed by four or more where a fan ends") {
  for (const double degrees : {30.0, 70.0}) {
    INFO("a tip of " << degrees << " degrees");
    const double thickest = 3.8;  // its rim is blunt opposite to the tip
    const MeshResult result = layers_around(*put_into_box(lens(degrees, thickest), 3), 0.01);
    CHECK(result.layers.fans > 0);
    CHECK(largest_skewness(result.mesh) < 4);
  }
}

TEST_CASE("fronts that come too near to each other give way, both of them") {
  const auto plate = make_box({0, 0, 0}, {2, 2, 1});
  MeshOptions options = options_of_size(0.5);
  options.surface_only = true;
  const Mesh mesh = meshed(*plate, options).mesh;
  std::vector<std::uint32_t> others;  // than those of z 0 and 1
  for (std::uint32_t f = 0; f < plate->topology().face_count(); ++f)
    if (plate->area(ModelFaceId(f)) < 3) others.push_back(f);
  const auto& sides_of_faces = plate->topology().face_to_sides;
  const Walls walls = find_walls(mesh, sides_of_faces, on_faces(*plate, heights(0.05, 9, 1), others));
  const TaskRunner runner(2, {});
  const SideFaces sides(*plate, mesh, walls, runner);
  GrowthPaths paths;
  const std::vector<double> none(walls.curve_count(), 0), reached(walls.curve_count(), 0.45);
  paths.fronts.resize(2), paths.heights = {none, reached}, paths.reached = reached;
  for (const std::uint32_t v : walls.curve_to_vert) {
    const Vec3 foot = mesh.points[v];
    paths.fronts[0].push_back(foot);
    paths.fronts[1].push_back({foot.x, foot.y, foot.z < 0.5 ? 0.45 : 0.55});  // a tenth is left
  }
  paths.stretch.assign(walls.curve_count(), 1);
  paths.limits.assign(walls.curve_count(), LayerLimit::None);
  LayerCounts counts(walls, sides, paths, runner);
  const std::vector<std::uint8_t> all(walls.curve_count(), 1), nobody(walls.curve_count(), 0);
  const auto find_lacking = [&](const std::vector<std::uint8_t>& asked) {
    return find_lacking_room(walls, counts, make_layered_surface(mesh, sides_of_faces, walls, sides, counts, {}), asked,
                             runner);
  };
  CHECK(find_lacking(nobody) == none);
  const std::vector<double> lacking = find_lacking(all);
  for (std::uint32_t c = 0; c < lacking.size(); ++c) {
    CHECK(lacking[c] > 0.04);
    CHECK(lacking[c] < 0.12);
    counts.thin(c, lacking[c], LayerLimit::Gap);
    CHECK(counts.count(c) > 4);
  }
  CHECK(find_lacking(all) == none);
}
