#pragma once
// The sites of a lattice in blocks of 4 x 4 x 4 cubes, for looking at what is around each.
#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "mesher/lattice/lattice_points.hpp"

namespace tetloom::lattice {

/// Sites of a block stand by half (0: corners of cubes, 1: their centres), z, y, x of their cube.
inline constexpr int kBlockWidth = 4, kBlockCubes = 64, kBlockSites = 2 * kBlockCubes;
/// The same with a layer of cubes around the block.
inline constexpr int kPaddedWidth = 6, kPaddedCubes = 216, kPaddedSites = 2 * kPaddedCubes;

/// Bits of one block's sites, by half.
using SiteBits = std::array<std::uint64_t, 2>;

struct SiteBlock {
  std::array<std::int32_t, 3> place;               ///< in blocks
  std::array<std::uint32_t, kBlockSites> to_vert;  ///< kNone: no point
  SiteBits near_surface{};
  std::array<std::uint32_t, 27> around;  ///< blocks by z, y, x; kNone: no such block; 13 is the block itself
};

/// Index of a cube in its block.
constexpr int cube_index(int x, int y, int z) { return (z * kBlockWidth + y) * kBlockWidth + x; }
/// Index of a cube in a padded block; coordinates from -1 to 4.
constexpr int padded_index(int x, int y, int z) { return ((z + 1) * kPaddedWidth + y + 1) * kPaddedWidth + x + 1; }

/// Blocks in the order in which their first site stands. The vertex of site i is first_vert + i.
std::vector<SiteBlock> make_site_blocks(const LevelPoints& level, std::uint32_t first_vert);

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

/// The 14 sites around a site of each half: half, and the step in cubes.
struct SiteStep {
  int half, x, y, z;
};
constexpr std::array<std::array<SiteStep, 14>, 2> make_site_steps() {
  std::array<std::array<SiteStep, 14>, 2> steps{};
  for (int half = 0; half < 2; ++half) {
    int count = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const auto step = [&](int bit) { return (corner >> bit & 1) - (half == 0 ? 1 : 0); };
      steps[half][count++] = {1 - half, step(0), step(1), step(2)};
    }
    for (int axis = 0; axis < 3; ++axis) {
      for (int side = -1; side <= 1; side += 2)
        steps[half][count++] = {half, axis == 0 ? side : 0, axis == 1 ? side : 0, axis == 2 ? side : 0};
    }
  }
  return steps;
}
inline constexpr std::array<std::array<SiteStep, 14>, 2> kSiteSteps = make_site_steps();

}  // namespace tetloom::lattice
