// Bad surfaces and bad numbers, filled without a worker: each ends with an error that has a code, a sentence and a
// place, and the input is as it was.
#include <algorithm>
#include <cstring>
#include <limits>

#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/error_of.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;
using tetloom::test::error_of;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool same_bits(const Surface& a, const Surface& b) {
  const auto same_point = [](const Vec3& p, const Vec3& q) { return std::memcmp(&p, &q, sizeof p) == 0; };
  return std::equal(a.points.begin(), a.points.end(), b.points.begin(), b.points.end(), same_point) &&
         std::equal(a.tri_to_sides.begin(), a.tri_to_sides.end(), b.tri_to_sides.begin(), b.tri_to_sides.end(),
                    [](const FaceSides& s, const FaceSides& t) { return s.front == t.front && s.back == t.back; }) &&
         a.tri_to_vert == b.tri_to_vert && a.tri_to_face == b.tri_to_face;
}

VolumeMesh fill_alone(const Surface& surface, double size = 0.4) {
  const Surface before = surface;
  const SizeField sizes = SizeField::uniform(size);
  const VolumeMesh mesh = fill_volume(surface.input(sizes), {}, TaskRunner(2));
  CHECK(same_bits(surface, before));
  CHECK(mesh.figures.worker_complexes == 0);
  return mesh;
}

double distance_to(const Box3& box, const Vec3& p) {
  Vec3 outside;
  for (int axis = 0; axis < 3; ++axis) outside[axis] = std::max({box.lo[axis] - p[axis], p[axis] - box.hi[axis], 0.0});
  return norm(outside);
}

Box3 box_of(const Surface& surface) {
  Box3 box;
  for (const Vec3& p : surface.points) box.add(p);
  return box;
}

// The first error with these words of a surface that cannot be filled, after a look at what every such error has.
Diagnostic refusal_of(const Surface& surface, const std::string& words = "") {
  const VolumeMesh mesh = fill_alone(surface);
  CHECK(mesh.tet_to_vert.empty());
  REQUIRE(!mesh.errors.empty());
  for (const Diagnostic& error : mesh.errors) {
    CHECK(!error.message.empty());
    CHECK(!error.entities.empty());
    REQUIRE(error.point);
    CHECK(distance_to(box_of(surface), *error.point) < 1e-9);
    CHECK(!error.elements.empty());
    for (const std::uint64_t triangle : error.elements) CHECK(triangle < surface.tri_to_vert.size());
  }
  const auto told = std::find_if(mesh.errors.begin(), mesh.errors.end(), [&](const Diagnostic& error) {
    return error.message.find(words) != std::string::npos;
  });
  REQUIRE(told != mesh.errors.end());
  return *told;
}

void erase_triangle(Surface& surface, std::size_t triangle) {
  const auto erase = [&](auto& list) { list.erase(list.begin() + static_cast<std::ptrdiff_t>(triangle)); };
  erase(surface.tri_to_vert), erase(surface.tri_to_sides), erase(surface.tri_to_face);
}

Surface moved(Surface surface, const Vec3& by) {
  for (Vec3& p : surface.points) p += by;
  return surface;
}

bool has(const Diagnostic& error, std::uint64_t triangle) {
  return std::find(error.elements.begin(), error.elements.end(), triangle) != error.elements.end();
}

bool says(const Diagnostic& error, const std::string& words) { return error.message.find(words) != std::string::npos; }

}  // namespace

TEST_CASE("two boxes of one region that cross are refused where they do") {
  for (const Vec3& by : {Vec3{0.3, 0.4, 0.45}, Vec3{0.5, 0, 0}, Vec3{0.5, 0.5, 0}}) {
    Surface boxes = cube_surface(2);
    boxes.append(moved(cube_surface(3), by));
    CHECK(refusal_of(boxes).code == ErrorCode::SelfIntersection);
  }
}

