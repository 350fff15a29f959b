#pragma once
// How much finer a surface may become where it does not fit its sizes, so that a few narrow places do not turn a small
// mesh into a huge one.
#include <vector>

#include "mesher/sizing/misfits.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom {

/// So many are no burden to anybody.
inline constexpr double kFewElements = 20'000;

/// The elements that a mesh may have after refinement where the sizes alone would give it `first`: `factor` times as
/// many, or kFewElements where that is more. Just `first` where the factor is 1.
double most_elements(double first, double factor);

/// What is refined within a budget.
struct AffordableMisfits {
  std::vector<Misfit> refined;  ///< in ascending order of triangles
  std::size_t left = 0;         ///< misfits that do not get the size that fits
  double cost = 0;              ///< of those refined, as estimated
};

/// The sizes that raise the narrowest places, in widths per size, as far as the budget allows, and no place further
/// than others need: places narrower than some share of the size, the same for all and at most kLeastWidth, are refined
/// until they have that share. `budget`: elements that may come in addition; what a size costs is estimated as a layer
/// of that size on its triangle. Complexity: O(n) for n misfits.
AffordableMisfits choose_affordable(const std::vector<Misfit>& misfits, const Mesh& surface, const SizeField& sizes,
                                    double budget);

}  // namespace tetloom
