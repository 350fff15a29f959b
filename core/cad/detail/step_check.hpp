#pragma once
// Damage of a STEP file (ISO 10303-21) that OpenCASCADE's reader does not survive. Private to core/cad.
#include <string>
#include <string_view>

namespace tetloom::cad {

/// What is wrong with the instance names of `text`; empty: nothing. No two instances may have one name: OpenCASCADE 7.6
/// now and then never ends on such a file.
std::string find_step_damage(std::string_view text);

}  // namespace tetloom::cad