TEST_CASE("a vertex pushed through the opposite wall is refused with the triangles there") {
  Surface cube = cube_surface(4);
  const auto at = std::find(cube.points.begin(), cube.points.end(), Vec3{0.5, 0.5, 1});
  REQUIRE(at != cube.points.end());
  *at = {0.55, 0.45, -0.3};
  const Diagnostic error = refusal_of(cube);
  CHECK(error.code == ErrorCode::SelfIntersection);
  CHECK(error.point->z == Approx(0).margin(1e-12));
}

TEST_CASE("a vertex that only touches the opposite wall is refused with its place") {
  Surface cube = cube_surface(4);
  const auto at = std::find(cube.points.begin(), cube.points.end(), Vec3{0.5, 0.5, 1});
  for (const Vec3& to : {Vec3{0.55, 0.45, 0}, Vec3{0.55, 0.5, 0}}) {  // inside of a triangle, on an edge
    *at = to;
    const Diagnostic error = refusal_of(cube);
    CHECK(error.code == ErrorCode::SelfIntersection);
    CHECK(*error.point == to);
  }
}

TEST_CASE("a triangle folded over its neighbour is refused") {
  Surface cube = cube_surface(4);
  const auto at = std::find(cube.points.begin(), cube.points.end(), Vec3{0.5, 0.5, 1});
  *at = {0.9, 0.9, 1};  // beyond the far edges of the triangles around it, in their plane
  const Diagnostic error = refusal_of(cube);
  CHECK(error.code == ErrorCode::SelfIntersection);
  CHECK(error.point->z == 1);
}

TEST_CASE("a surface that lies on itself is refused") {
  Surface twice = ball(1);
  twice.append(ball(1));
  for (std::size_t i = 0; i < twice.tri_to_vert.size(); ++i) CHECK(twice.tri_to_sides[i].back.valid());
  CHECK(refusal_of(twice).code == ErrorCode::SelfIntersection);
  Surface repeated = ball(1);
  repeated.add(repeated.tri_to_vert[3], kOutside, 0, 0);
  repeated.add({repeated.tri_to_vert[3][0], repeated.tri_to_vert[3][2], repeated.tri_to_vert[3][1]}, kOutside, 0, 0);
  CHECK(has(refusal_of(repeated), 3));
}

TEST_CASE("a missing triangle and a missing face are open shells told at their rims") {
  Surface holed = ball();
  const auto hole = holed.tri_to_vert[17];
  erase_triangle(holed, 17);
  const Diagnostic one = refusal_of(holed);
  CHECK(one.code == ErrorCode::OpenShell);
  double nearest = kInfinity;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 middle = 0.5 * (holed.points[hole[i]] + holed.points[hole[(i + 1) % 3]]);
    nearest = std::min(nearest, distance(middle, *one.point));
  }
  CHECK(nearest < 1e-12);
  Surface lidless = cube_surface(3);
  for (std::size_t t = lidless.tri_to_vert.size(); t-- > 0;) {
    const auto& v = lidless.tri_to_vert[t];
    if (std::all_of(v.begin(), v.end(), [&](std::uint32_t x) { return lidless.points[x].z == 1; }))
      erase_triangle(lidless, t);
  }
  const Diagnostic lid = refusal_of(lidless);
  CHECK(lid.code == ErrorCode::OpenShell);
  CHECK(lid.point->z == 1);
}

TEST_CASE("a surface turned inside out is refused with a triangle of it") {
  for (const Surface& shape : {cube_surface(2), ball(3)}) {
    Surface inverted = shape;
    for (FaceSides& sides : inverted.tri_to_sides) std::swap(sides.front, sides.back);
    const Diagnostic error = refusal_of(inverted);
    CHECK(error.code == ErrorCode::VolumeFailed);
    CHECK(says(error, "inside out"));
  }
}

TEST_CASE("one triangle turned the other way is an open shell around it") {
  Surface surface = ball();
  std::swap(surface.tri_to_sides[5].front, surface.tri_to_sides[5].back);
  const Diagnostic error = refusal_of(surface);
  CHECK(error.code == ErrorCode::OpenShell);
  CHECK(has(error, 5));
}

