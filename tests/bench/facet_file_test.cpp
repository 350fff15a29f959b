#include "bench/support/facet_file.hpp"

#include <array>
#include <catch2/catch.hpp>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "tests/support/temporary_folder.hpp"
#include "tetloom/io.hpp"

using namespace tetloom;
using namespace tetloom::bench;
namespace fs = std::filesystem;

namespace {

const char* const kTetrahedron = R"(# a comment
o part
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
vn 0 0 1
f 1/1/1 3/1/1 2/1/1
f 1 2 4
f 2 3 4
)";

fs::path write_text(const fs::path& path, const std::string& text) {
  std::ofstream(path) << text;
  return path;
}

}  // namespace

TEST_CASE("an OBJ file is closed when every edge has two facets") {
  const test::TemporaryFolder folder;
  const std::string whole = kTetrahedron + std::string("f -2 -4 -1\n");
  const Mesh closed = read_facet_file(write_text(folder / "closed.obj", whole));
  CHECK(closed.points.size() == 4);
  CHECK(closed.tri_to_vert.size() == 4);
  CHECK(is_closed_manifold(closed));
  CHECK(enclosed_volume(closed) == Approx(1. / 6));
  CHECK_FALSE(is_closed_manifold(read_facet_file(write_text(folder / "open.obj", kTetrahedron))));
  const std::string fin = whole + "v 3 3 3\nf 1 2 5\n";
  CHECK_FALSE(is_closed_manifold(read_facet_file(write_text(folder / "fin.obj", fin))));
  const std::string needle = whole + "f 1 2 2\n";
  CHECK(is_closed_manifold(read_facet_file(write_text(folder / "needle.obj", needle))));
}

TEST_CASE("space that facets wind around twice counts once") {
  // Two boxes that overlap by a fifth of each, seen as one surface; then the same inside out.
  Mesh boxes;
  for (const double from : {0.0, 0.8}) {
    const auto first = static_cast<std::uint32_t>(boxes.points.size());
    for (const double z : {0.0, 1.0})
      for (const double y : {0.0, 1.0})
        for (const double x : {from, from + 1}) boxes.points.push_back({x, y + 0.1 * from, z});
    for (const auto& [a, b, c, d] : {std::array{0u, 2u, 3u, 1u},
                                     {4u, 5u, 7u, 6u},
                                     {0u, 1u, 5u, 4u},
                                     {2u, 6u, 7u, 3u},
                                     {0u, 4u, 6u, 2u},
                                     {1u, 3u, 7u, 5u}}) {
      boxes.tri_to_vert.push_back({first + a, first + b, first + c});
      boxes.tri_to_vert.push_back({first + a, first + c, first + d});
    }
  }
  CHECK(enclosed_volume(boxes) == Approx(2));
  CHECK(wound_volume(boxes) == Approx(2 - 0.2 * 0.92).epsilon(0.005));
  for (auto& [a, b, c] : boxes.tri_to_vert) std::swap(b, c);
  CHECK(enclosed_volume(boxes) == Approx(-2));
  CHECK(wound_volume(boxes) == Approx(2 - 0.2 * 0.92).epsilon(0.005));
}

TEST_CASE("polygons of an OBJ file are cut into fans") {
  const test::TemporaryFolder folder;
  const Mesh square =
      read_facet_file(write_text(folder / "square.OBJ", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n"));
  CHECK(square.tri_to_vert.size() == 2);
}

TEST_CASE("STL files are read as text and as binary, with points merged") {
  const test::TemporaryFolder folder;
  const Mesh solid = read_facet_file(write_text(folder / "a.obj", kTetrahedron + std::string("f 1 4 3\n")));
  write_mesh(solid, folder / "binary.stl");
  const Mesh binary = read_facet_file(folder / "binary.stl");
  CHECK(binary.points.size() == 4);
  CHECK(is_closed_manifold(binary));
  // The last line is in two words and has no end.
  const char* const text =
      "solid x\n facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1 0 0\n vertex 0 1 0\n endloop\n endfacet\n"
      "end solid";
  CHECK(read_facet_file(write_text(folder / "text.stl", text)).tri_to_vert.size() == 1);
}

TEST_CASE("a facet file without triangles is an error") {
  const test::TemporaryFolder folder;
  CHECK_THROWS_AS(read_facet_file(write_text(folder / "empty.stl", "solid\nendsolid\n")), std::runtime_error);
  CHECK_THROWS_AS(read_facet_file(write_text(folder / "range.obj", "v 0 0 0\nf 1 2 3\n")), std::runtime_error);
}
