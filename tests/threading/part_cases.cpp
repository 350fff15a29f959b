#include "tests/threading/part_cases.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <random>

#include "core/part/adjacency.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::test {
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
      attributes = {"entity " + std::to_string(dim) + "/" + std::to_string(i),
                    {},
                    "layer",
                    1e-3 * static_cast<double>(i),
                    "group"};
      if (i % 4 == 0) attributes.color = Color{0.25F, 0.5F, 1};
    }
  }
}

Vec3 center_of(const PartMesh& part, CellId cell) {
  Vec3 sum{};
  const auto verts = vertices_of(part, cell);
  for (const std::uint32_t v : verts) sum = sum + part.points[v];
  return (1.0 / static_cast<double>(verts.size())) * sum;
}

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

class Hash {
 public:
  void add(std::uint64_t word) {
    hash_ = (hash_ ^ word) * 0x9e3779b97f4a7c15u;
    hash_ ^= hash_ >> 29;
  }
  template <class T>
  void add(std::span<const T> values) {
    static_assert(std::has_unique_object_representations_v<T> || std::is_same_v<T, double>);
    add(values.size());
    for (const std::byte byte : std::as_bytes(values)) add(static_cast<std::uint64_t>(byte));
  }
  template <class T>
  void add(const GrowingArray<T>& values) {
    add(values.span());
  }
  void add(const GrowingArray<Vec3>& points) {
    for (const Vec3& p : points) add(std::span<const double>(std::array{p.x, p.y, p.z}));
  }
  void add(const std::string& text) { add(std::span<const char>(text)); }
  template <class First, class Second, class... More>
  void add(const First& first, const Second& second, const More&... more) {
    add(first), add(second, more...);
  }
  std::uint64_t get() const { return hash_; }

 private:
  std::uint64_t hash_ = 1;
};

template <class Entity>
void add_shared(Hash& hash, const SharedEntities<Entity>& shared) {
  hash.add(shared.entities, shared.first, shared.copies);
}

void add_elements(Hash& hash, const PartMesh& mesh) {
  for (const CellBlock& block : mesh.cells) hash.add(block.to_vert, block.to_neighbor, block.to_region);
  for (const BoundaryBlock& block : mesh.boundary) hash.add(block.to_vert, block.to_entity);
}

void add_fields(Hash& hash, const PartMesh& mesh) {
  for (const VertexField& field : mesh.vertex_fields) hash.add(field.name, field.values);
  for (const CellField& field : mesh.cell_fields) {
    hash.add(field.name);
    for (const auto& values : field.values) hash.add(values);
  }
}

void add_entity(Hash& hash, const PartEntity& entity) {
  hash.add(static_cast<std::uint64_t>(entity.entity.dim));
  hash.add(std::uint64_t{entity.entity.index} * 2 + (entity.has_attributes ? 1 : 0));
  hash.add(entity.attributes.name);
  hash.add(entity.attributes.layer);
  hash.add(std::span<const double>(std::array{entity.attributes.tolerance}));
  hash.add(std::uint64_t{entity.sides.front.value} << 32 | entity.sides.back.value);
}

std::uint64_t hash_of(const Part& part) {
  Hash hash;
  const PartMesh& mesh = part.mesh;
  hash.add(mesh.points, mesh.vert_to_entity, mesh.vert_to_global, mesh.vert_to_place, mesh.further_places);
  add_elements(hash, mesh);
  add_fields(hash, mesh);
  for (const PartEntity& entity : mesh.entities) add_entity(hash, entity);
  add_shared(hash, part.boundary.vertices);
  add_shared(hash, part.boundary.edges);
  add_shared(hash, part.boundary.faces);
  hash.add(std::span<const PartId>(part.boundary.neighbors));
  return hash.get();
}

}  // namespace

Mesh make_case(unsigned seed) {
  Mesh mesh = seed % 2 == 0 ? make_tet_box(4, 3, 2 + static_cast<int>(seed % 3), seed + 1, seed % 4 == 0)
                            : make_mixed_box(4, 2, 4, seed + 1, seed % 3 == 0);
  add_fields(mesh);
  if (seed % 5 != 0) add_names(mesh);
  return mesh;
}

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

Dealing dealing_of(std::uint64_t number) {
  return static_cast<Dealing>(number % static_cast<std::uint64_t>(Dealing::Last));
}

Whole describe_whole(const Mesh& mesh) {
  return {mesh_digest(mesh), field_digest(mesh), compute_quality(mesh).cells.volume, describe_entities(mesh)};
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

std::vector<std::uint64_t> hash_parts(const PartitionedMesh& mesh) {
  MessageWriter writer;
  for (const PartId part : mesh.local()) writer.put(hash_of(mesh.parts.at(part)));
  std::vector<std::uint64_t> hashes;
  for (const Bytes& bytes : mesh.communicator->all_gather(writer.take()))
    for (MessageReader reader(bytes); !reader.at_end();) hashes.push_back(reader.get<std::uint64_t>());
  return hashes;
}

}  // namespace tetloom::test
