#pragma once
// The Delaunay kernel beside that of somebody else: point sets, and what the two tetrahedralisations must have in
// common.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "core/predicates/predicates.hpp"
#include "mesher/tets/delaunay.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets::oracle_tests {

using Tet = std::array<std::uint32_t, 4>;

/// Tets over points, the four outer ones of the kernel among them, so that both have the same convex hull. Points
/// that lie on others are named by those.
struct Tetrahedralisation {
  std::vector<Vec3> points;
  std::vector<Tet> tets;  ///< of positive volume
};

struct PointSet {
  std::string name;
  std::vector<Vec3> points;
  bool in_general_position = false;
};

inline std::vector<Vec3> random_points(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::vector<Vec3> points;
  for (std::size_t i = 0; i < count; ++i)
    points.push_back({coordinate(random), coordinate(random), coordinate(random)});
  return points;
}

inline std::vector<Vec3> grid_points(int n, double cell_center) {
  std::vector<Vec3> points;
  for (int i = 0; i < n * n * n; ++i) {
    const Vec3 p{double(i % n), double(i / n % n), double(i / n / n)};
    points.push_back(p);
    if (cell_center > 0) points.push_back(p + Vec3{cell_center, cell_center, cell_center});
  }
  return points;
}

/// Points with integer coordinates on one sphere about the origin: exactly cospherical.
inline std::vector<Vec3> on_integer_sphere(int squared_radius) {
  std::vector<Vec3> points;
  const int r = static_cast<int>(std::sqrt(squared_radius));
  for (int x = -r; x <= r; ++x)
    for (int y = -r; y <= r; ++y)
      for (int z = -r; z <= r; ++z)
        if (x * x + y * y + z * z == squared_radius) points.push_back({double(x), double(y), double(z)});
  return points;
}

inline std::vector<PointSet> point_sets() {
  std::vector<PointSet> sets;
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    sets.push_back({"random, seed " + std::to_string(seed), random_points(300 * seed * seed, seed), true});
    std::vector<Vec3> clusters = random_points(1000, 100 + seed), balls = random_points(1000, 200 + seed);
    for (std::size_t i = 0; i < 500; ++i) clusters[i] = Vec3{0.3, 0.6, 0.5} + 1e-7 * clusters[i];
    for (std::size_t i = 0; i < 700; ++i) balls[i] = normalized(balls[i] - Vec3{0.5, 0.5, 0.5});
    sets.push_back({"clusters, seed " + std::to_string(seed), clusters, true});
    sets.push_back({"points of a ball and near its surface, seed " + std::to_string(seed), balls, true});
    std::vector<Vec3> coarse = random_points(1500, 300 + seed), twice = random_points(400, 400 + seed);
    for (Vec3& p : coarse) p = {std::floor(12 * p.x), std::floor(12 * p.y), std::floor(12 * p.z)};
    twice.insert(twice.end(), twice.begin(), twice.begin() + 150);
    sets.push_back({"grid points at random, many twice, seed " + std::to_string(seed), coarse});
    sets.push_back({"points given twice, seed " + std::to_string(seed), twice, true});
  }
  std::vector<Vec3> plane = random_points(500, 5), line = random_points(100, 6), shelves = random_points(800, 7);
  for (Vec3& p : plane) p.z = 0.25;
  for (Vec3& p : line) p = {p.x, 0, 0};
  for (Vec3& p : shelves) p.z = std::floor(4 * p.z);
  sets.push_back({"cubic lattice", grid_points(8, 0)});
  sets.push_back({"body-centred lattice", grid_points(7, 0.5)});
  sets.push_back({"sphere", on_integer_sphere(1001)});
  sets.push_back({"plane", plane, true});
  sets.push_back({"line", line, true});
  sets.push_back({"planes", shelves, true});
  return sets;
}

