#pragma once
// Complexes on their way to a volume in parts.
#include "mesher/volume/fill_complex.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

/// Where `filled` has been filled in one part, that becomes the only one of `filled.parts`.
void keep_as_parts(const Complex& complex, FilledComplex& filled);

/// From numbers of the complex to those of the input; new points from `first_new` on.
void to_numbers_of_input(const Complex& complex, std::uint64_t first_new, std::span<VolumePart> parts,
                         const TaskRunner& runner);

}  // namespace tetloom::volume
