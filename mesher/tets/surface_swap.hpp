#pragma once
// Swaps edges of the surface inside of a model face, with the tets on both sides.
//
//          b                      On each side of the surface, the tets at the edge a-b form an open ring from p to q:
//        / | \   . r1             (a, b, p, r1), (a, b, r1, r2), ..., (a, b, rn, q). The polygon p, r1, ..., rn, q is
//       p--|--q      r2           closed by the new edge q-p; the best triangulation of it gives the new tets, as for
//        \ | /   '                edges inside. A ring of one tet vanishes: that is how a flat tet on the surface goes.
//          a
//
// Klincsek 1980 and Freitag & Ollivier-Gooch 1997 as in edge_removal.hpp; Li, Shephard & Beall 2005 swap on the surface
// in the same way, one side at a time.
#include "core/tets/ring_triangulation.hpp"
#include "core/tets/working_mesh.hpp"
#include "mesher/tets/surface_geometry.hpp"

namespace tetloom::tets {

/// In the order in which an edge is asked.
enum class SwapVerdict {
  NotOnSurface,   ///< no triangle of the surface has an edge of the tet
  OnModelEdge,    ///< the edge lies on an edge of the model, or has not two triangles of one model face
  EdgeExists,     ///< the surface has the other diagonal already
  LongRing,       ///< more tets on one side than there is room for
  NoGain,         ///< no triangulation raises the minimum of both sides, without more poor tets
  PoorTriangles,  ///< the triangles would be worse than before, and poor
  OffModel,       ///< the new edge would be too far from the model face, or a triangle turned against it
  Blocked,        ///< the surface is in its own way
  Swapped
};

/// Holds the room that one swap needs.
class SurfaceSwapper {
 public:
  /// Tets of cubed quality below `limit` count as poor.
  SurfaceSwapper(WorkingMesh& mesh, const ChangeableSurface& surface, SurfaceTriangles& triangles, double limit)
      : mesh_(mesh), surface_(surface), triangles_(triangles), limit_(limit) {}

  /// Swaps that edge of `tet` on the surface whose swap raises the minimum of the tets at it most, if there is one. The
  /// new tets are positive in exact arithmetic. Otherwise nothing changes, and the verdict is that of the edge that
  /// came farthest.
  SwapVerdict swap_edge_of(std::uint32_t tet);

 private:
  using Tets = std::array<NewTet, std::size_t{2} * kMostRingVerts>;
  struct Candidate {
    SurfaceTriangles::Diamond diamond;
    std::array<EdgeRing, 2> rings;  // open; `count` is that of their vertices, 0: nothing on that side
    std::array<Tets, 2> made;
    std::array<std::size_t, 2> made_counts{};
    double value = 0;  // the new minimum; 2 where nothing is left
  };

  SwapVerdict check_edge(std::uint32_t tet, std::size_t edge, double goal);
  SwapVerdict check_diamond(std::uint32_t a, std::uint32_t b);
  bool collect_rings(std::uint32_t tet, std::size_t edge);
  SwapVerdict triangulate(double goal);
  SwapVerdict check_shape() const;
  bool lies_in_plane() const;
  bool is_true_to_model() const;
  bool is_clear() const;
  void apply();

  WorkingMesh& mesh_;
  const ChangeableSurface& surface_;
  SurfaceTriangles& triangles_;
  double limit_;
  Candidate now_, best_;
};

}  // namespace tetloom::tets
