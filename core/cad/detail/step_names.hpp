#pragma once
// Names of solids, faces, edges and vertices in STEP files. Private to core/cad.
#include <STEPCAFControl_Reader.hxx>
#include <string>
#include <TCollection_ExtendedString.hxx>

#include "core/cad/detail/document.hpp"

namespace tetloom::cad {

/// Adds the names that representation items (advanced_face, edge_curve, manifold_solid_brep …) have in the file to the
/// shapes that were made of them, in every instance. OpenCASCADE's own way (read.stepcaf.subshapes.name) runs into null
/// references of damaged files.
void add_step_names(const STEPCAFControl_Reader& reader, Document& document);

/// A name as valid UTF-8 without white space around it; empty for "NONE" and other names that say nothing.
std::string clean_name(const TCollection_ExtendedString& text);

}  // namespace tetloom::cad
