// One damage at a time, and what is said of it.
#include "core/part/adjacency.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "tests/support/mixed_mesh.hpp"
#include "tests/threading/part_cases.hpp"

using namespace tetloom;
using namespace tetloom::test;

namespace {

// A box of tets or of all kinds of cells in three scattered parts.
class Fixture {
 public:
  explicit Fixture(const Mesh& whole = make_mixed_box(3, 2, 4)) : mesh(distribute_mesh(whole, *communicator_)) {
    migrate(mesh, deal(mesh, 3, Dealing::Slabs, 1), 3, runner_);
    REQUIRE(validate_parts(mesh, runner_).valid());
    for (const PartId id : mesh.local()) REQUIRE(mesh.parts.at(id).boundary.faces.size() > 2);
  }
  Part& part(std::size_t i = 0) { return mesh.parts.at(PartId(i)); }

  /// Whether validate_parts says this.
  bool finds(const std::string& message, std::size_t in_part = 0) {
    const PartsReport report = validate_parts(mesh, runner_);
    CHECK_FALSE(report.valid());
    CHECK(report.total == report.problems.size());
    for (const PartProblem& problem : report.problems) {
      UNSCOPED_INFO("part " << problem.part.value << ": " << problem.message);
      if (problem.part.value == in_part && problem.message == message) return problem.count > 0;
    }
    return false;
  }

 private:
  std::unique_ptr<Communicator> communicator_ = make_thread_communicator();
  TaskRunner runner_{2};

 public:
  PartitionedMesh mesh;
};

// Takes the i-th entity with its copies out.
template <class Entity>
void remove_entity(SharedEntities<Entity>& shared, std::size_t which) {
  SharedEntities<Entity> left;
  for (std::size_t i = 0; i < shared.size(); ++i) {
    if (i == which) continue;
    left.entities.push_back(shared.entities[i]);
    left.first.push_back(static_cast<std::uint32_t>(left.copies.size()));
    left.copies.append(shared.copies_of(i));
  }
  left.first.push_back(static_cast<std::uint32_t>(left.copies.size()));
  shared = left;
}

// Exchanges where two entities that are shared with the same part say their copy is.
template <class Entity>
void swap_copies(SharedEntities<Entity>& shared) {
  Copy& first = shared.copies[0];
  const auto other = std::find_if(shared.copies.begin() + 1, shared.copies.end(),
                                  [&](const Copy& copy) { return copy.part == first.part; });
  REQUIRE(other != shared.copies.end());
  std::swap(first.local, other->local);
}

void drop_last(CellBlock& block, CellKind kind) {
  block.to_region.resize(block.size() - 1);
  block.to_vert.resize(block.size() * shape_of(kind).vertex_count);
  block.to_neighbor.resize(block.size() * shape_of(kind).face_count);
}

void drop_last(BoundaryBlock& block, BoundaryKind kind) {
  block.to_entity.resize(block.size() - 1);
  block.to_vert.resize(block.size() * kBoundaryVertexCount[static_cast<std::size_t>(kind)]);
}

}  // namespace

TEST_CASE("a copy at another place is found, in both parts") {
  Fixture fixture;
  const auto& shared = fixture.part(1).boundary.vertices;
  fixture.part(1).mesh.points[shared.entities[0]].x += 1e-9;
  CHECK(fixture.finds("links of a vertex do not agree with those of its copy", 1));
  CHECK(fixture.finds("links of a vertex do not agree with those of its copy", shared.copies[0].part.value));
}

TEST_CASE("a copy with another classification is found") {
  Fixture fixture;
  fixture.part().mesh.vert_to_entity[fixture.part().boundary.vertices.entities[0]] = PackedEntity(ModelEntity(0, 77));
  CHECK(fixture.finds("links of a vertex do not agree with those of its copy"));
}

TEST_CASE("a copy with another global id is found, by all that have the vertex") {
  Fixture fixture;
  const auto& shared = fixture.part().boundary.vertices;
  fixture.part().mesh.vert_to_global[shared.entities[0]] = 1'000'000;
  CHECK(fixture.finds("a vertex is listed as shared that no other part has"));
  CHECK(fixture.finds("links of a vertex do not agree with those of its copy"));
  CHECK(fixture.finds("a vertex is listed as shared that no other part has", shared.copies[0].part.value));
}

TEST_CASE("two vertices of a part with one global id are found") {
  Fixture fixture;
  fixture.part().mesh.vert_to_global[0] = fixture.part().mesh.vert_to_global[1];
  CHECK(fixture.finds("two vertices have the same global id"));
}

TEST_CASE("a lost link of a vertex is found") {
  Fixture fixture;
  remove_entity(fixture.part().boundary.vertices, 0);
  CHECK(fixture.finds("the copies of a vertex are not the parts that have its global id"));
  CHECK(fixture.finds("a part lists other copies than its neighbour does"));
}

TEST_CASE("a lost link of an edge or a face is found") {
  Fixture edges, faces;
  remove_entity(edges.part().boundary.edges, 1);
  CHECK(edges.finds("a part lists other copies than its neighbour does"));
  remove_entity(faces.part().boundary.faces, 1);
  CHECK(faces.finds("a part lists other copies than its neighbour does"));
  CHECK(faces.finds("a face has nothing behind it: no cell, no other part, no boundary element"));
}