/// Each tet by the first of the points in each place, turned to positive volume. Fails on tets without any.
inline Tetrahedralisation made_sound(const std::vector<Vec3>& points, std::vector<Tet> tets) {
  std::map<std::array<double, 3>, std::uint32_t> first;
  for (std::uint32_t v = 0; v < points.size(); ++v) first.try_emplace({points[v].x, points[v].y, points[v].z}, v);
  std::size_t flat = 0;
  for (Tet& t : tets) {
    for (std::uint32_t& v : t) v = first.at({points[v].x, points[v].y, points[v].z});
    const int side = orient3d(points[t[0]], points[t[1]], points[t[2]], points[t[3]]);
    if (side < 0) std::swap(t[2], t[3]);
    flat += side == 0;
  }
  CHECK(flat == 0);
  return {points, std::move(tets)};
}

inline Tetrahedralisation our_own(const std::vector<Vec3>& points) {
  TetMesh mesh;
  mesh.points = GrowingArray<Vec3>(std::span(points));
  std::vector<std::uint32_t> ids(points.size());
  std::iota(ids.begin(), ids.end(), 0u);
  make_delaunay(mesh, ids, TaskRunner(1));
  std::vector<Tet> tets;
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const std::uint32_t* v = mesh.to_vert.data() + std::size_t{t} * 4;
    tets.push_back({v[0], v[1], v[2], v[3]});
  }
  return made_sound({mesh.points.begin(), mesh.points.end()}, std::move(tets));
}

inline double volume_of(const Tetrahedralisation& made) {
  double sum = 0;
  for (const Tet& t : made.tets) {
    const Vec3& a = made.points[t[0]];
    sum += dot(cross(made.points[t[1]] - a, made.points[t[2]] - a), made.points[t[3]] - a) / 6;
  }
  return sum;
}

/// Calls visit(tet, apex of the tet behind) for each face between two tets, from one side; returns the faces of one.
template <class Visit>
std::size_t for_each_face(const Tetrahedralisation& made, const Visit& visit) {
  std::map<std::array<std::uint32_t, 3>, std::pair<std::size_t, std::uint32_t>> open;
  for (std::size_t i = 0; i < made.tets.size(); ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<std::uint32_t, 3> face;
      for (std::size_t j = 0; j < 3; ++j) face[j] = made.tets[i][(k + 1 + j) % 4];
      std::sort(face.begin(), face.end());
      const auto [entry, is_new] = open.try_emplace(face, i, made.tets[i][k]);
      if (is_new) continue;
      visit(made.tets[entry->second.first], made.tets[i][k]);
      open.erase(entry);
    }
  }
  return open.size();
}

/// The sides of spheres on which the tets behind faces have their apices, by our exact predicate: 1 inside, 0 on it.
inline std::array<std::size_t, 2> count_conflicts(const Tetrahedralisation& made) {
  std::array<std::size_t, 2> on_and_in{};
  const auto& p = made.points;
  const std::size_t hull = for_each_face(made, [&](const Tet& t, std::uint32_t apex) {
    const int side = insphere(p[t[0]], p[t[1]], p[t[2]], p[t[3]], p[apex]);
    if (side >= 0) ++on_and_in[static_cast<std::size_t>(side)];
  });
  CHECK(hull == 4);  // those of the outer points
  return on_and_in;
}

inline std::vector<Tet> sorted_tets(const Tetrahedralisation& made) {
  std::vector<Tet> tets = made.tets;
  for (Tet& t : tets) std::sort(t.begin(), t.end());
  std::sort(tets.begin(), tets.end());
  return tets;
}

/// By the lemma of Delaunay, spheres that are empty across all faces are empty; and when no apex lies on one, there is
/// but one Delaunay tetrahedralisation.
inline void check_agreement(const PointSet& set, const Tetrahedralisation& ours, const Tetrahedralisation& theirs) {
  const auto in_ours = count_conflicts(ours), in_theirs = count_conflicts(theirs);
  CHECK(in_ours[1] == 0);
  CHECK(in_theirs[1] == 0);
  CHECK(volume_of(theirs) == Approx(volume_of(ours)).epsilon(1e-10));
  const bool is_unique = in_ours[0] == 0;
  CHECK(is_unique == set.in_general_position);
  CHECK(is_unique == (in_theirs[0] == 0));
  if (is_unique) CHECK((sorted_tets(ours) == sorted_tets(theirs)));
}

}  // namespace tetloom::tets::oracle_tests
