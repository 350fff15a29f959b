// The tables of the lattices: what the points and the core of a lattice count on.
#include "mesher/lattice/lattice_shape.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <tuple>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::lattice {
namespace {

constexpr LatticeKind kLattices[] = {LatticeKind::Bcc, LatticeKind::A15};

// In cubes.
Vec3 position(const LatticeShape& shape, const SiteStep& step) {
  const Site& site = shape.sites()[static_cast<std::size_t>(step.kind)];
  const double part = 1.0 / shape.parts();
  return {step.x + part * site.i, step.y + part * site.j, step.z + part * site.k};
}

std::array<Vec3, 4> corners(const LatticeShape& shape, const TetType& tet) {
  std::array<Vec3, 4> result;
  for (std::size_t i = 0; i < 4; ++i) result[i] = position(shape, tet.verts[i]);
  return result;
}

double volume_of(const std::array<Vec3, 4>& x) { return dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) / 6; }

Vec3 circumcentre(const std::array<Vec3, 4>& x) {
  const Vec3 a = x[1] - x[0], b = x[2] - x[0], c = x[3] - x[0];
  return x[0] + (1 / (12 * volume_of(x))) * (norm2(a) * cross(b, c) + norm2(b) * cross(c, a) + norm2(c) * cross(a, b));
}

std::set<std::tuple<int, int, int, int>> face_of(const TetType& tet, std::size_t face, const TetType::Behind& moved) {
  std::set<std::tuple<int, int, int, int>> verts;
  for (std::size_t i = 0; i < 4; ++i) {
    const SiteStep& v = tet.verts[i];
    if (i != face) verts.insert({v.kind, v.x + moved.x, v.y + moved.y, v.z + moved.z});
  }
  return verts;
}

}  // namespace

TEST_CASE("the tets of a lattice fill a cube and have empty circumspheres") {
  for (const LatticeKind kind : kLattices) {
    const LatticeShape& shape = LatticeShape::of(kind);
    CHECK(shape.sites().size() == (kind == LatticeKind::A15 ? 8 : 2));
    CHECK(shape.tets().size() == (kind == LatticeKind::A15 ? 46 : 12));
    double volume = 0;
    for (const TetType& tet : shape.tets()) {
      const std::array<Vec3, 4> x = corners(shape, tet);
      REQUIRE(volume_of(x) > 0);
      volume += volume_of(x);
      const Vec3 centre = circumcentre(x);
      const double radius = norm(x[0] - centre);
      int on_sphere = 0;
      for (int place = 0; place < 125 * static_cast<int>(shape.sites().size()); ++place) {
        const int cube = place % 125;
        const SiteStep step{place / 125, cube % 5 - 2, cube / 5 % 5 - 2, cube / 25 - 2};
        const double distance = norm(position(shape, step) - centre);
        REQUIRE(distance > radius * (1 - 1e-12));
        on_sphere += distance < radius * (1 + 1e-12);
      }
      REQUIRE(on_sphere == 4);
    }
    CHECK(volume == Approx(1).epsilon(1e-12));
  }
}

TEST_CASE("the mean ratios of the lattices' tets are those of the headers") {
  const auto ratios = [](LatticeKind kind) {
    std::vector<double> result;
    const LatticeShape& shape = LatticeShape::of(kind);
    for (const TetType& tet : shape.tets()) {
      const std::array<Vec3, 4> x = corners(shape, tet);
      double edges2 = 0;
      for (std::size_t i = 0; i < 4; ++i)
        for (std::size_t j = i + 1; j < 4; ++j) edges2 += norm2(x[i] - x[j]);
      result.push_back(12 * std::cbrt(9 * volume_of(x) * volume_of(x)) / edges2);
    }
    std::sort(result.begin(), result.end());
    return result;
  };
  const std::vector<double> bcc = ratios(LatticeKind::Bcc), a15 = ratios(LatticeKind::A15);
  CHECK(bcc.front() == Approx(0.952).margin(5e-4));
  CHECK(bcc.back() == Approx(0.952).margin(5e-4));
  CHECK(a15.front() == Approx(0.945).margin(5e-4));
  CHECK(a15.back() == Approx(0.991).margin(5e-4));
  double sum = 0;
  for (const double ratio : a15) sum += ratio;
  CHECK(sum / 46 == Approx(0.977).margin(5e-4));
}

