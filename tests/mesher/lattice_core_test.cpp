// The lattice core: its tets are Delaunay tets of all points, and the shell closes the rest.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "core/spatial/distances.hpp"
#include "mesher/lattice/lattice_core.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/shell.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/support/tet_fixtures.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::lattice {
namespace {

using namespace volume_tests;
using tets::FaceCode;
using tets::TetMesh;

constexpr LatticeKind kBoth[] = {LatticeKind::Bcc, LatticeKind::A15};

std::vector<std::pair<SizeField, LatticeKind>> sizes_and_lattices() {
  std::vector<std::pair<SizeField, LatticeKind>> both;
  for (const LatticeKind kind : kBoth) {
    both.emplace_back(SizeField::uniform(0.1), kind);
    both.emplace_back(growing_sizes(0.05, 0.2), kind);
  }
  return both;
}

struct Made {
  Surface surface;
  std::vector<LevelPoints> levels;
  TetMesh mesh;
  LatticeCore core;

  Made(Surface from, const SizeField& sizes, LatticeKind kind) : surface(std::move(from)) {
    const TaskRunner runner(2);
    const intersection::TriangleTree tree(surface.points, surface.tri_to_vert, runner);
    LatticeRequest request{&tree, surface.tri_to_sides, {}, &sizes, kind};
    for (const Vec3& x : surface.points) request.box.add(x);
    levels = make_lattice_points(request, runner);
    mesh.points = GrowingArray<Vec3>(std::span(surface.points));
    core = emit_core(mesh, levels, runner);
    mesh.to_region.resize(mesh.size(), tets::kNone);  // as a whole mesh has them
  }
};

Surface ball(int levels = 5) {
  return ball_surface(levels, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
}

using Tet = std::array<std::uint32_t, 4>;
using tet_tests::tets_of;

double volume_of(const TetMesh& mesh) {
  double volume = 0;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const Vec3& a = mesh.point_of(t, 0);
    volume += dot(cross(mesh.point_of(t, 1) - a, mesh.point_of(t, 2) - a), mesh.point_of(t, 3) - a) / 6;
  }
  return volume;
}

std::vector<std::uint32_t> ids_below(std::size_t count) {
  std::vector<std::uint32_t> ids(count);
  std::iota(ids.begin(), ids.end(), 0u);
  return ids;
}

}  // namespace

TEST_CASE("points of a uniform lattice keep their distance from the surface and lie inside") {
  const double size = 0.11;
  for (const LatticeKind kind : kBoth) {
    const Made made(ball(test::kSanitized ? 4 : 5), SizeField::uniform(size), kind);
    REQUIRE(made.levels.size() == 1);
    const LatticeShape& shape = LatticeShape::of(kind);
    const double cubes = 4.18 * 0.83 / std::pow(shape.cube_per_size() * size, 3);  // less a layer of .55 sizes
    CHECK(double(made.levels[0].sites.size()) == Approx(double(shape.sites().size()) * cubes).epsilon(0.05));
    for (std::size_t i = made.surface.points.size(); i < made.mesh.points.size(); ++i)
      REQUIRE(norm(made.mesh.points[i]) < 1 - 0.5 * size);
  }
}

TEST_CASE("sites are kept by their distance from the nearest triangle, and near ones are told") {
  const double size = 0.17;
  for (const LatticeKind kind : kBoth) {
    const Made made(ball(test::kSanitized ? 4 : 5), SizeField::uniform(size), kind);
    REQUIRE(made.levels.size() == 1);
    const LevelPoints& level = made.levels[0];
    const LatticeShape& shape = LatticeShape::of(kind);
    std::vector<Site> kept;
    std::vector<char> near;
    const auto first = level.lattice.first_site({-1, -1, -1}), end = level.lattice.first_site({1, 1, 1});
    level.lattice.for_each_between(first, end, [&](const Site& site) {
      const Vec3 x = level.lattice.point(site);
      if (norm(x) >= 1) return;
      double from_triangle = HUGE_VAL, from_point = HUGE_VAL;
      for (const auto& [a, b, c] : made.surface.tri_to_vert) {
        const std::vector<Vec3>& p = made.surface.points;
        from_triangle = std::min(from_triangle, distance_to_triangle(x, p[a], p[b], p[c]));
        from_point = std::min({from_point, distance(x, p[a]), distance(x, p[b]), distance(x, p[c])});
      }
      if (from_triangle < shape.from_surface() * size) return;
      const bool asks_triangles = shape.triangle_reach() == shape.near_surface();
      kept.push_back(site);
      near.push_back((asks_triangles ? from_triangle : from_point) < shape.near_surface() * size);
    });
    REQUIRE(kept.size() > 300);
    CHECK((std::set(level.sites.begin(), level.sites.end()) == std::set(kept.begin(), kept.end())));
    for (std::size_t i = 0; i < level.sites.size(); ++i) {
      const auto at = std::find(kept.begin(), kept.end(), level.sites[i]) - kept.begin();
      REQUIRE(bool(level.near_surface[i]) == bool(near[static_cast<std::size_t>(at)]));
    }
  }
}

