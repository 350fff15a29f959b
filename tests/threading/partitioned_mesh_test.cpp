// Parts under random migrations: the whole mesh stays what it was, and every link names its copy from both sides.
#include "threading/partitioned_mesh.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "core/mesh/digest.hpp"
#include "core/mesh/quality.hpp"
#include "core/mesh/validate.hpp"
#include "core/part/convert.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/threading/communicators.hpp"
#include "threading/migration.hpp"
#include "threading/validate_parts.hpp"
#include "threading/whole_mesh.hpp"

using namespace tetloom;

namespace {

using Random = std::mt19937_64;

// Values that name the vertex or cell they belong to.
void add_fields(Mesh& mesh) {
  MeshField coordinates{"coordinates", 3, {}};
  for (const Vec3& p : mesh.points) coordinates.values.insert(coordinates.values.end(), {p.x, p.y, p.z});
  mesh.point_fields.push_back(coordinates);
  MeshField sums{"sum of vertices", 1, {}};
  const auto add_sums = [&](const auto& cells) {
    for (const auto& verts : cells) {
      double sum = 0;
      for (const std::uint32_t v : verts) sum += mesh.points[v].x + 2 * mesh.points[v].y + 4 * mesh.points[v].z;
      sums.values.push_back(sum);
    }
  };
  add_sums(mesh.tet_to_vert);
  add_sums(mesh.pyramid_to_vert);
  add_sums(mesh.prism_to_vert);
  add_sums(mesh.hex_to_vert);
  mesh.cell_fields.push_back(sums);
}

void add_names(Mesh& mesh) {
  for (const ModelEntity entity : mesh.point_to_entity) {
    auto& table = mesh.entities[entity.dim];
    if (table.size() <= entity.index) table.resize(entity.index + 1);
  }
  mesh.entities[2].resize(std::max(mesh.entities[2].size(), mesh.face_to_sides.size()));
  const auto regions = std::max_element(mesh.tet_to_entity.begin(), mesh.tet_to_entity.end());
  mesh.entities[3].resize(*regions + 1);
  for (int dim = 0; dim < 4; ++dim) {
    for (std::size_t i = 0; i < mesh.entities[static_cast<std::size_t>(dim)].size(); i += 2) {
      EntityAttributes& attributes = mesh.entities[static_cast<std::size_t>(dim)][i];
      attributes = {
          "entity " + std::to_string(dim) + "/" + std::to_string(i), {}, "layer", 1e-3 * static_cast<double>(i)};
      if (i % 4 == 0) attributes.color = Color{0.25F, 0.5F, 1};
    }
  }
}

Mesh make_case(unsigned seed) {
  Mesh mesh = seed % 2 == 0 ? test::make_tet_box(4, 3, 2 + static_cast<int>(seed % 3), seed + 1, seed % 4 == 0)
                            : test::make_mixed_box(4, 2, 4, seed + 1, seed % 3 == 0);
  add_fields(mesh);
  if (seed % 5 != 0) add_names(mesh);
  return mesh;
}

Vec3 center_of(const PartMesh& part, CellId cell) {
  Vec3 sum{};
  const auto verts = vertices_of(part, cell);
  for (const std::uint32_t v : verts) sum = sum + part.points[v];
  return (1.0 / static_cast<double>(verts.size())) * sum;
}

// Calls visit(cell, position in the part's list of destinations).
template <class Visit>
void for_each_cell(const PartMesh& part, const Visit& visit) {
  std::size_t position = 0;
  for (const CellKind kind : kAllCellKinds)
    for (std::uint32_t i = 0; i < part.block(kind).size(); ++i) visit(CellId{kind, i}, position++);
}

enum class Dealing { Scatter, Slabs, Strip, AllToOne, Last };

// Depends on the parts' contents alone, so that all ranks and all kinds of communicators deal alike.
PerPart<Destinations> deal(const PartitionedMesh& mesh, std::size_t part_count, Dealing dealing, std::uint64_t seed) {
  PerPart<Destinations> destinations(mesh.part_count(), mesh.local());
  for (const PartId id : mesh.local()) {
    const PartMesh& part = mesh.parts.at(id).mesh;
    Destinations& own = destinations.at(id);
    own.resize(part.cell_count());
    Random random(seed * 1000 + id.value);
    for_each_cell(part, [&](CellId cell, std::size_t i) {
      const Vec3 c = center_of(part, cell);
      const auto slab = static_cast<std::uint32_t>((c.x + 0.3 * c.y + static_cast<double>(seed % 7)) * 1.7) %
                        static_cast<std::uint32_t>(part_count);
      const auto stay = static_cast<std::uint32_t>(id.value % part_count);
      switch (dealing) {
        case Dealing::Scatter: own[i] = static_cast<std::uint32_t>(random() % part_count); break;
        case Dealing::Slabs: own[i] = slab; break;
        case Dealing::Strip: own[i] = c.z < 1 ? slab : stay; break;
        default: own[i] = static_cast<std::uint32_t>(seed % part_count);
      }
    });
  }
  return destinations;
}

double volume_of(const Mesh& mesh) { return compute_quality(mesh).cells.volume; }

struct Whole {
  std::string digest, fields;
  double volume = 0;
  std::string entities;
};

std::string describe_entities(const Mesh& mesh) {
  std::string text;
  for (const auto& table : mesh.entities) {
    for (const EntityAttributes& a : table)
      text += a.name + "," + a.layer + "," + std::to_string(a.tolerance) + (a.color ? "c" : "-") + ";";
    text += "\n";
  }
  for (const FaceSides& sides : mesh.face_to_sides)
    text += std::to_string(sides.front.value) + "|" + std::to_string(sides.back.value) + ";";
  return text;
}

Whole describe_whole(const Mesh& mesh) {
  return {mesh_digest(mesh), field_digest(mesh), volume_of(mesh), describe_entities(mesh)};
}

void check_whole(const PartitionedMesh& mesh, const TaskRunner& runner, const Whole& expected) {
  const Mesh gathered = gather_mesh(mesh, runner);
  if (mesh.communicator->rank() != 0) return;
  const Whole whole = describe_whole(gathered);
  CHECK(whole.digest == expected.digest);
  CHECK(whole.fields == expected.fields);
  CHECK(whole.entities == expected.entities);
  CHECK(whole.volume == Approx(expected.volume).epsilon(1e-12));
  CHECK(validate_mesh(gathered).valid());
}

void check_links(PartitionedMesh& mesh, const TaskRunner& runner) {
  const PartsReport report = validate_parts(mesh, runner);
  for (const PartProblem& problem : report.problems)
    UNSCOPED_INFO("part " << problem.part.value << ": " << problem.message << " (" << problem.count << ")");
  CHECK(report.total == 0);
}

}  // namespace

