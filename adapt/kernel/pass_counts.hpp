#pragma once
// What passes did, and what they were refused.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tetloom::adapt {

/// What became of an attempt, in the order in which it is asked.
enum class Verdict : std::uint8_t {
  Done,
  Frozen,          ///< a vertex, edge or face that has to stay
  Classification,  ///< the model does not allow it
  TooLarge,        ///< more than Cavity::kMostTets tets
  Inverted,        ///< a tet would have no volume
  Quality,         ///< a tet would be worse than bearable
  Length,          ///< an edge would become too long or too short
  Surface,         ///< the surface would fold, leave the model or meet itself
  NoGain,
  Count
};
/// "done", "frozen" … in snake case, for reports.
std::string_view to_string(Verdict verdict);

/// How many attempts had each outcome.
using Verdicts = std::array<std::size_t, static_cast<std::size_t>(Verdict::Count)>;

struct PassCounts {
  Verdicts splits{}, collapses{}, swaps{}, moves{};
  std::size_t unled = 0;  ///< times that a vertex of the surface was not led all the way to the model

  void add(const PassCounts& other) {
    for (const auto counts : {&PassCounts::splits, &PassCounts::collapses, &PassCounts::swaps, &PassCounts::moves})
      for (std::size_t i = 0; i < splits.size(); ++i) (this->*counts)[i] += (other.*counts)[i];
    unled += other.unled;
  }
};

}  // namespace tetloom::adapt
