#pragma once
// Where the ratios at the corners of an octree's leaves lie. Private to core/sizing and mesher/sizing.
#include <array>
#include <cstddef>
#include <cstdint>

#include "tetloom/size_field.hpp"

namespace tetloom {

/// Of the 27 corners of a block's cells, counted along x, then y, then z: corner `corner` of cell `octant`.
constexpr std::size_t corner_in_block(std::size_t octant, std::size_t corner) {
  const auto along = [&](std::size_t axis) { return (octant >> axis & 1) + (corner >> axis & 1); };
  return along(0) + 3 * along(1) + 9 * along(2);
}

/// The corners of a block's leaves that have sizes of their own.
struct StoredCorners {
  static constexpr std::size_t kInBlock = 27;

  std::uint8_t count = 0;                               ///< corners, each once
  std::array<std::array<std::uint8_t, 8>, 8> places{};  ///< of each cell's corners among them
  std::array<std::uint8_t, kInBlock> in_block{};        ///< of the 27, the first `count` count; ascending
};

/// For each set of such leaves, a bit for each octant.
inline constexpr std::array<StoredCorners, 256> kStoredCorners = [] {
  std::array<StoredCorners, 256> all{};
  for (std::size_t leaves = 0; leaves < all.size(); ++leaves) {
    std::array<bool, StoredCorners::kInBlock> is_stored{};
    for (std::size_t octant = 0; octant < 8; ++octant)
      for (std::size_t corner = 0; corner < 8; ++corner)
        if (leaves >> octant & 1) is_stored[corner_in_block(octant, corner)] = true;
    std::array<std::uint8_t, StoredCorners::kInBlock> places{};
    for (std::size_t i = 0; i < is_stored.size(); ++i) {
      places[i] = all[leaves].count;
      if (is_stored[i]) all[leaves].in_block[all[leaves].count++] = static_cast<std::uint8_t>(i);
    }
    for (std::size_t octant = 0; octant < 8; ++octant)
      for (std::size_t corner = 0; corner < 8; ++corner)
        all[leaves].places[octant][corner] = places[corner_in_block(octant, corner)];
  }
  return all;
}();

constexpr bool is_sized_leaf(std::uint32_t code) {
  return code >= SizeOctree::kLeafBit && code != SizeOctree::kGlobalLeaf;
}

/// Of the eight cells of a block, by their codes.
inline const StoredCorners& stored_corners(const std::uint32_t* cells) {
  std::size_t leaves = 0;
  for (std::size_t octant = 0; octant < 8; ++octant)
    leaves |= static_cast<std::size_t>(is_sized_leaf(cells[octant])) << octant;
  return kStoredCorners[leaves];
}

}  // namespace tetloom