TEST_CASE("a mesh survives becoming a part and back") {
  for (const unsigned seed : {0u, 1u, 2u, 3u}) {
    const Mesh mesh = make_case(seed);
    const Whole expected = describe_whole(mesh), whole = describe_whole(make_mesh(make_part(mesh)));
    CHECK(whole.digest == expected.digest);
    CHECK(whole.fields == expected.fields);
    CHECK(whole.entities == expected.entities);
  }
}

TEST_CASE("random migrations leave the whole mesh as it was, and all links whole") {
  const auto communicator = make_communicator();
  const TaskRunner runner(2);
  for (unsigned seed = 0; seed < 400; ++seed) {
    CAPTURE(seed);
    const Mesh original = make_case(seed);
    const Whole expected = describe_whole(original);
    PartitionedMesh mesh = distribute_mesh(original, *communicator);
    check_links(mesh, runner);
    Random random(seed);
    for (int round = 0; round < 5; ++round) {
      const std::size_t counts[] = {1, 2, 3, 7, 16, 40};
      const std::size_t part_count = counts[random() % 6];
      const auto dealing = static_cast<Dealing>(random() % static_cast<std::uint64_t>(Dealing::Last));
      CAPTURE(round, part_count, static_cast<int>(dealing));
      migrate(mesh, deal(mesh, part_count, dealing, random()), part_count, runner);
      CHECK(mesh.part_count() == part_count);
      check_links(mesh, runner);
    }
    check_whole(mesh, runner, expected);
  }
}
