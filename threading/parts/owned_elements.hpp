#pragma once
// Which part counts a boundary element that several parts have: its owner, the lowest of them.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/part/adjacency.hpp"
#include "tetloom/partition.hpp"

namespace tetloom {

/// Of one part, which must outlive it, and be linked.
class OwnedElements {
 public:
  OwnedElements(const Part& part, PartId self)
      : part_(part), self_(self), finder_(part.mesh), is_shared_(part.mesh.vertex_count(), false) {
    for (const std::uint32_t v : part.boundary.vertices.entities) is_shared_[v] = true;
  }

  /// Whether the part owns an edge, a triangle or a quadrilateral of its cells.
  template <std::size_t N>
  bool has(std::array<std::uint32_t, N> verts) {
    if (!std::ranges::all_of(verts, [&](std::uint32_t v) { return is_shared_[v]; })) return true;
    if constexpr (N == 2) {
      std::ranges::sort(verts);
      return owns(part_.boundary.edges, verts);
    } else {
      return owns(part_.boundary.faces, finder_.find_face(verts));
    }
  }

 private:
  template <class Entity>
  bool owns(const SharedEntities<Entity>& shared, const Entity& entity) const {
    const auto at = std::lower_bound(shared.entities.begin(), shared.entities.end(), entity);
    if (at == shared.entities.end() || *at != entity) return true;
    return owner_of(shared.copies_of(static_cast<std::size_t>(at - shared.entities.begin())), self_) == self_;
  }

  const Part& part_;
  const PartId self_;
  BallFinder finder_;
  std::vector<bool> is_shared_;
};

}  // namespace tetloom
