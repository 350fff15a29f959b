#pragma once
// Loads STEP files from their records, with OpenCASCADE's parser for the unusual ones. Private to core/cad.
#include <StepSelect_WorkLibrary.hxx>

namespace tetloom::cad {

/// What a work session of OpenCASCADE reads STEP files with.
class StepLibrary : public StepSelect_WorkLibrary {
  DEFINE_STANDARD_RTTI_INLINE(StepLibrary, StepSelect_WorkLibrary)
 public:
  Standard_Integer ReadFile(const Standard_CString name, Handle(Interface_InterfaceModel) & model,
                            const Handle(Interface_Protocol) & protocol) const override;
};

}  // namespace tetloom::cad
