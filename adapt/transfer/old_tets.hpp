#pragma once
// The tets of the mesh as it was, with what is carried over from them.
#include <cstdint>
#include <span>

#include "adapt/metric/background.hpp"
#include "adapt/metric/background_tiles.hpp"
#include "adapt/transfer/cell_slopes.hpp"
#include "adapt/transfer/clip_tet.hpp"

namespace tetloom::adapt {

/// One of them. Non-owning.
struct OldTet {
  std::span<const Vec3> points;
  TetVerts verts;  ///< of `points`, in the order of their numbers in the whole mesh
  std::uint32_t region = 0;
  const double* values = nullptr;
  const Vec3* slopes = nullptr;  ///< none where tets have constants

  Corners corners() const { return corners_of(points, verts); }
};

/// All of them, by their names in the background. Refers to what it is made of. Thread safety: any number of threads.
class OldTets {
 public:
  /// Of a mesh in one piece. `slopes`: as of limited_slopes, or none. Pre: sizes fit, all values are finite.
  OldTets(const BackgroundMesh& mesh, std::span<const std::uint32_t> regions, const CellValues& cells,
          std::span<const Vec3> slopes = {})
      : mesh_(mesh), regions_(regions), cells_(cells), slopes_(slopes) {}
  /// Of a mesh in tiles; what is asked for may throw MissingTile.
  OldTets(const BackgroundMesh& mesh, const BackgroundTiles& tiles, std::size_t components)
      : mesh_(mesh), cells_{{}, components}, tiles_(&tiles) {}

  std::size_t components() const { return cells_.components; }
  OldTet operator[](BackgroundTet tet) const {
    if (tiles_ != nullptr) return in_tile(tet);
    const TetView mesh = mesh_.mesh();
    return {mesh.points, mesh.tets[tet], regions_[tet], cells_.of(tet),
            slopes_.empty() ? nullptr : slopes_.data() + tet * cells_.components};
  }
  BackgroundFace behind(BackgroundFace face) const { return mesh_.behind(face); }
  /// See BackgroundMesh::locate.
  BackgroundTet tet_at(const Vec3& x, BackgroundTet hint) const { return mesh_.locate(x, hint).tet; }

 private:
  OldTet in_tile(BackgroundTet tet) const {
    const auto [tile, place] = tiles_->find(tet);
    const auto& v = tile.to_vert[place];
    return {tile.points,
            {v[0], v[1], v[2], v[3]},
            tile.regions[place],
            tile.cells.data() + place * cells_.components,
            tile.slopes.empty() ? nullptr : tile.slopes.data() + place * cells_.components};
  }

  const BackgroundMesh& mesh_;
  std::span<const std::uint32_t> regions_;
  CellValues cells_;
  std::span<const Vec3> slopes_;
  const BackgroundTiles* tiles_ = nullptr;
};

}  // namespace tetloom::adapt
