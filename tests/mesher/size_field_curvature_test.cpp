// Curvature: the sizes that the rule gives, that they keep the volume, and that degenerate places stay harmless.
#include <catch2/catch.hpp>

#include <cmath>
#include <map>
#include <numbers>

#include "core/sizing/curvature_size.hpp"
#include "mesher/sizing/follow_face.hpp"
#include "tests/mesher/size_field_fixture.hpp"

namespace tetloom {
namespace {

using test_sizes::build;

constexpr double kPi = std::numbers::pi;

using Facets = std::vector<std::array<std::uint32_t, 3>>;

double enclosed_volume(const std::vector<Vec3>& points, const Facets& facets) {
  double volume = 0;
  for (const auto& [a, b, c] : facets) volume += dot(points[a], cross(points[b], points[c])) / 6;
  return volume;
}

/// A near-equilateral mesh of edge length ~h on a surface that closes after `around` in both directions: rows of
/// `columns` points, every other row shifted by half a step.
template <class Surface>
double volume_of_rows(std::size_t columns, std::size_t rows, const Surface& surface) {
  std::vector<Vec3> points;
  Facets facets;
  const auto index = [&](std::size_t i, std::size_t j) {
    return static_cast<std::uint32_t>(j % rows * columns + i % columns);
  };
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < columns; ++i)
      points.push_back(
          surface((static_cast<double>(i) + 0.5 * static_cast<double>(j % 2)) / static_cast<double>(columns),
                  static_cast<double>(j) / static_cast<double>(rows)));
  for (std::size_t j = 0; j < rows; ++j)
    for (std::size_t i = 0; i < columns; ++i) {
      const std::size_t shift = j % 2;
      facets.push_back({index(i, j), index(i + 1, j), index(i + shift, j + 1)});
      facets.push_back({index(i + 1, j), index(i + 1 + shift, j + 1), index(i + shift, j + 1)});
    }
  return enclosed_volume(points, facets);
}

/// A subdivided octahedron pushed onto the unit sphere: edges vary, so the loss is scaled to the mean square edge h².
double sphere_loss(double h) {
  constexpr std::size_t n = 24;
  std::vector<Vec3> points;
  Facets facets;
  std::map<std::array<long, 3>, std::uint32_t> known;
  const auto vertex = [&](const Vec3& p) {
    const std::array<long, 3> key{std::lround(p.x), std::lround(p.y), std::lround(p.z)};
    const auto [it, added] = known.try_emplace(key, static_cast<std::uint32_t>(points.size()));
    // Spreading the flat grid by angles makes the triangles more alike.
    const auto spread = [](double t) { return std::tan(t / n * kPi / 4); };
    if (added) points.push_back(normalized(Vec3{spread(p.x), spread(p.y), spread(p.z)}));
    return it->second;
  };
  for (int octant = 0; octant < 8; ++octant) {
    const Vec3 x{octant & 1 ? -1.0 : 1.0, 0, 0}, y{0, octant & 2 ? -1.0 : 1.0, 0}, z{0, 0, octant & 4 ? -1.0 : 1.0};
    const bool mirrored = x.x * y.y * z.z < 0;
    const auto at = [&](std::size_t i, std::size_t j) {
      return vertex(double(i) * x + double(j) * y + double(n - i - j) * z);
    };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
      facets.push_back(mirrored ? std::array{a, c, b} : std::array{a, b, c});
    };
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; i + j < n; ++j) {
        add(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < n) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
  // Loss is quadratic in the edges of each triangle; weigh each triangle's own loss to edges of length h.
  double loss = 0;
  for (const auto& [a, b, c] : facets) {
    const double flat = dot(points[a], cross(points[b], points[c])) / 6;
    const double edge2 =
        (norm2(points[b] - points[a]) + norm2(points[c] - points[b]) + norm2(points[a] - points[c])) / 3;
    const double angle =
        2 * std::atan2(6 * flat, 1 + dot(points[a], points[b]) + dot(points[b], points[c]) + dot(points[c], points[a]));
    loss += (angle / 3 - flat) * h * h / edge2;
  }
  return loss / (4 * kPi / 3);
}

}  // namespace

TEST_CASE("the curvature rule gives 6/NK on faces and never fewer than N edges per turn") {
  CHECK(size_from_curvature({2, 0}, 24) == Approx(0.125));
  CHECK(size_from_curvature({-2, 0}, 24) == Approx(0.125));
  CHECK(size_from_curvature({1, 1}, 24) == Approx(0.25 / std::sqrt(3.0)));
  CHECK(size_from_curvature({1, -1}, 24) == Approx(0.25 / std::sqrt(3.0)));
  CHECK(size_from_curvature({0, 0}, 24) == HUGE_VAL);
  CHECK(size_from_curvature({std::nan(""), 0}, 24) == HUGE_VAL);
  CHECK(size_from_curvature({HUGE_VAL, 0}, 24) == 0);
  CHECK(size_from_edge_curvature(0, 24) == HUGE_VAL);
  for (const double n : {3.0, 12.0, 24.0, 100.0}) {
    CHECK(size_from_curvature({1, 0}, n) <= 2 * kPi / n);
    CHECK(size_from_edge_curvature(1, n) <= 2 * kPi / n);
  }
}

