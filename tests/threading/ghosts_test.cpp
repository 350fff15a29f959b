// Ghost layers against a search through the whole mesh.
#include "threading/parts/ghosts.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <set>

#include "core/part/convert.hpp"
#include "tests/threading/communicators.hpp"
#include "tests/threading/part_cases.hpp"
#include "tetloom/partition.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

using Globals = std::vector<std::uint64_t>;  // of a cell's vertices, in its order

Globals globals_of(const PartMesh& part, CellId cell) {
  Globals globals;
  for (const std::uint32_t v : vertices_of(part, cell)) globals.push_back(part.vert_to_global[v]);
  return globals;
}

// The cells, in layers, that a search over shared vertices reaches from those of `part`, without its own.
std::set<Globals> find_surroundings(const PartMesh& whole, const PartMesh& part, int layers) {
  std::set<Globals> own, found;
  std::set<std::uint64_t> reached(part.vert_to_global.begin(), part.vert_to_global.end());
  for_each_cell(part, [&](CellId cell, std::size_t) { own.insert(globals_of(part, cell)); });
  for (int layer = 0; layer < layers; ++layer) {
    std::set<std::uint64_t> next = reached;
    for_each_cell(whole, [&](CellId cell, std::size_t) {
      const Globals globals = globals_of(whole, cell);
      if (std::none_of(globals.begin(), globals.end(), [&](std::uint64_t g) { return reached.contains(g); })) return;
      if (!own.contains(globals)) found.insert(globals);
      next.insert(globals.begin(), globals.end());
    });
    reached = next;
  }
  return found;
}

std::set<Globals> ghosts_of(const GhostedPart& ghosted) {
  std::set<Globals> found;
  for (const CellKind kind : kAllCellKinds)
    for (std::size_t i = ghosted.own_cells[static_cast<std::size_t>(kind)]; i < ghosted.mesh.block(kind).size(); ++i)
      CHECK(found.insert(globals_of(ghosted.mesh, {kind, static_cast<std::uint32_t>(i)})).second);
  return found;
}

CellId cell_of(const PartMesh& part, std::uint32_t number) {
  CellId found;
  for_each_cell(part, [&](CellId cell, std::size_t position) {
    if (position == number) found = cell;
  });
  return found;
}

// Ghosts name the part and the number under which the original is found.
void check_origins(const PartitionedMesh& mesh, const GhostedPart& ghosted) {
  for (std::size_t i = 0; i < ghosted.ghost_vertices.size(); ++i) {
    const Copy& origin = ghosted.ghost_vertices[i];
    if (!mesh.parts.is_local(origin.part)) continue;
    CHECK(mesh.parts.at(origin.part).mesh.vert_to_global[origin.local] ==
          ghosted.mesh.vert_to_global[ghosted.own_vertices + i]);
  }
  for (const CellKind kind : kAllCellKinds) {
    const auto k = static_cast<std::size_t>(kind);
    for (std::size_t i = 0; i < ghosted.ghost_cells[k].size(); ++i) {
      const Copy& origin = ghosted.ghost_cells[k][i];
      if (!mesh.parts.is_local(origin.part)) continue;
      const PartMesh& home = mesh.parts.at(origin.part).mesh;
      CHECK(globals_of(home, cell_of(home, origin.local)) ==
            globals_of(ghosted.mesh, {kind, static_cast<std::uint32_t>(ghosted.own_cells[k] + i)}));
    }
  }
}

// Own vertices and cells stand first, as they are in the part.
void check_own(const PartMesh& part, const GhostedPart& ghosted) {
  CHECK(ghosted.own_vertices == part.vertex_count());
  for (const CellKind kind : kAllCellKinds) {
    const auto own = part.block(kind).to_vert.span();
    CHECK(std::equal(own.begin(), own.end(), ghosted.mesh.block(kind).to_vert.begin()));
  }
  std::size_t open = 0;
  for_each_open_face(ghosted.mesh, [&](CellPlace face) {
    open += face.cell() < ghosted.own_cells[static_cast<std::size_t>(face.kind())] ? 1 : 0;
  });
  std::size_t boundary = 0;
  BallFinder finder(part);
  for (const BoundaryKind kind : {BoundaryKind::Triangle, BoundaryKind::Quad}) {
    const BoundaryBlock& block = ghosted.mesh.block(kind);
    const std::size_t n = kBoundaryVertexCount[static_cast<std::size_t>(kind)];
    for (std::size_t i = 0; i < part.block(kind).size(); ++i) {
      const auto verts = block.to_vert.span().subspan(i * n, n);
      BallFinder ghosted_finder(ghosted.mesh);
      const CellPlace face = ghosted_finder.find_face(verts);
      boundary += !neighbor_of(ghosted.mesh, face).valid() ? 1 : 0;
    }
  }
  CHECK(open == boundary);  // own faces end only where the whole mesh ends
}