TEST_CASE("an edge of three triangles whose sides do not fit is an open shell at that edge") {
  Surface surface = ball();
  const auto [a, b, c] = surface.tri_to_vert[8];
  surface.points.push_back(1.5 * surface.points[a]);
  surface.add({a, b, static_cast<std::uint32_t>(surface.points.size() - 1)}, kOutside, 0, 4);
  const Diagnostic error = refusal_of(surface);
  CHECK(error.code == ErrorCode::OpenShell);
  CHECK(has(error, surface.tri_to_vert.size() - 1));
}

TEST_CASE("boxes that share one edge or one vertex are filled") {
  const auto diagonal = [](int i, int j, int) { return i == j ? 0u : kOutside; };
  const auto corner = [](int i, int j, int k) { return i == j && j == k ? 0u : kOutside; };
  for (const int n : {1, 3}) {
    const Surface by_edge = voxel_surface({2, 2, 1}, n, diagonal), by_vertex = voxel_surface({2, 2, 2}, n, corner);
    for (const Surface& pair : {by_edge, by_vertex}) {
      const VolumeMesh mesh = fill_alone(pair);
      CHECK(mesh.errors.empty());
      CHECK(check_filling(pair, mesh).at(0) == Approx(2));
    }
  }
}

TEST_CASE("two points in one place are told with the place") {
  Surface slit = ball();
  const std::uint32_t doubled = slit.tri_to_vert[20][0];
  slit.points.push_back(slit.points[doubled]);
  // All triangles there but one keep the first of the two: the surface closes in space, not by ids.
  slit.tri_to_vert[20][0] = static_cast<std::uint32_t>(slit.points.size() - 1);
  const Diagnostic open = refusal_of(slit);
  CHECK(open.code == ErrorCode::OpenShell);
  CHECK(has(open, 20));
  // Two shells that meet in one place, with a point each.
  Surface shells = cube_surface(2);
  shells.append(moved(cube_surface(2), {1, 1, 1}));
  const Diagnostic touching = refusal_of(shells);
  CHECK(touching.code == ErrorCode::SelfIntersection);
  CHECK(says(touching, "coincide"));
  CHECK(*touching.point == Vec3(1, 1, 1));
}

TEST_CASE("triangles without area are told with their place") {
  Surface cube = cube_surface(2);
  // A sliver between two triangles at a common edge: a, the middle of the edge, b are on one line.
  Surface split = cube;
  const auto [a, b, c] = cube.tri_to_vert[0];
  const auto middle = static_cast<std::uint32_t>(split.points.size());
  split.points.push_back(0.5 * (split.points[a] + split.points[b]));
  const FaceSides sides = split.tri_to_sides[0];
  split.tri_to_vert[0] = {a, middle, c};
  for (const auto& triangle : {std::array{middle, b, c}, std::array{a, b, middle}}) {
    split.tri_to_vert.push_back(triangle), split.tri_to_sides.push_back(sides), split.tri_to_face.push_back(0);
  }
  const Diagnostic collinear = refusal_of(split, "without area");
  CHECK(has(collinear, split.tri_to_vert.size() - 1));
  Surface repeated = cube;
  repeated.add({a, a, b}, kOutside, 0, 7);
  const Diagnostic twice = refusal_of(repeated, "without area");
  CHECK(twice.entities.front().entity == ModelEntity(2, 7));
  CHECK(has(twice, repeated.tri_to_vert.size() - 1));
  Surface flat = cube;
  for (Vec3& p : flat.points) p.z = 0;
  CHECK(refusal_of(flat).code == ErrorCode::SelfIntersection);
  Surface point = cube;
  for (Vec3& p : point.points) p = {1, 2, 3};
  CHECK(*refusal_of(point).point == Vec3(1, 2, 3));
}

