#include "core/base/lists.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"

#include <algorithm>
#include <unordered_set>

#include "threading/parts/residence.hpp"

namespace tetloom {
namespace {

// What one side of a link says of the entity. Both sides must say the same with `here` and `there` exchanged.
struct ListedCopy {
  std::uint32_t here = 0, there = 0;
  std::array<std::uint64_t, 4> globals{};
  Vec3 point{};
  PackedEntity entity;
  std::uint32_t padding = 0;

  bool agrees_with(const ListedCopy& other) const {
    return here == other.there && there == other.here && globals == other.globals && point == other.point &&
           entity == other.entity;
  }
};

class PartValidator {
 public:
  PartValidator(PartId self, const Part& part) : self_(self), part_(part), mesh_(part.mesh) {}

  // Whether the arrays can be walked through at all.
  bool check_arrays() {
    bool sound = true;
    const auto require = [&](bool condition, const char* message) {
      if (!condition) add(message, {});
      sound = sound && condition;
    };
    const std::size_t verts = mesh_.vertex_count();
    require(mesh_.vert_to_entity.size() == verts && mesh_.vert_to_global.size() == verts &&
                mesh_.vert_to_place.size() == verts,
            "arrays of vertices differ in length");
    for (const CellKind kind : kAllCellKinds) {
      const CellBlock& block = mesh_.block(kind);
      require(block.to_vert.size() == block.size() * shape_of(kind).vertex_count &&
                  block.to_neighbor.size() == block.size() * shape_of(kind).face_count,
              "arrays of cells differ in length");
      require(std::all_of(block.to_vert.begin(), block.to_vert.end(), [&](std::uint32_t v) { return v < verts; }),
              "a cell uses a vertex that is not there");
    }
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const BoundaryBlock& block = mesh_.boundary[kind];
      require(block.to_vert.size() == block.size() * kBoundaryVertexCount[kind], "boundary arrays differ in length");
      require(std::all_of(block.to_vert.begin(), block.to_vert.end(), [&](std::uint32_t v) { return v < verts; }),
              "a boundary element uses a vertex that is not there");
    }
    require(is_csr(part_.boundary.vertices) && is_csr(part_.boundary.edges) && is_csr(part_.boundary.faces),
            "the lists of copies are torn");
    require(std::all_of(part_.boundary.vertices.entities.begin(), part_.boundary.vertices.entities.end(),
                        [&](std::uint32_t v) { return v < verts; }),
            "a shared vertex is not there");
    for (const VertexField& field : mesh_.vertex_fields)
      require(field.values.size() == verts * static_cast<std::size_t>(field.components), "a field has a wrong length");
    for (const CellField& field : mesh_.cell_fields)
      for (std::size_t kind = 0; kind < kCellKinds; ++kind)
        require(field.values[kind].size() == mesh_.cells[kind].size() * static_cast<std::size_t>(field.components),
                "a field has a wrong length");
    return sound;
  }

  void check_globals() {
    std::vector<std::uint64_t> globals(mesh_.vert_to_global.begin(), mesh_.vert_to_global.end());
    std::sort(globals.begin(), globals.end());
    if (std::adjacent_find(globals.begin(), globals.end()) != globals.end())
      add("two vertices have the same global id", {});
  }

  // Pre: check_arrays.
  void check_adjacency() {
    for (const CellKind kind : kAllCellKinds) {
      const std::uint32_t faces = shape_of(kind).face_count;
      const auto count = static_cast<std::uint32_t>(mesh_.block(kind).size() * faces);
      for (std::uint32_t i = 0; i < count; ++i) {
        const CellPlace face(kind, i / faces, i % faces), behind = neighbor_of(mesh_, face);
        if (!behind.valid()) continue;
        if (!is_face(behind) || neighbor_of(mesh_, behind) != face ||
            key_of_face(mesh_, behind) != key_of_face(mesh_, face))
          add("cells do not name each other as neighbours", point_of(face));
      }
    }
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v)
      if (!is_corner(mesh_.vert_to_place[v], v)) add("a vertex names a corner that is not its own", mesh_.points[v]);
    for (const FurtherPlace& further : mesh_.further_places)
      if (!is_corner(further.place, further.vert)) add("a vertex names a corner that is not its own", {});
  }

  // Pre: check_arrays.
  void check_residence(const Residence& residence) {
    const auto& shared = part_.boundary.vertices;
    std::vector<std::uint32_t> slot(mesh_.vertex_count(), kNone);
    for (std::uint32_t i = 0; i < shared.size(); ++i) slot[shared.entities[i]] = i;
    for (std::size_t i = 0; i < residence.verts.size(); ++i) {
      const std::uint32_t v = residence.verts[i];
      const auto parts =
          std::span(residence.parts).subspan(residence.first[i], residence.first[i + 1] - residence.first[i]);
      const auto copies = slot[v] == kNone ? std::span<const Copy>() : shared.copies_of(slot[v]);
      const bool same = std::equal(copies.begin(), copies.end(), parts.begin(), parts.end(),
                                   [](const Copy& copy, PartId part) { return copy.part == part; });
      if (!same) add("the copies of a vertex are not the parts that have its global id", mesh_.points[v]);
    }
    if (shared.size() != residence.verts.size()) add("a vertex is listed as shared that no other part has", {});
  }

