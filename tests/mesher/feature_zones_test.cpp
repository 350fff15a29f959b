// The zones around small triangles: what they hold, and that changing them apart and from memory changes nothing.
#include <algorithm>
#include <catch2/catch.hpp>
#include <random>
#include <set>

#include "mesher/features/eliminate_features.hpp"
#include "mesher/features/zones.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::features;

namespace {

/// Squares cut in two, `count` in a row, in one face, with a model edge along every tenth row of points. Some points
/// lie beside their neighbours.
Mesh make_grid(std::uint32_t count, unsigned seed) {
  Mesh mesh;
  const std::uint32_t row = count + 1;
  std::mt19937 random(seed);
  for (std::uint32_t j = 0; j < row; ++j)
    for (std::uint32_t i = 0; i < row; ++i) {
      const bool is_inside = i > 0 && i < count && j > 0 && j < count;
      const double shift = is_inside && random() % 150 == 0 ? 0.97 : 0;
      mesh.points.push_back({i + shift, double(j), 0});
      mesh.point_to_entity.push_back(j % 10 == 0 ? ModelEntity(ModelEdgeId(j / 10)) : ModelEntity(ModelFaceId(0)));
    }
  for (std::uint32_t j = 0; j < count; ++j)
    for (std::uint32_t i = 0; i < count; ++i) {
      const std::uint32_t a = row * j + i, b = a + 1, c = a + row, d = c + 1;
      mesh.tri_to_vert.insert(mesh.tri_to_vert.end(), {{a, b, d}, {a, d, c}});
      mesh.tri_to_entity.insert(mesh.tri_to_entity.end(), 2, 0);
      if (j % 10 != 0) continue;
      mesh.edge_to_vert.push_back({a, b});
      mesh.edge_to_entity.push_back(j / 10);
    }
  mesh.face_to_sides.resize(1);
  return mesh;
}

struct Tolerances {
  std::vector<double> tolerances, sizes;
  explicit Tolerances(const Mesh& mesh) : tolerances(mesh.points.size(), 0.1), sizes(mesh.points.size(), 1) {}
  FeatureElimination how() const { return {tolerances, sizes, {}}; }
};

void check_equal(const EliminationResult& a, const EliminationResult& b) {
  REQUIRE(a.mesh.has_value() == b.mesh.has_value());
  CHECK(a.changed == b.changed);
  CHECK(a.collapses == b.collapses);
  CHECK(a.snaps == b.snaps);
  if (!a.mesh) return;
  CHECK(a.mesh->points == b.mesh->points);
  CHECK(a.mesh->tri_to_vert == b.mesh->tri_to_vert);
  CHECK(a.mesh->edge_to_vert == b.mesh->edge_to_vert);
  CHECK(a.mesh->edge_to_entity == b.mesh->edge_to_entity);
}

}  // namespace

TEST_CASE("zones share no point, and points that may move have all their triangles and pieces in them") {
  const Mesh mesh = make_grid(60, 1);
  const std::vector<std::uint32_t> small{0, 3001, 3007, 5000};
  const Zones zones = find_zones(mesh, small);
  CHECK(zones.items.size() == 3);  // the two in the middle hang together
  std::set<std::uint32_t> seen;
  for (const ZoneItems& zone : zones.items)
    for (const std::uint32_t v : zone.points) CHECK(seen.insert(v).second);
  for (const std::uint32_t t : small)
    for (const std::uint32_t v : mesh.tri_to_vert[t]) CHECK_FALSE(zones.is_near_border[v]);
  const auto may_move = [&](std::uint32_t v) { return zones.point_to_zone[v] != kNone && !zones.is_near_border[v]; };
  for (std::size_t t = 0; t < mesh.tri_to_vert.size(); ++t)
    for (const std::uint32_t v : mesh.tri_to_vert[t])
      if (may_move(v)) CHECK(zones.tri_to_zone[t] == zones.point_to_zone[v]);
  for (std::size_t p = 0; p < mesh.edge_to_vert.size(); ++p)
    for (const std::uint32_t v : mesh.edge_to_vert[p])
      if (may_move(v)) CHECK(zones.piece_to_zone[p] == zones.point_to_zone[v]);
}

TEST_CASE("a piece that leaves its zone keeps its ends") {
  Mesh mesh = make_grid(60, 1);
  mesh.edge_to_vert.push_back({0, 61 * 61 - 1});
  mesh.edge_to_entity.push_back(9);
  const Zones zones = find_zones(mesh, std::vector<std::uint32_t>{0});
  CHECK(zones.is_near_border[0]);
  CHECK(zones.piece_to_zone.back() == kNone);
}

TEST_CASE("zones changed by several threads, or known from before, give the same surface") {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    INFO("seed " << seed);
    const Mesh mesh = make_grid(100, seed);
    Tolerances given(mesh);
    const EliminationResult alone = eliminate_small_features(mesh, given.how(), TaskRunner(1));
    REQUIRE(alone.mesh);
    REQUIRE(alone.collapses > 10);
    KnownZones known;
    check_equal(eliminate_small_features(mesh, given.how(), TaskRunner(2), &known), alone);
    check_equal(eliminate_small_features(mesh, given.how(), TaskRunner(2), &known), alone);
    // Another tolerance in one half: what is known there does not hold any more.
    for (std::size_t v = 0; v < mesh.points.size() / 2; ++v) given.tolerances[v] = 0.001;
    const EliminationResult other = eliminate_small_features(mesh, given.how(), TaskRunner(1));
    CHECK(other.collapses < alone.collapses);
    check_equal(eliminate_small_features(mesh, given.how(), TaskRunner(2), &known), other);
  }
}

TEST_CASE("a zone is known as long as nothing that its change depends on is another") {
  const Mesh mesh = make_grid(20, 3);
  const std::vector<std::uint32_t> small{300};
  const Zones zones = find_zones(mesh, small);
  REQUIRE(zones.items.size() == 1);
  const std::size_t count = zones.items[0].points.size();
  const Zone zone{take_items(mesh, zones.items[0], zones.point_in_zone),
                  std::vector<double>(count, 0.1),
                  std::vector<double>(count, 1),
                  std::vector<std::uint8_t>(count, 0),
                  {5}};
  const std::vector one{std::make_shared<const KnownZone>(zone, ZoneChange{})};
  const KnownZones known(one);
  CHECK(known.find(zone));
  const auto is_known_after = [&](const auto& change) {
    Zone other = zone;
    change(other);
    return known.find(other) != nullptr;
  };
  CHECK_FALSE(is_known_after([](Zone& z) { z.items.points[1].z += 1e-12; }));
  CHECK_FALSE(is_known_after([](Zone& z) { z.items.tri_to_face[0] = 7; }));
  CHECK_FALSE(is_known_after([](Zone& z) { z.items.pieces.push_back({0, 1}); }));
  CHECK_FALSE(is_known_after([](Zone& z) { z.tolerances[0] = 0.2; }));
  CHECK_FALSE(is_known_after([](Zone& z) { z.sizes[0] = 2; }));
  CHECK_FALSE(is_known_after([](Zone& z) { z.is_locked[0] = 1; }));
  CHECK_FALSE(is_known_after([](Zone& z) { z.small = {6}; }));
}
