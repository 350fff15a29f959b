#pragma once
// Numbers of vertices and tets in the whole mesh, of which no rank has more than its share: 64 bits.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/base/first_number.hpp"
#include "core/tets/face_code.hpp"

namespace tetloom::adapt {

using tets::FaceCode;

/// A vertex or a tet in the whole mesh. Each rank has consecutive numbers of tets.
using Number = std::uint64_t;

inline constexpr Number kNoNumber = ~Number{0};

/// The number of the first item of each rank, where all have about equally many, and one past the last.
inline std::vector<Number> equal_ranges(std::size_t count, std::size_t ranks) {
  std::vector<Number> firsts;
  for (std::size_t rank = 0; rank <= ranks; ++rank) firsts.push_back(first_number() + count * rank / ranks);
  return firsts;
}

/// The rank that has a number; `firsts` as of equal_ranges.
inline std::size_t rank_in(const std::vector<Number>& firsts, Number number) {
  return static_cast<std::size_t>(std::ranges::upper_bound(firsts, number) - firsts.begin()) - 1;
}

/// A face of a tet that lies on another rank.
struct RemoteFace {
  std::uint32_t rank = kNone;
  FaceCode face;  ///< there
  bool valid() const { return face.valid(); }
  friend auto operator<=>(const RemoteFace&, const RemoteFace&) = default;
};

}  // namespace tetloom::adapt
