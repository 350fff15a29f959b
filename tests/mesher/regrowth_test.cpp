// What stays of layers when a fan is taken back.
#include <algorithm>
#include <catch2/catch.hpp>

#include "mesher/layers/layer_counts.hpp"
#include "mesher/layers/regrowth.hpp"
#include "tests/mesher/layers_fixture.hpp"

using namespace tetloom;
using namespace tetloom::layers;
using namespace tetloom::test_layers;
using namespace tetloom::test_models;

namespace {

// Around a long bar, with fans at all of its edges, and with none at one vertex in the middle of an edge.
struct Regrown {
  std::unique_ptr<GeometricModel> model = put_into_box(make_box({0, 0, 0}, {20, 1, 1}), 2);
  TaskRunner runner{2, {}};
  Mesh mesh;
  std::uint32_t blunt = kNone;
  Walls before, walls;

  Regrown() {
    MeshOptions options = options_of_size(0.4);
    options.surface_only = true;
    mesh = meshed(*model, options).mesh;
    for (std::uint32_t v = 0; v < mesh.points.size(); ++v) {
      const Vec3& x = mesh.points[v];
      if (x.y == 0 && x.z == 0 && (blunt == kNone || std::abs(x.x - 10) < std::abs(mesh.points[blunt].x - 10)))
        blunt = v;
    }
    const auto faces = static_cast<std::uint32_t>(model->topology().face_count());
    const LayerOptions layers =
        on_faces(*model, heights(0.02, 8), {faces - 6, faces - 5, faces - 4, faces - 3, faces - 2, faces - 1});
    before = find_walls(mesh, model->topology().face_to_sides, layers);
    const std::array<std::uint32_t, 1> blunt_verts{blunt};
    walls = find_walls(mesh, model->topology().face_to_sides, layers, blunt_verts);
  }
  double way(std::uint32_t curve) const {
    return distance(mesh.points[walls.curve_to_vert[curve]], mesh.points[blunt]);
  }
  GrowthPaths paths_of(const Walls& of, const KeptPaths& kept = {}) const {
    const SideFaces sides(*model, mesh, of, runner);
    return make_paths({mesh, model->topology().face_to_sides, of, sides}, runner, kept);
  }
};

}  // namespace

TEST_CASE("curves are kept that are some edges away from where a fan is taken back") {
  const Regrown regrown;
  const std::vector<std::uint32_t> kept = find_kept_curves(regrown.walls, regrown.before, 3);
  REQUIRE(kept.size() == regrown.walls.curve_count());
  REQUIRE(regrown.walls.fan_vertices.size() == regrown.before.fan_vertices.size() - 1);
  for (std::uint32_t c = 0; c < kept.size(); ++c) {
    if (regrown.way(c) < 0.9) CHECK(kept[c] == kNone);
    if (regrown.way(c) > 4) REQUIRE(kept[c] != kNone);
    if (kept[c] == kNone) continue;
    CHECK(regrown.walls.curve_to_vert[c] == regrown.before.curve_to_vert[kept[c]]);
    CHECK(regrown.walls.curve_to_direction[c] == regrown.before.curve_to_direction[kept[c]]);
  }
  const std::vector<std::uint32_t> same = find_kept_curves(regrown.walls, regrown.walls);
  for (std::uint32_t c = 0; c < same.size(); ++c) CHECK(same[c] == c);
}

TEST_CASE("kept curves go where they went before, and the others as if all were grown anew") {
  const Regrown regrown;
  const std::vector<std::uint32_t> kept = find_kept_curves(regrown.walls, regrown.before);
  REQUIRE(std::ranges::count(kept, kNone) > 10);
  REQUIRE(std::ranges::count(kept, kNone) < static_cast<std::ptrdiff_t>(kept.size()) / 2);
  const GrowthPaths before = regrown.paths_of(regrown.before), anew = regrown.paths_of(regrown.walls),
                    paths = regrown.paths_of(regrown.walls, {&before, kept});
  REQUIRE(before.fans_without_room.empty());
  for (std::uint32_t c = 0; c < kept.size(); ++c) {
    CHECK(paths.reached[c] == Approx(anew.reached[c]));
    CHECK(distance(paths.fronts.back()[c], anew.fronts.back()[c]) < 1e-3);
    if (kept[c] == kNone) continue;
    CHECK(paths.reached[c] == before.reached[kept[c]]);
    CHECK(paths.fronts.back()[c] == before.fronts.back()[kept[c]]);
  }
}

TEST_CASE("counts of kept curves are no higher than before") {
  const Regrown regrown;
  const std::vector<std::uint32_t> kept = find_kept_curves(regrown.walls, regrown.before);
  const GrowthPaths before = regrown.paths_of(regrown.before), paths = regrown.paths_of(regrown.walls, {&before, kept});
  std::vector<KeptCount> few(kept.size());
  for (std::size_t c = 0; c < few.size(); ++c)
    if (kept[c] != kNone) few[c] = {2, LayerLimit::Crossing};
  const SideFaces sides(*regrown.model, regrown.mesh, regrown.walls, regrown.runner);
  LayerCounts counts(regrown.walls, sides, paths, regrown.runner, few);
  counts.settle(regrown.runner);
  std::size_t more = 0;
  for (std::uint32_t c = 0; c < kept.size(); ++c) {
    if (kept[c] == kNone) more += counts.count(c) > 2;
    if (kept[c] == kNone) continue;
    CHECK(counts.count(c) == 2);
    CHECK(counts.limit(c) == LayerLimit::Crossing);
  }
  CHECK(more > 0);
}
