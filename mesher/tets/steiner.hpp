#pragma once
// Recovery of triangles that no reconnection reaches: points on them for a while, moved inside afterwards.
#include "mesher/tets/recoverer.hpp"

namespace tetloom::tets {

/// Which missing edges are made first. Sides of triangles first comes to an end more often; now and then a point inside
/// of a triangle makes others unnecessary.
enum class SteinerOrder : std::uint8_t { SidesFirst, PieceByPiece };

/// A triangle, or a piece of one that a point divided.
struct SurfacePiece {
  TriangleVerts verts;
  std::uint32_t root;  ///< the piece that is the whole triangle
  bool divided = false;
};

/// Pieces that a point divided and what they became, both running the same way round.
struct PieceSplit {
  std::uint32_t point;
  std::vector<std::uint32_t> parents;
  std::vector<std::vector<std::uint32_t>> children;  ///< one list per parent
};

/// Follows P. L. George, H. Borouchaki, E. Saltel, "'Ultimate' robustness in meshing an arbitrary polyhedron" (2003):
/// where an edge or a triangle is missing, what crosses it is split at the crossing, until its pieces are there; then
/// the points are taken off the surface again, the last one first: the ball of a point falls into sectors between the
/// surface's pieces, and each sector is filled anew with the undivided pieces, without the point where that is possible
/// and else with one inside the sector. Departs from the paper: the pieces are recovered by reconnections of small
/// polyhedra first, so that a point or two do for an edge, and the sectors' fillings are searched likewise; where a
/// sector has no filling, a larger cavity around the point has one perhaps. What still fails leaves no points behind,
/// as far as that is possible.
class SteinerRecovery {
 public:
  SteinerRecovery(LocalMesh& mesh, EdgeSet& kept, Recoverer& recoverer, const RecoverOptions& options)
      : mesh_(mesh), kept_(kept), recoverer_(recoverer), options_(options) {}

  /// Adds what is to be recovered. Pre: none of its missing edges belongs to a triangle that is not added.
  void add(const TriangleVerts& triangle);
  /// Whether all are there afterwards, not fixed yet. The mesh is without faults in any case. Once only.
  bool run(SteinerOrder order);

 private:
  void withdraw();
  void realize_sides(std::size_t splits_at_most);
  std::vector<std::uint32_t> pieces_at(std::uint32_t a, std::uint32_t b) const;
  bool is_inside(const std::vector<std::uint32_t>& parents) const;
  bool realize(std::uint32_t piece);
  bool split_edge(std::uint32_t a, std::uint32_t b);
  bool split_piece(std::uint32_t piece);
  void divide(const std::vector<std::uint32_t>& parents, std::uint32_t a, std::uint32_t b, std::uint32_t point);
  std::uint32_t add_piece(const TriangleVerts& verts, std::uint32_t root);
  bool undo(const PieceSplit& split);
  bool has_children(const PieceSplit& split) const;
  bool refill_sectors(const PieceSplit& split);
  void release_pieces();

  LocalMesh& mesh_;
  EdgeSet& kept_;
  Recoverer& recoverer_;
  const RecoverOptions& options_;
  std::vector<SurfacePiece> pieces_;
  std::vector<PieceSplit> splits_;
  std::vector<std::uint32_t> open_;  // pieces to be realised, the last one first
};

/// A point put on the mesh where an obstacle crosses the segment ab, or the triangle; kNone where none can be.
std::uint32_t split_obstacle(LocalMesh& mesh, const EdgeSet& kept, std::uint32_t a, std::uint32_t b,
                             const TetList& obstacles);
std::uint32_t split_obstacle(LocalMesh& mesh, const EdgeSet& kept, const TriangleVerts& triangle,
                             const TetList& obstacles);

/// A sector of the ball of a point: its outer faces and undivided pieces, counter-clockwise as seen from inside.
struct Sector {
  std::vector<TriangleVerts> faces;
};
/// Tets that fill a sector without `point`, or with a new point near it inside. Nothing where there are none.
std::optional<std::vector<Tet>> fill_sector(LocalMesh& mesh, const Sector& sector, std::uint32_t point,
                                            const RecoverOptions& options);

}  // namespace tetloom::tets
