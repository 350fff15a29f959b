#pragma once
// The sites of a lattice in blocks of 4 x 4 x 4 cubes, for looking at what is around each.
#include <array>
#include <cstdint>
#include <vector>

#include "mesher/lattice/lattice_points.hpp"

namespace tetloom::lattice {

/// Sites of a block stand by kind (LatticeShape::kind_of), z, y, x of their cube.
inline constexpr int kBlockWidth = 4, kBlockCubes = 64;
/// The same with a layer of cubes around the block.
inline constexpr int kPaddedWidth = 6, kPaddedCubes = 216;

/// Bits of one block's sites, by kind.
template <int Kinds>
using SiteBits = std::array<std::uint64_t, Kinds>;

template <int Kinds>
/// The sites of 4 x 4 x 4 cubes, with the blocks around.
struct SiteBlock {
  std::array<std::int32_t, 3> place;                       ///< in blocks
  std::array<std::uint32_t, Kinds * kBlockCubes> to_vert;  ///< kNone: no point
  SiteBits<Kinds> near_surface{};
  std::array<std::uint32_t, 27> around;  ///< blocks by z, y, x; kNone: no such block; 13 is the block itself
};

/// Index of a cube in its block.
constexpr int cube_index(int x, int y, int z) { return (z * kBlockWidth + y) * kBlockWidth + x; }
/// Index of a cube in a padded block; coordinates from -1 to 4.
constexpr int padded_index(int x, int y, int z) { return ((z + 1) * kPaddedWidth + y + 1) * kPaddedWidth + x + 1; }

/// Blocks in the order in which their first site stands. The vertex of site i is first_vert + i. Pre: the lattice has
/// Kinds sites per cube: 2 or 8.
template <int Kinds>
std::vector<SiteBlock<Kinds>> make_site_blocks(const LevelPoints& level, std::uint32_t first_vert);

/// Where a place of a padded block lies: in which block around, and at which cube there.
struct PaddedPlace {
  std::uint8_t around, cube;
};
constexpr std::array<PaddedPlace, kPaddedCubes> make_padded_places() {
  std::array<PaddedPlace, kPaddedCubes> places{};
  const auto block_of = [](int x) { return x < 0 ? 0 : x < kBlockWidth ? 1 : 2; };
  for (int z = -1; z <= kBlockWidth; ++z) {
    for (int y = -1; y <= kBlockWidth; ++y) {
      for (int x = -1; x <= kBlockWidth; ++x) {
        const int around = (block_of(z) * 3 + block_of(y)) * 3 + block_of(x);
        const int cube = cube_index(x & 3, y & 3, z & 3);
        places[padded_index(x, y, z)] = {static_cast<std::uint8_t>(around), static_cast<std::uint8_t>(cube)};
      }
    }
  }
  return places;
}
inline constexpr std::array<PaddedPlace, kPaddedCubes> kPaddedPlaces = make_padded_places();

}  // namespace tetloom::lattice
