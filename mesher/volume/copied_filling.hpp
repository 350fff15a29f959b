#pragma once
// Complexes that are one shape in several places: filled once, then moved.
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "mesher/volume/complex.hpp"
#include "mesher/volume/fill_complex.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::volume {

/// What a complex is a copy of.
struct ComplexCopy {
  std::size_t original = 0;
  RigidMotion motion;  ///< from where that stands
};

/// Per complex, the first one that it is a copy of; none where that is itself. Copies have the same triangles in the
/// same order, with points that a motion takes to each other to a hundred millionth of the complex's diagonal, and
/// their surfaces may change in the same ways. In parallel.
std::vector<std::optional<ComplexCopy>> find_copies(const FillingPlan& plan, std::span<const Complex> complexes,
                                                    const TaskRunner& runner);

/// What `filled`, of the complex that `complex` is a copy of, is where the copy stands. Points of the surface that it
/// left where they were are those of `complex`. Figures are the same but for the seconds and the list of the worst
/// tets, which the original has. None where nothing was filled, where it says more than figures, where sizes differ, or
/// where rounding would turn a tet over.
std::optional<VolumeParts> copy_filled(const FillingPlan& plan, const VolumeParts& filled, const Complex& original,
                                       const Complex& complex, const RigidMotion& motion);

}  // namespace tetloom::volume
