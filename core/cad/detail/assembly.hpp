#pragma once
// The assembly tree of an XCAF document as one compound of placed parts with attributes. Private to core/cad.
#include <TDocStd_Document.hxx>

#include "core/cad/detail/document.hpp"

namespace tetloom::cad {

/// Places every instance of every part; instances of one part become shapes of their own. A part is named by its path
/// in the assembly ("gearbox/shaft"). metres_per_unit is left to the caller.
Document flatten_assembly(const Handle(TDocStd_Document) & document);

}  // namespace tetloom::cad
