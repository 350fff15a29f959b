#pragma once
// Are the splines of an IGES file whole? Private to core/cad.
#include <string>

namespace tetloom::cad {

/// What is wrong with the rational B-splines (entities 126 and 128) in the text of an IGES file, for a person; empty
/// when nothing is. OpenCASCADE allocates by the counts in the file and reads on, whatever follows.
std::string find_iges_damage(const std::string& text);

}  // namespace tetloom::cad
