#pragma once
// Which rank knows all tets of a vertex of a mesh in slices, and what ranks tell each other of such vertices.
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/metric/own_verts.hpp"
#include "adapt/parts/mesh_slice.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// Every vertex has an owner: the lowest rank that has all of its tets. Collective, in SharedWork::together.
class VertexOwners {
 public:
  VertexOwners(const MeshSlice& slice, const SharedWork& work);

  /// Of some vertices, ascending.
  std::vector<std::uint32_t> of(std::span<const Number> numbers) const;

 private:
  std::size_t ranks() const { return static_cast<std::size_t>(work_.rank_count()); }
  void put_for_homes(std::span<const Number> numbers, std::span<MessageWriter> to) const;

  const SharedWork& work_;
  std::vector<Number> first_at_home_;   // a rank is the home of equally many vertices, by their numbers
  std::vector<std::uint32_t> at_home_;  // their owners
};

/// The vertices around a slice, which come from their owners.
class GhostLinks {
 public:
  /// Refers to the slice. In together.
  GhostLinks(const MeshSlice& slice, const VertexOwners& owners, const SharedWork& work);

  /// Brings values of `changed` vertices to all ranks around; returns the vertices that got one. In together.
  std::vector<std::uint32_t> refresh(std::span<const std::uint32_t> changed, std::vector<Tensor>& logs) const;
  /// Of the slice, for limit_gradation. Refers to this.
  OwnVerts own_verts() const;

 private:
  const MeshSlice& slice_;
  const SharedWork& work_;
  std::vector<std::vector<std::uint32_t>> taken_, given_;  // vertices that come from each rank, and go there
};

/// The place in the slice of a vertex that is there.
inline std::uint32_t vert_of(const MeshSlice& slice, Number number) {
  return static_cast<std::uint32_t>(std::ranges::lower_bound(slice.to_vert_number, number) -
                                    slice.to_vert_number.begin());
}

}  // namespace tetloom::adapt
