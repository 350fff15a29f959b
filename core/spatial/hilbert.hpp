#pragma once
// Places along a Hilbert curve in three dimensions.
#include <cstddef>
#include <cstdint>
#include <span>

namespace tetloom {

/// Bits of each coordinate.
constexpr int kHilbertBits = 21;

/// The distance along the curve of the cell (x, y, z), each in [0, 2^21). Cells at distances n and n + 1 share a face.
/// After Hamilton & Rau-Chaplin 2008; see partition_sfc.
std::uint64_t hilbert_key(std::int64_t x, std::int64_t y, std::int64_t z);

/// How many of `cuts`, ascending keys, are not above the key of the cell: which piece of a curve that is cut there has
/// it. Looks at as many bits of the coordinates as that takes, a few for most cells.
std::size_t hilbert_piece(std::int64_t x, std::int64_t y, std::int64_t z, std::span<const std::uint64_t> cuts);

}  // namespace tetloom