TEST_CASE("meshes with the sizes of 24 edges per turn lose at most 0.9 % of their volume") {
  const double n = 24;
  SECTION("the wall of a cylinder") {
    const double h = size_from_curvature({1, 0}, n);
    const auto columns = static_cast<std::size_t>(std::lround(2 * kPi / h));
    const double height = h * std::sqrt(0.75);
    const auto at = [&](std::size_t column, double shift, double z) {
      const double angle = 2 * kPi * (static_cast<double>(column) + shift) / static_cast<double>(columns);
      return Vec3{std::cos(angle), std::sin(angle), z};
    };
    // The flux of (x, y, 0) / 2 through a triangle is the volume between the triangle and the axis.
    const auto flux = [](const Vec3& p, const Vec3& q, const Vec3& r) {
      const Vec3 sum = p + q + r;
      return dot(Vec3{sum.x, sum.y, 0}, cross(q - p, r - p)) / 12;
    };
    double volume = 0;  // of one row
    for (std::size_t i = 0; i < columns; ++i) {
      const Vec3 a = at(i, 0, 0), b = at(i + 1, 0, 0), c = at(i, 0.5, height), d = at(i + 1, 0.5, height);
      volume += flux(a, b, c) + flux(b, d, c);
    }
    const double loss = 1 - volume / (kPi * height);
    CHECK(loss == Approx(h * h / 8).epsilon(0.05));
    CHECK(loss <= 0.009);
  }
  SECTION("the rim of a disc") {
    const double edges = std::floor(2 * kPi / size_from_edge_curvature(1, n));
    CHECK(1 - edges * std::sin(2 * kPi / edges) / (2 * kPi) <= 0.009);
  }
  SECTION("a sphere") { CHECK(sphere_loss(size_from_curvature({1, 1}, n)) <= 0.009); }
  SECTION("a torus, meshed with the coarsest of its sizes") {
    const double major = 3, minor = 1;
    const double h = size_from_curvature({1 / minor, 0}, n);
    const auto rows = static_cast<std::size_t>(2 * std::lround(kPi * minor / (h * std::sqrt(0.75))));
    const auto columns = static_cast<std::size_t>(std::lround(2 * kPi * (major + minor) / h));
    const double volume = volume_of_rows(columns, rows, [&](double u, double v) {
      const double a = 2 * kPi * u, b = 2 * kPi * v, r = major + minor * std::cos(b);
      return Vec3{r * std::cos(a), r * std::sin(a), minor * std::sin(b)};
    });
    CHECK(1 - volume / (2 * kPi * major * kPi * minor * minor) <= 0.009);
  }
}

TEST_CASE("spheres, cylinders and tori get the sizes of the rule within 5 %") {
  const double n = 24;
  SECTION("sphere") {
    const auto sphere = test_models::make_sphere({1, 2, 3}, 2);
    const SizeField field = build(*sphere, {.size = 2, .curvature = n});
    const auto face = sphere->face_geometry(ModelFaceId(std::size_t{0}));
    for (double u = 0; u < 6.2; u += 0.1)
      for (double v = -1.57; v < 1.57; v += 0.1)
        REQUIRE(field.size_at(face->evaluate({u, v})) == Approx(size_from_curvature({0.5, 0.5}, n)).epsilon(0.05));
  }
  SECTION("cylinder, in the middle and at the rim") {
    const auto cylinder = test_models::make_cylinder(1, 6);
    const SizeField field = build(*cylinder, {.size = 1, .curvature = n});
    for (double u = 0; u < 6.2; u += 0.1) {
      REQUIRE(field.size_at({std::cos(u), std::sin(u), 3}) == Approx(size_from_curvature({1, 0}, n)).epsilon(0.05));
      REQUIRE(field.size_at({std::cos(u), std::sin(u), 0}) == Approx(size_from_edge_curvature(1, n)).epsilon(0.05));
    }
    CHECK(field.size_at({0, 0, 3}) == Approx(0.25 + 0.3 * (1 - 0.15)).epsilon(0.05));
  }
  SECTION("torus") {
    const auto torus = test_models::make_torus(3, 1);
    const SizeField field = build(*torus, {.size = 2, .curvature = n});
    const auto face = torus->face_geometry(ModelFaceId(std::size_t{0}));
    for (double v = 0; v < 6.2; v += 0.1) {
      const double expected = size_from_curvature(face->curvature({1, v}), n);
      const double size = field.size_at(face->evaluate({1, v}));
      REQUIRE(size <= 1.08 * expected);
      REQUIRE(size >= 0.8 * expected);  // pieces with different sizes take their smallest
    }
  }
}

