#pragma once
// Places for tets that are made: those of dead ones first, the last that died before the others.
#include <cstddef>
#include <cstdint>

#include "core/tets/tet_mesh.hpp"

namespace tetloom::tets {

/// Dead tets form a list through their first neighbour, so that nothing is allocated for them.
class TetPlaces {
 public:
  bool has_dead() const { return first_dead_ != kNone; }

  /// A tet with nothing in it, to be filled: a dead one, or one more.
  std::uint32_t take(TetMesh& mesh) {
    if (first_dead_ != kNone) {
      const std::uint32_t tet = first_dead_;
      first_dead_ = mesh.to_neighbor[std::size_t{tet} * 4];
      return tet;
    }
    const std::size_t tet = mesh.size();
    mesh.to_vert.resize_for_overwrite((tet + 1) * 4);
    mesh.to_neighbor.resize_for_overwrite((tet + 1) * 4);
    mesh.to_region.push_back(kNone);
    mesh.to_fixed.push_back(0);
    return static_cast<std::uint32_t>(tet);
  }

  /// The tet is dead now. Nothing may point to it, or what does is linked anew.
  void drop(TetMesh& mesh, std::uint32_t tet) {
    mesh.to_vert[std::size_t{tet} * 4] = kNone;
    mesh.to_neighbor[std::size_t{tet} * 4] = first_dead_;
    mesh.to_fixed[tet] = 0;
    first_dead_ = tet;
  }

  /// After `compact`: there are no dead ones any more.
  void forget() { first_dead_ = kNone; }

 private:
  std::uint32_t first_dead_ = kNone;
};

}  // namespace tetloom::tets
