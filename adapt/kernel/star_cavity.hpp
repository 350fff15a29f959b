#pragma once
// Collapses that need swaps first: the ball of the vertex that goes, with tets behind faces that the other end cannot
// see well, filled anew by the star of that end. Where the tets of a plain collapse would be inverted or too bad, this
// is the swap of such a face, or of an edge of it, and then the collapse (de Cougny & Shephard 1999b; as one cavity:
// Loseille & Löhner 2013).
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/kernel/cavity_mesh.hpp"

namespace tetloom::adapt {

/// A collapse as the star of the vertex that stays, in what is left of the ball of the one that goes.
class StarCavity {
 public:
  explicit StarCavity(CavityMesh& mesh) : mesh_(mesh) {}

  /// Whether the star of p can fill what is left when the core of `ball` goes, with tets better than `goal` in cubed
  /// quality, where a few tets around the ball may go as well. Pre: the ball of one vertex, inside of a region; p is
  /// another vertex of it.
  bool find(const Cavity& ball, std::uint32_t p, double goal);
  /// The vertices to which p will have an edge. Pre: found.
  std::span<const std::uint32_t> link() const { return link_; }
  /// Carries it out: the core has no tets any more. Pre: found, and nothing has changed since.
  void fill();

 private:
  // A tet that will be made: one that goes, with p in the place of a corner.
  struct Made {
    std::array<std::uint32_t, 4> verts;
    std::uint32_t corner;
    float quality;
  };
  // A side of what is made, or with kNone of what stays around it: two have the same edge opposite to p.
  struct Side {
    std::uint64_t edge;
    std::uint32_t made;
  };

  bool has(std::uint32_t tet) const { return marks_[tet] == mark_; }
  void add(std::uint32_t tet);
  bool collect(double goal);
  bool is_closed();

  CavityMesh& mesh_;
  std::uint32_t core_ = kNone, p_ = kNone;
  std::vector<std::uint32_t> tets_, bad_, link_;
  std::vector<Made> made_;
  std::vector<Side> sides_;
  std::vector<std::uint32_t> marks_, vert_marks_;
  std::uint32_t mark_ = 0;
};

}  // namespace tetloom::adapt
