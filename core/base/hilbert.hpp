#pragma once
// Places along a Hilbert curve in three dimensions.
#include <cstdint>

namespace tetloom {

/// Bits of each coordinate.
constexpr int kHilbertBits = 21;

/// The distance along the curve of the cell (x, y, z), each in [0, 2^21). Cells at distances n and n + 1 share a face.
/// After Hamilton & Rau-Chaplin 2008; see partition_sfc.
std::uint64_t hilbert_key(std::int64_t x, std::int64_t y, std::int64_t z);

}  // namespace tetloom
