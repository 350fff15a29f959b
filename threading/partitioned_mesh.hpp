#pragma once
// A mesh in parts: each part a serial mesh, and for everything on part boundaries where its copies are.
#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/part/adjacency.hpp"
#include "core/part/part_mesh.hpp"
#include "threading/communicator.hpp"
#include "threading/schedule.hpp"

namespace tetloom {

/// The same vertex, edge or face in another part: its place in that part's own list for vertices the local vertex,
/// for edges and faces the position in `PartBoundary::edges` or `faces` there.
struct Copy {
  PartId part;
  std::uint32_t local = 0;
  friend constexpr auto operator<=>(const Copy&, const Copy&) = default;
};

/// The entities of one dimension that other parts have too, each with its copies elsewhere.
template <class Entity>
struct SharedEntities {
  GrowingArray<Entity> entities;      ///< ascending
  GrowingArray<std::uint32_t> first;  ///< of the copies of each; one longer than `entities`, or empty
  GrowingArray<Copy> copies;          ///< ascending for each entity
  std::size_t size() const { return entities.size(); }
  std::span<const Copy> copies_of(std::size_t i) const {
    return copies.span().subspan(first[i], first[i + 1] - first[i]);
  }
};

/// The lowest part that has a copy owns the entity.
inline PartId owner_of(std::span<const Copy> copies, PartId self) {
  return copies.empty() ? self : std::min(self, copies.front().part);
}

struct PartBoundary {
  SharedEntities<std::uint32_t> vertices;              ///< local vertices
  SharedEntities<std::array<std::uint32_t, 2>> edges;  ///< local vertices, ascending
  SharedEntities<CellPlace> faces;                     ///< faces of this part's cells
  std::vector<PartId> neighbors;                       ///< parts with a copy of anything here, ascending
};

/// A part with its boundary.
struct Part {
  PartMesh mesh;
  PartBoundary boundary;
};

struct FieldInfo {
  std::string name;
  int components = 1;
};

/// A mesh in `part_count` parts, those of this rank in memory. All ranks hold the same number of parts and the same
/// fields; parts may be empty.
///
/// Invariants, checked by validate_parts: links name each other from both sides; copies agree in global id,
/// coordinates and classification; all parts together are one conforming mesh.
struct PartitionedMesh {
  PartitionedMesh(Communicator& given, std::size_t part_count)
      : communicator(&given), parts(part_count, given.parts_of_rank(part_count)) {}

  std::size_t part_count() const { return parts.part_count(); }
  std::span<const PartId> local() const { return parts.local(); }

  Communicator* communicator;
  PerPart<Part> parts;
  std::vector<FieldInfo> vertex_fields, cell_fields;  ///< of every part, in this order
};

/// Links between neighbours; valid as long as `mesh` is.
Links links_of_neighbors(const PartitionedMesh& mesh);

/// Finds all copies anew from the global ids of vertices: everything in `PartBoundary`. A collective call.
/// Vertices on open faces meet at a home rank that follows from their global id; neighbours then match their lists of
/// shared vertices, edges and faces, which are ordered alike on both sides (the rendezvous of Tautges et al. 2012
/// finds vertices in the same way; edges and faces need no rendezvous then).
void link_parts(PartitionedMesh& mesh, const TaskRunner& runner, Trace* trace = nullptr);

}  // namespace tetloom