TEST_CASE("behind each face of a type stands the tet that has the same face, and that one in front") {
  for (const LatticeKind kind : kLattices) {
    const std::vector<TetType>& tets = LatticeShape::of(kind).tets();
    for (std::size_t tet = 0; tet < tets.size(); ++tet) {
      for (std::size_t face = 0; face < 4; ++face) {
        const TetType::Behind& behind = tets[tet].behind[face];
        const TetType& other = tets[static_cast<std::size_t>(behind.type)];
        REQUIRE(face_of(tets[tet], face, {}) == face_of(other, static_cast<std::size_t>(behind.face), behind));
        const TetType::Behind& back = other.behind[static_cast<std::size_t>(behind.face)];
        REQUIRE(back.type == static_cast<int>(tet));
        REQUIRE(back.face == static_cast<int>(face));
        REQUIRE((back.x == -behind.x && back.y == -behind.y && back.z == -behind.z));
      }
    }
  }
}

TEST_CASE("what is around a site lies in the cubes around its cube") {
  const auto is_near = [](int x, int y, int z) { return std::max({std::abs(x), std::abs(y), std::abs(z)}) <= 1; };
  for (const LatticeKind kind : kLattices) {
    const LatticeShape& shape = LatticeShape::of(kind);
    for (const TetType& tet : shape.tets()) {
      for (const SiteStep& v : tet.verts) REQUIRE(is_near(v.x, v.y, v.z));
      for (const TetType::Behind& b : tet.behind) REQUIRE(is_near(b.x, b.y, b.z));
      REQUIRE(is_near(2 * tet.verts[0].x, 2 * tet.verts[0].y, 2 * tet.verts[0].z));
    }
    for (const Site& site : shape.sites()) {
      for (const Site& step : shape.around(shape.kind_of(site))) {
        const SiteStep to = shape.step_to(site, step);
        REQUIRE(is_near(to.x, to.y, to.z));
      }
    }
  }
}

TEST_CASE("distances from the surface suit the lattice's edges and circumspheres, and cubes its mean edge") {
  for (const LatticeKind kind : kLattices) {
    const LatticeShape& shape = LatticeShape::of(kind);
    double longest = 0, sum = 0, radius = 0;
    std::size_t edges = 0;
    for (const Site& site : shape.sites()) {
      for (const Site& step : shape.around(shape.kind_of(site))) {
        const double length = norm(Vec3{double(step.i), double(step.j), double(step.k)}) / shape.parts();
        longest = std::max(longest, length);
        sum += length, ++edges;
      }
    }
    for (const TetType& tet : shape.tets()) {
      const std::array<Vec3, 4> x = corners(shape, tet);
      radius = std::max(radius, norm(x[0] - circumcentre(x)));
    }
    CHECK(edges == 2 * (shape.tets().size() + shape.sites().size()));  // Euler, on the torus
    CHECK(2 * shape.from_surface() > longest * shape.graded_cube_per_size() + 1e-3);
    CHECK(shape.near_surface() > 2 * radius * shape.graded_cube_per_size() + 1e-3);
    CHECK(sum / double(edges) * shape.cube_per_size() ==
          Approx(kind == LatticeKind::A15 ? 0.988 : 0.979).epsilon(1e-3));
    CHECK(sum / double(edges) * shape.graded_cube_per_size() ==
          Approx(kind == LatticeKind::A15 ? 0.988 : 0.979).epsilon(1e-3));
  }
}

}  // namespace tetloom::lattice
