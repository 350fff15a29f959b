#pragma once
// What the tetrahedra of a mesh are to reach, and how long to try.
#include "tetloom/filling.hpp"

namespace tetloom {

/// Throws Error(InvalidArgument) for values out of range.
void check_goals(const QualityGoals& goals);

}  // namespace tetloom
