#pragma once
// Which share of the mesh each rank has between two rounds, and how shares fit together. One rank has all of it.
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/parts/numbers.hpp"
#include "adapt/parts/whole_mesh.hpp"
#include "threading/comm/shared_work.hpp"
#include "threading/parts/residence.hpp"

namespace tetloom::adapt {

/// What connects the mesh that a rank has to those of the others. Tets have consecutive numbers in the whole mesh on
/// each rank; vertices that several ranks have are the same, bit for bit, on all of them.
struct ShareLinks {
  std::vector<Number> to_number;      ///< of every vertex; empty on a single rank: as they stand
  std::vector<std::uint32_t> shared;  ///< vertices that other ranks have as well, ascending
  std::vector<Number> first_tets;     ///< number of the first tet of each rank, and one past the last
  std::vector<Number> first_verts;    ///< the same of vertices, each with the lowest rank that has it; before the first
                                      ///< round no more than a range of numbers for each rank
  // Of the parts that this rank had in the last round, which stand one after the other: where those of each begin, and
  // how many there are. Vertices are counted with the first part that has them.
  std::vector<std::size_t> part_tets{0}, part_verts{0};

  Number number_of(std::uint32_t vert) const {
    return to_number.empty() ? first_verts.front() + vert : to_number[vert];
  }
  std::size_t tet_count() const { return first_tets.back() - first_tets.front(); }  ///< of the whole mesh
};

/// A face between two ranks.
struct FaceOutside {
  FaceCode face;      ///< here
  RemoteFace behind;  ///< the same face of the tet behind it
  friend auto operator<=>(const FaceOutside&, const FaceOutside&) = default;
};

/// Makes the whole mesh the share of a single rank: points that no tet has go, and with them links through faces.
ShareLinks take_share(WholeMesh& whole);

/// Keeps the slice's own tets of the mesh that it has become, with links. `faces`: those that other ranks have
/// something behind, ascending.
ShareLinks take_share(WholeMesh& slice_mesh, const MeshSlice& slice, std::vector<FaceOutside>& faces);

/// A share with all tets of the parts that a rank adapts in one round.
struct RoundShare {
  WholeMesh mesh;                       ///< until it is cut
  std::size_t vert_count = 0;           ///< of the mesh
  GrowingArray<std::uint32_t> to_part;  ///< of its tets, which are ascending in number
  std::vector<Number> to_number;        ///< as of ShareLinks
  Residence outside;                    ///< of its vertices on other ranks: there is a part for each rank
};

/// The rank that adapts a part: in blocks, as Communicator::rank_of.
int rank_of_part(std::uint32_t part, std::size_t part_count, int rank_count);

/// Sends every tet to the rank of its part, with all that it has. `share` and `links` are emptied. In together.
RoundShare move_tets(WholeMesh& share, ShareLinks& links, GrowingArray<std::uint32_t> to_part, std::size_t part_count,
                     const SharedWork& work);

/// How many of its vertices this rank has numbered: those before all that lower ranks have as well.
inline std::size_t own_vert_count(const ShareLinks& links, int rank) {
  const auto r = static_cast<std::size_t>(rank);
  return links.first_verts[r + 1] - links.first_verts[r];
}

/// The whole mesh on rank 0, with triangles as parts have them, without hints and states; an empty one on the others.
/// `share` is emptied. In together, after a round. Errors: OutOfMemory for more tets than one mesh may have.
WholeMesh gather_shares(WholeMesh& share, const ShareLinks& links, const SharedWork& work);

}  // namespace tetloom::adapt
