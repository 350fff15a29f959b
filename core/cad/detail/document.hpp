#pragma once
// What a STEP, IGES or BREP file holds, before anything is repaired or numbered. Private to core/cad.
#include <filesystem>
#include <TopoDS_Compound.hxx>
#include <TopTools_MapOfShape.hxx>
#include <vector>

#include "core/cad/detail/deferred_fixing.hpp"
#include "core/cad/detail/face_integrals.hpp"
#include "core/cad/detail/shape_attributes.hpp"
#include "core/cad/detail/tessellate.hpp"
#include "tetloom/host.hpp"

namespace tetloom::cad {

/// What a CAD file was read into.
struct Document {
  TopoDS_Compound root;  ///< the parts, each in its place
  AttributeMap attributes;
  double metres_per_unit = 0;
  std::vector<Diagnostic> warnings;
  KnownIntegrals integrals;         ///< of faces as they are now
  std::vector<RawBody> raw_bodies;  ///< of STEP files: what is still to be completed (see fix_raw_bodies)
  std::shared_ptr<SharedFacets> facets = std::make_shared<SharedFacets>();  ///< of the models made of this
  TopTools_MapOfShape valid_bodies;  ///< without their locations: those known to be valid as they are now
};

enum class CadFormat { Step, Iges, Brep };

/// Reads a file that a ReadingSession guards. Errors: InputUnreadable, InputUnsuitable, Cancelled.
Document read_document(const std::filesystem::path& path, CadFormat format, const CancelToken* cancel);

}  // namespace tetloom::cad
