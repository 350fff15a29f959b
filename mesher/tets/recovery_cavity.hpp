#pragma once
// A few tets of the mesh as a small polyhedron, to be filled anew with a wanted edge or triangle.
#include <optional>
#include <unordered_set>

#include "core/tets/local_mesh.hpp"
#include "mesher/tets/recovery.hpp"
#include "mesher/tets/small_polyhedron.hpp"

namespace tetloom::tets {

/// Edges that must not be lost.
class EdgeSet {
 public:
  void insert(std::uint32_t a, std::uint32_t b) { keys_.insert(key(a, b)); }
  bool contains(std::uint32_t a, std::uint32_t b) const { return keys_.contains(key(a, b)); }

 private:
  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
  }
  std::unordered_set<std::uint64_t> keys_;
};

/// Tets that are to be replaced, and their outside as a small polyhedron.
struct RecoveryCavity {
  TetList tets;
  std::vector<std::uint32_t> to_vert;  ///< ascending
  std::vector<FaceCode> face_to_code;  ///< of the faces of `shape`, those of cavity tets; not valid for wanted ones
  SmallPolyhedron shape;

  std::uint8_t local(std::uint32_t vert) const;
};

/// Nothing where it has more than `points_at_most` points. Fixed faces inside and edges of `kept` inside become
/// constraints. Pre: the tets are connected and in one region.
std::optional<RecoveryCavity> make_cavity(const LocalMesh& mesh, const EdgeSet& kept, const TetList& tets,
                                          std::size_t points_at_most);

/// Demands an edge or a triangle between points of the cavity.
void demand(RecoveryCavity& cavity, std::uint32_t a, std::uint32_t b);
void demand(RecoveryCavity& cavity, const TriangleVerts& triangle);

/// Leaves a point inside of the cavity out, with the fixed faces and kept edges that end there. Pre: its whole ball is
/// in the cavity.
void leave_out(RecoveryCavity& cavity, std::uint32_t vert);

/// Fills the cavity anew.
void refill(LocalMesh& mesh, const RecoveryCavity& cavity, const SmallFilling& filling);

/// The cavity's tets and some behind the faces on which most fillings failed; the same tets where there are none.
TetList grown(const LocalMesh& mesh, const RecoveryCavity& cavity, const SmallFilling& filling);

}  // namespace tetloom::tets