  // Whom this part can write to, whatever its lists say.
  std::vector<PartId> receivers(std::size_t part_count) const {
    std::vector<PartId> parts = part_.boundary.neighbors;
    std::erase_if(parts, [&](PartId part) { return part.value >= part_count || part == self_; });
    sort_unique(parts);
    return parts;
  }

  void send_listed_copies(PartTask& task, std::size_t part_count) const {
    for (const PartId neighbor : receivers(part_count)) {
      MessageWriter writer;
      for (int dim = 0; dim < 3; ++dim) writer.put_array(std::span<const ListedCopy>(copies_in(neighbor, dim)));
      task.send(neighbor, writer.take());
    }
  }

  void compare_listed_copies(PartTask& task) {
    constexpr std::array<const char*, 3> messages{"links of a vertex do not agree with those of its copy",
                                                  "links of an edge do not agree with those of its copy",
                                                  "links of a face do not agree with those of its copy"};
    for (const Message& message : task.inbox()) {
      MessageReader reader(message.bytes);
      for (int dim = 0; dim < 3; ++dim) {
        const auto theirs = reader.get_view<ListedCopy>();
        std::vector<ListedCopy> expected(theirs.begin(), theirs.end());
        std::sort(expected.begin(), expected.end(),
                  [](const ListedCopy& a, const ListedCopy& b) { return a.there < b.there; });
        const std::vector<ListedCopy> own = copies_in(message.from, dim);
        if (own.size() != expected.size()) add("a part lists other copies than its neighbour does", {});
        for (std::size_t i = 0; i < std::min(own.size(), expected.size()); ++i)
          if (!own[i].agrees_with(expected[i])) add(messages[static_cast<std::size_t>(dim)], own[i].point);
      }
    }
  }

  void check_open_faces(bool has_boundary_elements) {
    const auto& shared = part_.boundary.faces;
    for (std::size_t i = 0; i < shared.size(); ++i) {
      const CellPlace face = shared.entities[i];
      if (!is_face(face)) {
        add("a shared face is not there", {});
        continue;
      }
      if (neighbor_of(mesh_, face).valid()) add("a face is shared although it has cells on both sides", point_of(face));
      if (shared.copies_of(i).size() != 1) add("a face is shared by more than two parts", point_of(face));
    }
    if (!has_boundary_elements) return;
    std::vector<FaceKey> elements;
    for (const BoundaryKind kind : {BoundaryKind::Triangle, BoundaryKind::Quad}) {
      const BoundaryBlock& block = mesh_.block(kind);
      const std::size_t n = kBoundaryVertexCount[static_cast<std::size_t>(kind)];
      for (std::size_t i = 0; i < block.size(); ++i)
        elements.push_back(key_of_verts(block.to_vert.span().subspan(i * n, n)));
    }
    std::sort(elements.begin(), elements.end());
    for_each_open_face(mesh_, [&](CellPlace face) {
      if (std::binary_search(shared.entities.begin(), shared.entities.end(), face)) return;
      if (!std::binary_search(elements.begin(), elements.end(), key_of_face(mesh_, face)))
        add("a face has nothing behind it: no cell, no other part, no boundary element", point_of(face));
    });
  }

  std::vector<PartProblem> take() { return std::move(problems_); }

 private:
  void add(const char* message, std::optional<Vec3> point) {
    const auto it = std::find_if(problems_.begin(), problems_.end(),
                                 [&](const PartProblem& problem) { return problem.message == message; });
    if (it != problems_.end()) {
      ++it->count;
    } else {
      problems_.push_back({self_, message, 1, point});
    }
  }

  template <class Entity>
  static bool is_csr(const SharedEntities<Entity>& shared) {
    if (shared.entities.empty()) return shared.copies.empty();
    return shared.first.size() == shared.size() + 1 && shared.first[0] == 0 &&
           shared.first.back() == shared.copies.size() && std::is_sorted(shared.first.begin(), shared.first.end());
  }

  bool is_face(CellPlace face) const {
    return face.valid() && face.cell() < mesh_.block(face.kind()).size() &&
           face.place() < shape_of(face.kind()).face_count;
  }
  bool is_corner(CellPlace place, std::uint32_t vert) const {
    if (!place.valid() || place.cell() >= mesh_.block(place.kind()).size()) return false;
    const std::uint32_t n = shape_of(place.kind()).vertex_count;
    return place.place() < n &&
           mesh_.block(place.kind()).to_vert[std::size_t{place.cell()} * n + place.place()] == vert;
  }
  Vec3 point_of(CellPlace face) const { return mesh_.points[vertices_of_face(mesh_, face)[0]]; }

