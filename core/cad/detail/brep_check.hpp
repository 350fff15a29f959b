#pragma once
// Is a BREP file whole and consistent? Private to core/cad.
//
// OpenCASCADE's reader indexes its tables with whatever stands in the file and writes complaints to standard output.
// So the whole grammar is walked before: every table as long as announced, every number a number, every reference
// inside its table, every spline with fitting poles, knots and multiplicities. The grammar is that of OpenCASCADE's
// "BREP Format" document, versions 1 to 3.
#include <string>

namespace tetloom::cad {

/// What is wrong with the text of a BREP file, for a person; empty when nothing is. `shape_count` becomes the number of
/// shapes that it announces.
std::string find_brep_damage(const std::string& text, std::size_t& shape_count);

}  // namespace tetloom::cad
