#pragma once
// A mesh while it is optimised: the quality of every tet beside it, and the one operation that replaces tets by others.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/tets/edge_ring.hpp"
#include "core/tets/tet_editor.hpp"
#include "core/tets/tet_mesh.hpp"
#include "core/tets/tet_quality.hpp"

namespace tetloom::tets {

/// Two fixed faces that give way to two others: a diagonal of four points of the surface is exchanged.
struct SurfaceSwap {
  std::array<std::array<std::uint32_t, 3>, 2> before, after;
};

/// What is replaced on one side of a surface; nothing where nothing lies.
struct CavitySide {
  std::span<const std::uint32_t> old;
  std::span<const NewTet> made;
};

/// Invariant between two calls: to_quality[t] is the cubed quality of tet t in single precision, kDeadQuality for a
/// dead one.
class WorkingMesh {
 public:
  static constexpr float kDeadQuality = tets::kDeadQuality;
  static constexpr std::size_t kMostTets = 128;  // of a cavity, old or new

  /// The first `alike` tets are taken to have the quality of the first one, no fixed faces, and none with nothing
  /// behind them but `open_faces`.
  WorkingMesh(TetMesh& mesh, std::uint32_t fixed_points, std::uint32_t alike = 0,
              std::span<const FaceCode> open_faces = {});

  /// A mesh to be looked at only, whose qualities are known: kDeadQuality for dead tets.
  WorkingMesh(TetMesh& mesh, GrowingArray<float>&& qualities);
  /// For a mesh to be looked at only: no point counts as fixed before.
  void find_fixed_points();

  TetMesh& mesh() { return mesh_; }
  const TetMesh& mesh() const { return mesh_; }
  /// Whether `vertex` is one of the given surface, or lies on a face that has to stay or that has nothing behind it.
  bool is_fixed_point(std::uint32_t vertex) const { return (fixed_[vertex / 64] >> vertex % 64 & 1) != 0; }

  const Vec3& point(std::uint32_t vertex) const { return mesh_.points[vertex]; }
  std::span<const std::uint32_t, 4> verts(std::uint32_t tet) const {
    return std::span<const std::uint32_t, 4>(&mesh_.to_vert[std::size_t{tet} * 4], 4);
  }
  float quality(std::uint32_t tet) const { return to_quality_[tet]; }
  void set_quality(std::uint32_t tet, double quality) { to_quality_[tet] = static_cast<float>(quality); }
  std::span<float> qualities() { return to_quality_; }
  /// The corner of `tet` at which `vertex` is. Pre: it is one.
  std::uint32_t corner_of(std::uint32_t tet, std::uint32_t vertex) const { return tets::corner_of(mesh_, tet, vertex); }

  /// Fetches what a visit of `tet` reads first.
  void prefetch(std::uint32_t tet) const {
    __builtin_prefetch(&mesh_.to_vert[std::size_t{tet} * 4]);
    __builtin_prefetch(&mesh_.to_neighbor[std::size_t{tet} * 4]);
  }

  /// Fetches the same of its neighbours.
  void prefetch_neighbors(std::uint32_t tet) const {
    for (std::uint32_t i = 0; i < 4; ++i) {
      const FaceCode behind = mesh_.behind({tet, i});
      if (!behind.valid()) continue;
      prefetch(behind.tet());
      __builtin_prefetch(&to_quality_[behind.tet()]);
    }
  }

  void prefetch_point(std::uint32_t vertex) const { __builtin_prefetch(&mesh_.points[vertex]); }

  /// Replaces the tets `old` of one region by `made`, which fill the same space. New tets take the ids of old ones in
  /// ascending order, then those of dead tets, then new ones. Pre: neither list is longer than kMostTets; no face
  /// inside the cavity is fixed. Post: neighbours, fixed faces, regions and qualities are right.
  void replace(std::span<const std::uint32_t> old, std::span<const NewTet> made);

  /// The same for the tets around an edge inside of one region and those over a triangulation of its ring.
  void replace_ring(const EdgeRing& ring, std::span<const RingTriangle> triangles);

  /// The same for two tets with a common face, (t, face) and the one behind it: three take their place, around the line
  /// between the vertices opposite to the face. `qualities`: of that over the edge opposite to the first of kFaceVerts,
  /// and so on. Pre: the face is not fixed, the line passes through it.
  void replace_face(std::uint32_t tet, std::uint32_t face, const std::array<double, 3>& qualities);

  /// The same on both sides of a surface at once, where two of its triangles are exchanged: they alone, of the fixed
  /// faces, may lie inside the cavity. Each side is of one region; a side may be filled by nothing, the surface then
  /// passes to the tets behind it.
  void replace_at_surface(const SurfaceSwap& swap, const std::array<CavitySide, 2>& sides);

  /// Adds a point, or takes the place of one that was given up.
  std::uint32_t add_point(const Vec3& point);
  /// No tet may have `vertex` any more.
  void give_up_point(std::uint32_t vertex) { unused_points_.push_back(vertex); }

  /// Drops dead tets and, unless they are kept, points that were given up: the last ones take their places.
  void finish(bool keep_points = false);
  /// Gives the qualities of what is left away; the mesh is not to be worked on any more. Pre: finished.
  GrowingArray<float> take_qualities() { return std::move(to_quality_); }

 private:
  void read_tet(std::uint32_t tet);
  void fix_points_of(std::uint32_t tet);
  std::vector<std::uint32_t> find_dead() const;  // ascending
  void set_fixed_point(std::uint32_t vertex) { fixed_[vertex / 64] |= std::uint64_t{1} << vertex % 64; }

  TetMesh& mesh_;
  TetEditor editor_;
  GrowingArray<float> to_quality_;
  GrowingArray<std::uint64_t> fixed_;  // a bit per point
  GrowingArray<std::uint32_t> unused_points_;
};

}  // namespace tetloom::tets