TEST_CASE("links that name each other's copies are found") {
  Fixture verts, edges, faces;
  swap_copies(verts.part().boundary.vertices);
  CHECK(verts.finds("links of a vertex do not agree with those of its copy"));
  swap_copies(edges.part().boundary.edges);
  CHECK(edges.finds("links of an edge do not agree with those of its copy"));
  swap_copies(faces.part().boundary.faces);
  CHECK(faces.finds("links of a face do not agree with those of its copy"));
}

TEST_CASE("a link to a part that is not there or to the part itself is found, and nobody waits for it") {
  for (const std::size_t part : {std::size_t{0}, std::size_t{99}}) {
    Fixture fixture;
    fixture.part().boundary.vertices.copies[0].part = PartId(part);
    fixture.part().boundary.neighbors.push_back(PartId(part));
    CHECK(fixture.finds("the copies of a vertex are not the parts that have its global id"));
  }
}

TEST_CASE("a face that is shared although it has cells on both sides is found") {
  Fixture fixture;
  const CellPlace face = fixture.part().boundary.faces.entities[0];
  CellBlock& block = fixture.part().mesh.block(face.kind());
  block.to_neighbor[face.cell() * shape_of(face.kind()).face_count + face.place()] = CellPlace(CellKind::Tet, 0, 0);
  CHECK(fixture.finds("a face is shared although it has cells on both sides"));
}

TEST_CASE("a cell that is gone is found, whether its part noticed or not") {
  for (const CellKind kind : {CellKind::Tet, CellKind::Prism, CellKind::Hex}) {
    Fixture fixture;
    REQUIRE(fixture.part().mesh.block(kind).size() > 1);
    drop_last(fixture.part().mesh.block(kind), kind);
    CHECK(fixture.finds("cells do not name each other as neighbours"));
    connect_cells(fixture.part().mesh);
    CHECK(fixture.finds("a face has nothing behind it: no cell, no other part, no boundary element"));
  }
}

TEST_CASE("neighbours that do not share the face are found") {
  Fixture fixture(make_tet_box(4, 3, 2));
  auto& to_neighbor = fixture.part().mesh.block(CellKind::Tet).to_neighbor;
  const auto inner = std::find_if(to_neighbor.begin(), to_neighbor.end(), [](CellPlace p) { return p.valid(); });
  *inner = CellPlace(CellKind::Tet, inner->cell(), (inner->place() + 1) % 4);
  CHECK(fixture.finds("cells do not name each other as neighbours"));
}

TEST_CASE("a vertex that names a corner of another is found") {
  Fixture fixture;
  std::swap(fixture.part().mesh.vert_to_place[0], fixture.part().mesh.vert_to_place[1]);
  CHECK(fixture.finds("a vertex names a corner that is not its own"));
}

TEST_CASE("a boundary element that is gone is found") {
  for (const BoundaryKind kind : {BoundaryKind::Triangle, BoundaryKind::Quad}) {
    Fixture fixture;
    REQUIRE(fixture.part().mesh.block(kind).size() > 1);
    drop_last(fixture.part().mesh.block(kind), kind);
    CHECK(fixture.finds("a face has nothing behind it: no cell, no other part, no boundary element"));
  }
}

TEST_CASE("arrays that do not fit together are found") {
  Fixture verts, cells, boundary, links, fields(make_case(1));
  verts.part().mesh.vert_to_global.resize(verts.part().mesh.vertex_count() - 1);
  CHECK(verts.finds("arrays of vertices differ in length"));
  cells.part().mesh.block(CellKind::Tet).to_neighbor.push_back({});
  CHECK(cells.finds("arrays of cells differ in length"));
  boundary.part().mesh.block(BoundaryKind::Triangle).to_vert.push_back(0);
  CHECK(boundary.finds("boundary arrays differ in length"));
  links.part().boundary.edges.first.push_back(0);
  CHECK(links.finds("the lists of copies are torn"));
  fields.part().mesh.vertex_fields.at(0).values.push_back(0);
  CHECK(fields.finds("a field has a wrong length"));
}

TEST_CASE("indices beyond the vertices are found") {
  Fixture cells, boundary, shared;
  cells.part().mesh.block(CellKind::Tet).to_vert[2] = 1'000'000;
  CHECK(cells.finds("a cell uses a vertex that is not there"));
  boundary.part().mesh.block(BoundaryKind::Triangle).to_vert[1] = 1'000'000;
  CHECK(boundary.finds("a boundary element uses a vertex that is not there"));
  shared.part().boundary.vertices.entities[0] = 1'000'000;
  CHECK(shared.finds("a shared vertex is not there"));
}

TEST_CASE("a shared face of a cell that is not there is found") {
  Fixture fixture;
  auto& faces = fixture.part().boundary.faces.entities;
  faces[faces.size() - 1] = CellPlace(CellKind::Hex, 1'000'000, 0);
  CHECK(fixture.finds("a shared face is not there"));
}