TEST_CASE("coordinates that are not finite are refused with their triangle and another point of it") {
  for (const double bad : {kNan, kInfinity, -kInfinity}) {
    Surface surface = cube_surface(2);
    const std::uint32_t vertex = surface.tri_to_vert[6][1];
    surface.points[vertex].y = bad;
    const Surface before = surface;
    const SizeField sizes = SizeField::uniform(0.5);
    const Diagnostic error = error_of([&] { fill_volume(surface.input(sizes), {}, TaskRunner(1)); });
    CHECK(same_bits(surface, before));
    CHECK(error.code == ErrorCode::InvalidArgument);
    CHECK(says(error, "not finite"));
    REQUIRE(error.elements.size() == 1);
    const auto& corners = surface.tri_to_vert[error.elements[0]];
    CHECK(std::find(corners.begin(), corners.end(), vertex) != corners.end());
    REQUIRE(error.point);
    CHECK(is_finite(*error.point));
    REQUIRE(!error.entities.empty());
    CHECK(error.entities[0].entity == ModelEntity(2, surface.tri_to_face[error.elements[0]]));
  }
}

TEST_CASE("a size field of no size, or of none that is a number, cannot be made") {
  for (const double size : {0.0, -1.0, kNan, kInfinity}) {
    CAPTURE(size);
    CHECK(error_of([&] { SizeField::uniform(size); }).code == ErrorCode::InvalidArgument);
    SizeOctree tree;
    tree.width = 1, tree.domain = {{0, 0, 0}, {1, 1, 1}}, tree.size = size;
    tree.cells.assign(8, SizeOctree::kGlobalLeaf);
    CHECK(error_of([&] { SizeField::from_octree(tree); }).code == ErrorCode::InvalidArgument);
    tree.size = 1;
    tree.cells[3] = SizeOctree::kLeafBit;
    tree.corner_ratios = {1, 1, 1, 1, 1, 1, 1, static_cast<float>(size)};
    CHECK(error_of([&] { SizeField::from_octree(tree); }).code == ErrorCode::InvalidArgument);
  }
}

TEST_CASE("coordinates of which sixth powers are no numbers are refused, others are filled") {
  const auto scaled = [](double scale) {
    Surface surface = ball();
    for (Vec3& p : surface.points) p = scale * p;
    return surface;
  };
  for (const double scale : {0x1p-130, 0x1p140}) {
    CAPTURE(scale);
    const Surface surface = scaled(scale);
    const VolumeMesh mesh = fill_alone(surface, 0.5 * scale);
    CHECK(mesh.errors.empty());
    CHECK(check_filling(surface, mesh).at(0) > 0);
  }
  for (const double scale : {1e-300, 1e-160, 1e-45, 1e50, 1e160, 1e300}) {
    CAPTURE(scale);
    const Surface surface = scaled(scale);
    const SizeField sizes = SizeField::uniform(0.5 * scale);
    CHECK(error_of([&] { fill_volume(surface.input(sizes), {}, TaskRunner(1)); }).code == ErrorCode::InvalidArgument);
  }
}

TEST_CASE("sizes far from that of the surface fill it or are refused for want of memory") {
  const Surface surface = ball();
  for (const double size : {1e6, 1e100, 1e300}) {
    const VolumeMesh mesh = fill_alone(surface, size);
    CHECK(mesh.errors.empty());
    check_filling(surface, mesh);
  }
  for (const double size : {1e-6, 1e-100, 1e-300}) {
    const SizeField sizes = SizeField::uniform(size);
    CHECK(error_of([&] { fill_volume(surface.input(sizes), {}, TaskRunner(1)); }).code == ErrorCode::OutOfMemory);
  }
}

TEST_CASE("what cannot fit in memory is refused before anything is looked at") {
  const Surface surface = cube_surface(2);
  const SizeField sizes = SizeField::uniform(1e-3);
  int asked = 0;
  Host host;
  host.wants_stop = [&] { return ++asked > 0; };
  host.progress = [&](const ProgressEvent&) { return ++asked == 0; };
  VolumeOptions options;
  options.max_memory = 100'000'000;
  const Diagnostic error = error_of([&] { fill_volume(surface.input(sizes), options, TaskRunner(1, host)); });
  CHECK(error.code == ErrorCode::OutOfMemory);
  CHECK(asked == 0);
}