PartitionedMesh make_parts(unsigned seed, std::size_t part_count, Communicator& communicator,
                           const TaskRunner& runner) {
  PartitionedMesh mesh = distribute_mesh(make_case(seed), communicator);
  const Dealing dealing = seed % 2 == 0 ? Dealing::Slabs : Dealing::Scatter;
  migrate(mesh, deal(mesh, part_count, dealing, seed), part_count, runner);
  return mesh;
}

}  // namespace

TEST_CASE("ghosts are the cells that a search through the whole mesh finds") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  for (unsigned seed = 0; seed < 8; ++seed) {
    const PartMesh whole = make_part(make_case(seed));
    const PartitionedMesh mesh = make_parts(seed, 2 + seed, *communicator, runner);
    for (const int layers : {1, 2, 3}) {
      CAPTURE(seed, layers);
      const PerPart<GhostedPart> ghosted = make_ghosts(mesh, layers, runner);
      for (const PartId part : mesh.local()) {
        CHECK(ghosts_of(ghosted.at(part)) == find_surroundings(whole, mesh.parts.at(part).mesh, layers));
        check_origins(mesh, ghosted.at(part));
        check_own(mesh.parts.at(part).mesh, ghosted.at(part));
      }
    }
  }
}

TEST_CASE("ghosts carry the fields of their cells and vertices") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  const PartitionedMesh mesh = make_parts(1, 5, *communicator, runner);
  const PerPart<GhostedPart> ghosted = make_ghosts(mesh, 1, runner);
  for (const PartId part : mesh.local()) {
    const PartMesh& with_ghosts = ghosted.at(part).mesh;
    for (std::size_t v = 0; v < with_ghosts.vertex_count(); ++v)
      CHECK(with_ghosts.vertex_fields[0].values[3 * v] == with_ghosts.points[v].x);
  }
  CHECK_THROWS_AS(make_ghosts(mesh, 0, runner), Error);
}

TEST_CASE("a mesh that is given up gets the same ghosts, unconnected") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  PartitionedMesh mesh = make_parts(3, 4, *communicator, runner);
  const PerPart<GhostedPart> copied = make_ghosts(mesh, 2, runner);
  const std::vector<PartId> parts(mesh.local().begin(), mesh.local().end());
  const PerPart<GhostedPart> moved = add_ghosts(std::move(mesh), 2, runner);
  for (const PartId part : parts) {
    CHECK(ghosts_of(moved.at(part)) == ghosts_of(copied.at(part)));
    CHECK(moved.at(part).own_cells == copied.at(part).own_cells);
    CHECK(moved.at(part).mesh.points == copied.at(part).mesh.points);
    for (std::size_t kind = 0; kind < kCellKinds; ++kind) {
      CHECK(moved.at(part).mesh.cells[kind].to_vert == copied.at(part).mesh.cells[kind].to_vert);
      CHECK(moved.at(part).mesh.cells[kind].to_neighbor.empty());
    }
  }
}

TEST_CASE("new global ids count the vertices of all parts without gaps") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  for (unsigned seed = 0; seed < 6; ++seed) {
    PartitionedMesh mesh = make_parts(seed, 3 + seed, *communicator, runner);
    const std::size_t points = make_part(make_case(seed)).vertex_count();
    assign_global_ids(mesh, runner);
    check_links(mesh, runner);
    std::vector<std::int64_t> owners(points, 0);
    for (const PartId id : mesh.local()) {
      const Part& part = mesh.parts.at(id);
      std::vector<bool> foreign(part.mesh.vertex_count(), false);
      for (std::size_t i = 0; i < part.boundary.vertices.size(); ++i)
        foreign[part.boundary.vertices.entities[i]] = owner_of(part.boundary.vertices.copies_of(i), id) != id;
      for (std::size_t v = 0; v < foreign.size(); ++v)
        if (!foreign[v]) ++owners.at(part.mesh.vert_to_global[v]);
    }
    communicator->sum(owners);
    CHECK(owners == std::vector<std::int64_t>(points, 1));
  }
}

TEST_CASE("copies take the values of their owners") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  PartitionedMesh mesh = make_parts(3, 6, *communicator, runner);
  for (const PartId id : mesh.local()) {
    Part& part = mesh.parts.at(id);
    for (std::size_t i = 0; i < part.boundary.vertices.size(); ++i)
      if (owner_of(part.boundary.vertices.copies_of(i), id) != id)
        part.mesh.vertex_fields[0].values[3 * part.boundary.vertices.entities[i]] = -1;
  }
  update_copies(mesh, 0, runner);
  for (const PartId id : mesh.local()) {
    const PartMesh& part = mesh.parts.at(id).mesh;
    for (std::size_t v = 0; v < part.vertex_count(); ++v)
      CHECK(part.vertex_fields[0].values[3 * v] == part.points[v].x);
  }
}