TEST_CASE("facets that lie across a face are cut until they follow it") {
  const auto torus = test_models::make_torus(3, 1);
  const ModelFaceId id(std::size_t{0});
  const auto face = torus->face_geometry(id);
  // The square of the parameter plane, with points on its rim alone: facets from one side to the other have no area.
  Tessellation facets;
  constexpr std::uint32_t kSide = 32;
  const double step = 2 * kPi / kSide;
  for (std::uint32_t i = 0; i < 4 * kSide; ++i) {
    const double along = step * (i % kSide);
    const Vec2 sides[] = {{along, 0}, {2 * kPi, along}, {2 * kPi - along, 2 * kPi}, {0, 2 * kPi - along}};
    facets.uv.push_back(sides[i / kSide]);
    facets.points.push_back(face->evaluate(facets.uv.back()));
  }
  const auto right = [](std::uint32_t j) { return kSide + j; };
  const auto left = [](std::uint32_t j) { return (4 * kSide - j) % (4 * kSide); };
  for (std::uint32_t i = 0; i < kSide; ++i) facets.tri_to_vert.push_back({i, i + 1, left(1)});
  for (std::uint32_t j = 1; j + 1 < kSide; ++j) {
    facets.tri_to_vert.push_back({left(j), right(j), right(j + 1)});
    facets.tri_to_vert.push_back({left(j), right(j + 1), left(j + 1)});
  }
  facets.tri_to_vert.push_back({right(0), right(1), left(1)});
  for (std::uint32_t i = 2 * kSide; i < 3 * kSide; ++i) facets.tri_to_vert.push_back({i, i + 1, left(kSide - 1)});
  facets.tri_to_vert.push_back({left(kSide - 1), right(kSide - 1), right(kSide)});
  facets.classification.assign(facets.points.size(), ModelVertexId(std::size_t{0}));
  facets.edge_parameter.assign(facets.points.size(), 0);
  follow_face(*face, id, 0.02, facets);
  double area = 0, across = 0;
  for (const auto& [a, b, c] : facets.tri_to_vert) {
    const Vec3 normal = 0.5 * cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a]);
    area += norm(normal);
    const Vec2 middle = (1.0 / 3) * (facets.uv[a] + facets.uv[b] + facets.uv[c]);
    across = std::max(across,
                      distance(face->evaluate(middle), (facets.points[a] + facets.points[b] + facets.points[c]) / 3));
    CHECK(cross(facets.uv[b] - facets.uv[a], facets.uv[c] - facets.uv[a]) > 0);
  }
  CHECK(area == Approx(4 * kPi * kPi * 3).epsilon(0.2));  // thin facets along the rim are askew
  CHECK(across < 0.03);
  REQUIRE(facets.uv.size() == facets.points.size());
  REQUIRE(facets.classification.size() == facets.points.size());
  REQUIRE(facets.edge_parameter.size() == facets.points.size());
  CHECK(facets.classification.back() == ModelEntity(id));
  const std::size_t count = facets.tri_to_vert.size();
  follow_face(*face, id, 0.02, facets);
  CHECK(facets.tri_to_vert.size() == count);
}

TEST_CASE("curvature is limited by the floor, which is a tenth of the size unless given") {
  const auto cone = test_models::make_cone(1, 2);
  const SizeField field = build(*cone, {.size = 0.5, .curvature = 24});
  CHECK(field.smallest() == Approx(0.05).epsilon(1e-6));
  CHECK(field.size_at({0, 0, 2}) == Approx(0.05).epsilon(0.1));
  CHECK(build(*cone, {.size = 0.5, .min_size = 0.02, .curvature = 24}).smallest() == Approx(0.02).epsilon(1e-6));
  // Wires keep their shape: their floor is a twentieth of the usual one, unless one is given.
  const auto tiny = test_models::make_cylinder(1e-4, 1);
  CHECK(build(*tiny, {.size = 0.1, .curvature = 24}).smallest() == Approx(0.0005).epsilon(1e-6));
  CHECK(build(*tiny, {.size = 0.1, .min_size = 0.01, .curvature = 24}).smallest() == Approx(0.01).epsilon(1e-6));
}

TEST_CASE("the poles of a sphere get no smaller size than its equator") {
  const auto sphere = test_models::make_sphere({0, 0, 0}, 1);
  const SizeField field = build(*sphere, {.size = 1, .min_size = 1e-3, .curvature = 24});
  CHECK(field.smallest() == Approx(size_from_curvature({1, 1}, 24)).epsilon(0.01));
}

TEST_CASE("curved edges of a flat sheet are resolved") {
  const auto annulus = test_models::make_annulus(0.2, 2);
  const SizeField field = build(*annulus, {.size = 0.5, .min_size = 1e-3, .curvature = 24});
  CHECK(field.size_at({0.2, 0, 0}) == Approx(size_from_edge_curvature(5, 24)).epsilon(0.05));
  CHECK(field.size_at({0, 2, 0}) == Approx(size_from_edge_curvature(0.5, 24)).epsilon(0.05));
}

}  // namespace tetloom