  ListedCopy copy_of(std::span<const std::uint32_t> verts) const {
    ListedCopy listed;
    for (std::size_t i = 0; i < verts.size() && verts[i] < mesh_.vertex_count(); ++i)
      listed.globals[i] = mesh_.vert_to_global[verts[i]] + 1;
    std::sort(listed.globals.begin(), listed.globals.end());
    if (verts.size() == 1) listed.entity = mesh_.vert_to_entity[verts[0]];
    // The same vertex on both sides: that of the greatest global id.
    for (const std::uint32_t v : verts)
      if (v < mesh_.vertex_count() && mesh_.vert_to_global[v] + 1 == listed.globals.back())
        listed.point = mesh_.points[v];
    return listed;
  }

  template <class Entity, class VertsOf>
  std::vector<ListedCopy> copies_listed_in(const SharedEntities<Entity>& shared, PartId neighbor, bool by_position,
                                           const VertsOf& verts_of) const {
    std::vector<ListedCopy> copies;
    for (std::uint32_t i = 0; i < shared.size(); ++i) {
      for (const Copy& copy : shared.copies_of(i)) {
        if (copy.part != neighbor) continue;
        ListedCopy listed = copy_of(verts_of(shared.entities[i]));
        listed.here = by_position ? i : static_cast<std::uint32_t>(verts_of(shared.entities[i])[0]);
        listed.there = copy.local;
        copies.push_back(listed);
      }
    }
    return copies;
  }

  // Ascending by `here`.
  std::vector<ListedCopy> copies_in(PartId neighbor, int dim) const {
    std::array<std::uint32_t, 4> verts{};
    if (dim == 0) {
      return copies_listed_in(part_.boundary.vertices, neighbor, false, [&](std::uint32_t v) {
        verts[0] = v;
        return std::span<const std::uint32_t>(verts).first(1);
      });
    }
    if (dim == 1) {
      return copies_listed_in(part_.boundary.edges, neighbor, true, [&](const std::array<std::uint32_t, 2>& edge) {
        std::copy(edge.begin(), edge.end(), verts.begin());
        return std::span<const std::uint32_t>(verts).first(2);
      });
    }
    return copies_listed_in(part_.boundary.faces, neighbor, true, [&](CellPlace face) {
      if (!is_face(face)) return std::span<const std::uint32_t>();
      verts = vertices_of_face(mesh_, face);
      return std::span<const std::uint32_t>(verts).first(verts[3] == kNone ? 3 : 4);
    });
  }

  const PartId self_;
  const Part& part_;
  const PartMesh& mesh_;
  std::vector<PartProblem> problems_;
};

}  // namespace

PartsReport validate_parts(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace) {
  const auto local = mesh.local();
  std::vector<PartValidator> validators;
  for (const PartId part : local) validators.emplace_back(part, mesh.parts.at(part));
  const auto validator_of = [&](PartId part) -> PartValidator& { return validators[part.value - local.front().value]; };
  std::array<std::int64_t, 2> sums{};  // boundary elements, parts that cannot be walked through
  for (const PartId part : local) {
    const PartMesh& part_mesh = mesh.parts.at(part).mesh;
    sums[0] += static_cast<std::int64_t>(part_mesh.boundary[1].size() + part_mesh.boundary[2].size());
    sums[1] += validator_of(part).check_arrays() ? 0 : 1;
  }
  mesh.communicator->sum(sums);

  if (sums[1] == 0) {
    const TaskRunner deaf_runner = runner.uninterruptible();  // no rank may leave before the others
    const PerPart<Residence> residence = find_residence(mesh, deaf_runner);
    deaf_runner.for_each(local.size(), [&](std::size_t i) {
      validators[i].check_globals();
      validators[i].check_adjacency();
      validators[i].check_residence(residence.at(local[i]));
      validators[i].check_open_faces(sums[0] > 0);
    });
    // Lists of neighbours that contradict each other would leave a part waiting for ever, so receivers decide.
    PerPart<std::vector<PartId>> receivers(mesh.part_count(), local);
    for (const PartId part : local) receivers.at(part) = validator_of(part).receivers(mesh.part_count());
    const std::vector<Step> steps{
        {"validate: send links",
         [&](PartTask& task) { validator_of(task.part()).send_listed_copies(task, mesh.part_count()); },
         directed_links(*mesh.communicator, receivers),
         {}},
        {"validate: compare links",
         [&](PartTask& task) { validator_of(task.part()).compare_listed_copies(task); },
         {},
         {}}};
    Schedule(*mesh.communicator, runner, mesh.part_count(), trace).run(steps);
  }

  PartsReport report;
  for (PartValidator& validator : validators)
    for (PartProblem& problem : validator.take()) report.problems.push_back(std::move(problem));
  std::array<std::int64_t, 1> total{static_cast<std::int64_t>(report.problems.size())};
  mesh.communicator->sum(total);
  report.total = static_cast<std::uint64_t>(total[0]);
  return report;
}

}  // namespace tetloom
