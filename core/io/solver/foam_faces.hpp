#pragma once
// The order of faces in OpenFOAM's polyMesh: those between cells, then patches.
#include <cstdint>
#include <span>
#include <vector>

#include "core/io/solver/cell_faces.hpp"
#include "core/io/solver/groups.hpp"

namespace tetloom::detail {

/// A face of a cell that another part of the mesh has as well.
struct FoamSharedFace {
  std::uint32_t cell = 0;   ///< as CellFaces counts them
  std::uint32_t local = 0;  ///< of its faces
  std::uint32_t part = 0;   ///< the other one
};

/// Consecutive faces.
struct FoamRange {
  std::size_t first = 0, count = 0;
};

/// Numbers of faces are places in `faces`.
struct FoamFaces {
  struct Neighbour {
    std::uint32_t part;
    FoamRange range;
  };
  struct Zone {
    std::vector<std::uint32_t> faces;
    std::vector<std::uint8_t> flips;  ///< whether the face points against the zone
  };
  std::vector<std::uint32_t> faces;  ///< of the owners, in CellFaces
  std::size_t internal_count = 0;
  std::vector<FoamRange> patches;     ///< by group of faces; the last is that of faces in no group
  std::vector<Neighbour> neighbours;  ///< ascending by part
  std::vector<Zone> zones;            ///< by group of faces: those between cells, of other parts as well
};

/// Faces between cells come first, in upper-triangular order; then the patches of `groups`, in their order; then the
/// faces that part `part` shares with each other part, in an order that is the same on both sides where vertices stand
/// by global id on both. Of faces between parts, the higher part's points against the zone.
FoamFaces order_foam_faces(const CellFaces& faces, std::span<const Group> groups, std::uint32_t part,
                           std::span<const FoamSharedFace> shared);

}  // namespace tetloom::detail
