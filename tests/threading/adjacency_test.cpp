// Neighbours, balls, shells and faces against brute force, in parts whose cells hang together or do not.
#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>
#include <random>

#include "tests/support/mixed_mesh.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/threading/part_cases.hpp"
#include "tetloom/partition.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

using FaceTable = std::map<FaceKey, std::vector<CellPlace>>;

FaceTable list_faces(const PartMesh& part) {
  FaceTable faces;
  for_each_cell(part, [&](CellId cell, std::size_t) {
    const CellShape& shape = shape_of(cell.kind);
    const auto verts = vertices_of(part, cell);
    for (std::uint32_t f = 0; f < shape.face_count; ++f) {
      FaceKey key{kNone, kNone, kNone, kNone};
      for (std::uint32_t i = 0; i < shape.face[f].count; ++i) key[i] = verts[shape.face[f].vert[i]];
      std::sort(key.begin(), key.end());
      faces[key].push_back(CellPlace(cell.kind, cell.index, f));
    }
  });
  return faces;
}

void check_neighbors(const PartMesh& part, const FaceTable& faces) {
  std::vector<CellPlace> open, found;
  for (const auto& [key, sides] : faces) {
    REQUIRE(sides.size() <= 2);
    for (std::size_t i = 0; i < sides.size(); ++i) {
      CHECK(neighbor_of(part, sides[i]) == (sides.size() == 2 ? sides[1 - i] : CellPlace()));
      CHECK(key_of_face(part, sides[i]) == key);
    }
    if (sides.size() == 1) open.push_back(sides[0]);
  }
  std::sort(open.begin(), open.end());
  for_each_open_face(part, [&](CellPlace face) { found.push_back(face); });
  CHECK(found == open);
}

std::vector<CellPlace> sorted(std::span<const CellPlace> places) {
  std::vector<CellPlace> result(places.begin(), places.end());
  std::sort(result.begin(), result.end());
  return result;
}

// How many of the balls consist of several groups.
std::size_t check_balls(const PartMesh& part) {
  std::vector<std::vector<CellPlace>> balls(part.vertex_count());
  for_each_cell(part, [&](CellId cell, std::size_t) {
    const auto verts = vertices_of(part, cell);
    for (std::uint32_t i = 0; i < verts.size(); ++i) balls[verts[i]].push_back(CellPlace(cell.kind, cell.index, i));
  });
  BallFinder finder(part);
  for (std::uint32_t v = 0; v < part.vertex_count(); ++v) CHECK(sorted(finder.find_ball(v)) == balls[v]);
  std::vector<std::uint32_t> split;
  for (const FurtherPlace& further : part.further_places) split.push_back(further.vert);
  CHECK(std::is_sorted(split.begin(), split.end()));
  return static_cast<std::size_t>(std::unique(split.begin(), split.end()) - split.begin());
}

void check_shells(const PartMesh& part, std::mt19937& random) {
  std::map<std::array<std::uint32_t, 2>, std::vector<CellId>> shells;
  for_each_cell(part, [&](CellId cell, std::size_t) {
    const auto verts = vertices_of(part, cell);
    for (const auto& edge : shape_of(cell.kind).edges())
      shells[{std::min(verts[edge[0]], verts[edge[1]]), std::max(verts[edge[0]], verts[edge[1]])}].push_back(cell);
  });
  BallFinder finder(part);
  for (auto& [edge, cells] : shells) {
    const auto found = finder.find_shell(edge[1], edge[0]);
    CHECK(std::equal(found.begin(), found.end(), cells.begin(), cells.end()));
  }
  for (int i = 0; i < 20 && part.vertex_count() > 0; ++i) {
    const auto count = static_cast<std::uint32_t>(part.vertex_count());
    const std::uint32_t a = static_cast<std::uint32_t>(random()) % count;
    const std::uint32_t b = static_cast<std::uint32_t>(random()) % count;
    if (!shells.contains({std::min(a, b), std::max(a, b)})) CHECK(finder.find_shell(a, b).empty());
  }
}