TEST_CASE("every core tet is a Delaunay tet of all points, at one size and at many") {
  for (const auto& [sizes, kind] : sizes_and_lattices()) {
    Made made(ball(), sizes, kind);
    const std::size_t count = made.mesh.points.size();
    REQUIRE(made.mesh.size() > 1000);
    CHECK(tets::find_fault(made.mesh) == "");
    TetMesh all;
    all.points = made.mesh.points;
    make_delaunay(all, ids_below(count), TaskRunner(1));
    const std::set<Tet> core = tets_of(made.mesh), delaunay = tets_of(all);
    CHECK(core.size() == made.mesh.size());
    CHECK(std::includes(delaunay.begin(), delaunay.end(), core.begin(), core.end()));
  }
}

TEST_CASE("open faces are those without a neighbour, and shell vertices those that are not pure") {
  for (const LatticeKind kind : kBoth) {
    const Made made(ball(), SizeField::uniform(0.1), kind);
    std::vector<FaceCode> open;
    for (const FaceCode face : made.mesh.faces())
      if (!made.mesh.behind(face).valid()) open.push_back(face);
    CHECK((open == made.core.open_faces));
    std::set<std::uint32_t> shell(made.core.shell_verts.begin(), made.core.shell_verts.end());
    std::vector<std::size_t> tets_at(made.mesh.points.size(), 0);
    for (const std::uint32_t v : made.mesh.to_vert) ++tets_at[v];
    const std::vector<Site>& sites = made.levels[0].sites;
    const LatticeShape& shape = LatticeShape::of(kind);
    REQUIRE(shell.size() < sites.size());
    for (std::size_t i = 0; i < sites.size(); ++i) {
      const auto v = static_cast<std::uint32_t>(made.surface.points.size() + i);
      const std::size_t around = shape.around(shape.kind_of(sites[i])).size();
      if (shell.count(v) == 0) REQUIRE(tets_at[v] == 2 * around - 4);  // the faces of a polyhedron of triangles
    }
  }
}

TEST_CASE("core and shell fit face to face and fill the surface") {
  for (const auto& [sizes, kind] : sizes_and_lattices()) {
    Made made(ball(), sizes, kind);
    std::vector<std::uint32_t> verts = ids_below(made.surface.points.size());
    verts.insert(verts.end(), made.core.shell_verts.begin(), made.core.shell_verts.end());
    TetMesh shell;
    shell.points = std::move(made.mesh.points);
    make_delaunay(shell, verts, TaskRunner(1));
    CHECK(fix_core_faces(shell, made.mesh, made.core.open_faces) == 0);
    const std::set<std::array<std::uint32_t, 3>> triangles = [&] {
      std::set<std::array<std::uint32_t, 3>> sorted;
      for (const auto& t : made.surface.tri_to_vert) sorted.insert(tets::sorted(t).verts);
      return sorted;
    }();
    std::size_t found = 0;
    for (const FaceCode face : shell.faces()) {
      if (!triangles.count(tets::sorted(verts_of(shell, face)).verts)) continue;
      shell.to_fixed[face.tet()] = static_cast<std::uint8_t>(shell.to_fixed[face.tet()] | 1 << face.side());
      ++found;
    }
    REQUIRE(found == 2 * triangles.size());
    const tets::Surface surface{made.surface.tri_to_vert, made.surface.tri_to_sides};
    const tets::Fault fault = join_shell(made.mesh, std::move(shell), made.core.open_faces, surface, TaskRunner(1));
    CHECK(fault.message == "");
    CHECK(tets::find_fault(made.mesh) == "");
    double volume = 0;
    for (const auto& [a, b, c] : made.surface.tri_to_vert)
      volume += dot(cross(made.surface.points[a], made.surface.points[b]), made.surface.points[c]) / 6;
    CHECK(volume_of(made.mesh) == Approx(volume).epsilon(1e-12));
    for (const std::uint32_t region : made.mesh.to_region) REQUIRE(region == 0);
  }
}

}  // namespace tetloom::lattice
