// Tets that cannot be valid with their mid nodes on the model give way to others.
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "core/mesh/curved_tet.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "mesher/second_order/mend_tets.hpp"
#include "mesher/second_order/straighten.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;
using namespace tetloom::second_order;

namespace {

constexpr double kLeast = 0.1;

/// Caps of unit spheres, four points of the sphere and one inside for each: a tet has two faces on the sphere, two
/// close what lies below it.
struct Caps {
  Mesh mesh;  ///< mid nodes of the faces on the spheres lie on them
  std::vector<CurvedNode> curved;

  explicit Caps(std::uint32_t count = 1) {
    constexpr double kHalf = 0.3, kAcross = 0.4;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vec3 center = center_of(i);
      const std::uint32_t a = 5 * i, b = a + 1, c = a + 2, d = a + 3, inner = a + 4;
      for (const Vec3& x : {Vec3{-kHalf, 0, 1}, Vec3{kHalf, 0, 1}, Vec3{0, -kAcross, 0.9}, Vec3{0, kAcross, 0.9}})
        mesh.points.push_back(center + normalized(x));
      mesh.points.push_back(center + Vec3{0, 0, 0.5});
      mesh.tet_to_vert.insert(mesh.tet_to_vert.end(), {{a, c, b, d}, {a, d, c, inner}, {b, c, d, inner}});
      mesh.tri_to_vert.insert(mesh.tri_to_vert.end(),
                              {{a, c, b}, {a, b, d}, {a, d, inner}, {d, b, inner}, {b, c, inner}, {c, a, inner}});
      mesh.tri_to_entity.insert(mesh.tri_to_entity.end(), {0, 0, 1, 1, 1, 1});
    }
    for (auto& tet : mesh.tet_to_vert)
      if (signed_volume(tet) < 0) std::swap(tet[2], tet[3]);
    mesh.tet_to_entity.assign(mesh.tet_to_vert.size(), 0);
    mesh.point_to_entity.assign(mesh.points.size(), {2, 0});
    mesh = test::with_mid_nodes(mesh);
    for (std::uint32_t m = 0; m < mesh.mid_to_vert.size(); ++m) {
      const std::size_t p = vertex_count(mesh) + m;
      const auto [low, high] = mesh.mid_to_vert[m];
      if (mesh.point_to_entity[p].dim != 2 || high % 5 == 4) continue;
      const Vec3 center = center_of(low / 5);
      mesh.points[p] = center + normalized(mesh.points[p] - center);
      curved.push_back({m, mesh.points[p]});
    }
  }

 private:
  static Vec3 center_of(std::uint32_t i) { return {3.0 * i, 0, 0}; }
  double signed_volume(const std::array<std::uint32_t, 4>& tet) const {
    const Vec3& origin = mesh.points[tet[0]];
    return dot(cross(mesh.points[tet[1]] - origin, mesh.points[tet[2]] - origin), mesh.points[tet[3]] - origin);
  }
};

double least_of(const Mesh& mesh) {
  const MidNodes mids(mesh);
  double least = 1;
  for (std::size_t t = 0; t < mesh.tet_to_vert.size(); ++t)
    least = std::min(least, least_jacobian(tet_jacobian(nodes_of_tet(mesh, mids, t)), 1));
  return least;
}

double volume_of(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c, d] : mesh.tet_to_vert) {
    const Vec3& origin = mesh.points[a];
    sum += dot(cross(mesh.points[b] - origin, mesh.points[c] - origin), mesh.points[d] - origin) / 6;
  }
  return sum;
}

// Straightens the mesh where there are none.
std::vector<std::uint32_t> find_hopeless(std::span<const CurvedNode> curved, Mesh& mesh, const TaskRunner& runner) {
  std::vector<std::uint32_t> hopeless;
  const auto done = straighten_unless_hopeless(curved, kLeast, mesh, hopeless, runner);
  CHECK(done.has_value() == hopeless.empty());
  return hopeless;
}

}  // namespace

TEST_CASE("a tet with two faces on one smooth surface gives way to tets with one, and no mid node leaves it") {
  Caps cap;
  Mesh& mesh = cap.mesh;
  REQUIRE(least_of(mesh) < 0.05);
  const double volume = volume_of(mesh);
  const TaskRunner runner(2);
  const auto hopeless = find_hopeless(cap.curved, mesh, runner);
  REQUIRE(hopeless == std::vector<std::uint32_t>{0});
  CHECK(mend_tets(hopeless, kLeast, cap.curved, mesh, runner) == 1);
  CHECK(volume_of(mesh) == Approx(volume));
  CHECK_FALSE(find_mid_node_fault(mesh));
  CHECK(mesh.tet_to_vert.size() == 2);
  CHECK(mesh.tet_to_entity.size() == 2);
  CHECK(vertex_count(mesh) == 5);
  CHECK(least_of(mesh) >= kLeast);
  CHECK(find_hopeless(cap.curved, mesh, runner).empty());
  CHECK(cap.curved.size() == 5);
  for (const CurvedNode& node : cap.curved) {
    CHECK(mesh.points[vertex_count(mesh) + node.mid] == node.place);
    CHECK(norm(node.place) == Approx(1));
  }
}

TEST_CASE("tets for which there are no others stay, and the mesh with them") {
  // A sheet below the tet: its faces stay, and between them there is room for flat tets alone.
  Caps cap;
  for (const std::array<std::uint32_t, 3>& tri : {std::array{0u, 2u, 3u}, std::array{1u, 3u, 2u}}) {
    cap.mesh.tri_to_vert.push_back(tri);
    cap.mesh.tri_to_entity.push_back(2);
  }
  const Mesh before = cap.mesh;
  CHECK(mend_tets(std::array{0u}, kLeast, cap.curved, cap.mesh, TaskRunner(1)) == 0);
  CHECK(mesh_digest(cap.mesh) == mesh_digest(before));
}

TEST_CASE("what becomes of tets does not depend on the number of threads") {
  std::string digest;
  for (const int threads : {1, 2, 5}) {
    Caps caps(7);
    const TaskRunner runner(threads);
    const auto hopeless = find_hopeless(caps.curved, caps.mesh, runner);
    CHECK(mend_tets(hopeless, kLeast, caps.curved, caps.mesh, runner) == 7);
    CHECK(caps.mesh.tet_to_vert.size() == 14);
    CHECK_FALSE(find_mid_node_fault(caps.mesh));
    if (digest.empty()) digest = mesh_digest(caps.mesh);
    CHECK(mesh_digest(caps.mesh) == digest);
  }
}