void check_faces(const PartMesh& part, const FaceTable& faces, std::mt19937& random) {
  BallFinder finder(part);
  for (const auto& [key, sides] : faces) {
    const std::size_t n = key[3] == kNone ? 3 : 4;
    std::vector<std::uint32_t> verts(key.begin(), key.begin() + static_cast<std::ptrdiff_t>(n));
    std::shuffle(verts.begin(), verts.end(), random);
    CHECK(finder.find_face(verts) == *std::min_element(sides.begin(), sides.end()));
    verts[n - 1] = verts[0];
    CHECK_FALSE(finder.find_face(verts).valid());
  }
}

std::size_t check_part(const PartMesh& part, std::mt19937& random) {
  const FaceTable faces = list_faces(part);
  check_neighbors(part, faces);
  check_shells(part, random);
  check_faces(part, faces, random);
  return check_balls(part);
}

PartMesh part_of_tets(std::initializer_list<std::uint32_t> verts) {
  PartMesh part;
  auto& block = part.block(CellKind::Tet);
  block.to_vert = verts;
  block.to_region.resize(verts.size() / 4, 0);
  part.points.resize(*std::max_element(verts.begin(), verts.end()) + 1);
  connect_cells(part);
  return part;
}

}  // namespace

TEST_CASE("neighbours, balls, shells and faces are those of brute force, whole or in scattered parts") {
  const auto communicator = make_thread_communicator();
  const TaskRunner runner(2);
  std::size_t split_balls = 0;
  const unsigned seeds = kSanitized ? 4 : 12;
  for (unsigned seed = 0; seed < seeds; ++seed) {
    CAPTURE(seed);
    std::mt19937 random(seed);
    PartitionedMesh mesh = distribute_mesh(make_case(seed), *communicator);
    CHECK(check_part(mesh.parts.at(PartId(0)).mesh, random) == 0);
    for (const std::size_t part_count : {3, 8}) {
      migrate(mesh, deal(mesh, part_count, seed % 3 == 0 ? Dealing::Slabs : Dealing::Scatter, seed), part_count,
              runner);
      for (const PartId part : mesh.local()) split_balls += check_part(mesh.parts.at(part).mesh, random);
    }
  }
  CHECK(split_balls > 100);
}

TEST_CASE("two tets that share a face are neighbours") {
  const PartMesh part = part_of_tets({0, 1, 2, 3, 1, 2, 3, 4});
  std::mt19937 random;
  CHECK(check_part(part, random) == 0);
  CHECK(BallFinder(part).find_face(std::array{1u, 2u, 3u}).cell() == 0);
}

TEST_CASE("tets that share an edge or a vertex alone are in balls of several groups") {
  std::mt19937 random;
  CHECK(check_part(part_of_tets({0, 1, 2, 3, 0, 1, 4, 5}), random) == 2);
  CHECK(check_part(part_of_tets({0, 1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9}), random) == 1);
}

TEST_CASE("of three tets at one face two are linked and one stays open") {
  const PartMesh part = part_of_tets({0, 1, 2, 3, 0, 1, 2, 4, 0, 1, 2, 5});
  const FaceTable faces = list_faces(part);
  std::size_t linked = 0;
  for (const CellPlace face : faces.at({0, 1, 2, kNone})) {
    const CellPlace other = neighbor_of(part, face);
    if (!other.valid()) continue;
    ++linked;
    CHECK(neighbor_of(part, other) == face);
  }
  CHECK(linked == 2);
  check_balls(part);
}

TEST_CASE("a part without cells has nothing") {
  PartMesh part;
  connect_cells(part);
  CHECK(part.further_places.empty());
  part.points.resize(2);
  connect_cells(part);
  CHECK(BallFinder(part).find_ball(1).empty());
  CHECK(BallFinder(part).find_shell(0, 1).empty());
  CHECK_FALSE(BallFinder(part).find_face(std::array{0u, 1u, 2u}).valid());
}
