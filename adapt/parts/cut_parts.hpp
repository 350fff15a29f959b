#pragma once
// The parts of a rank's share of the mesh, to be changed but for what they share with others.
#include <cstdint>
#include <vector>

#include "adapt/parts/share.hpp"

namespace tetloom::adapt {

struct PartOfWhole {
  CavityMesh mesh;
  std::uint32_t given = 0;              ///< its vertices before this one are those of `to_whole`
  std::vector<std::uint32_t> to_whole;  ///< vertex of the share
};

/// Cuts parts out of a share. Different parts may be built by several threads at once.
class Cutter {
 public:
  /// `first` and `count`: the parts of this rank. `share` must outlive this.
  Cutter(const RoundShare& share, std::uint32_t first, std::uint32_t count);

  /// Whether parts share the vertex, here or on other ranks.
  bool is_shared(std::uint32_t vert) const { return owner_[vert] == kShared; }

  /// Part `first` + `number`; `part` is new.
  void build(std::uint32_t number, PartOfWhole& part);

 private:
  class Builder;
  static constexpr std::uint32_t kShared = kNone - 1;

  std::uint32_t part_of(std::uint32_t tet) const { return share_.to_part[tet] - first_; }

  const RoundShare& share_;
  std::uint32_t first_;
  std::vector<std::uint32_t> owner_;       // of every vertex: the part that has it, or that several do
  std::vector<std::uint32_t> local_tet_;   // place in its part
  std::vector<std::uint32_t> local_vert_;  // the same, of vertices that one part has; each is written by its own part
  std::vector<std::vector<std::uint32_t>> part_to_tets_, part_to_triangles_;
};

}  // namespace tetloom::adapt
