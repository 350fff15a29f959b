#pragma once

#include <algorithm>
#include <cstddef>

namespace tetloom {

/// How many items one task of a loop takes, by what is done with an item. Handing out a task costs about a microsecond:
/// a task is to last a hundred times as long, and small meshes are still to give every thread one.
inline constexpr std::size_t kSearchGrain = std::size_t{1} << 8,  ///< a search in a tree, a fit: microseconds each
    kStarGrain = std::size_t{1} << 10,                            ///< a look at all elements around a vertex
    kElementGrain = std::size_t{1} << 12,                         ///< a computation with the vertices of one element
    kCopyGrain = std::size_t{1} << 14;                            ///< a copy, a comparison, a few operations

/// The grain of a loop over `count` items whose tasks have a table each: at most 256 tasks.
constexpr std::size_t grain_of_tables(std::size_t count, std::size_t least) { return std::max(least, count / 256 + 1); }

}  // namespace tetloom
