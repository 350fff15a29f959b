#pragma once
// What a STEP reader leaves undone is done here, face by face, and body by body only where that does not suffice.
// Private to core/cad.
#include "core/cad/detail/document.hpp"

namespace tetloom::cad {

/// Completes the raw bodies of a document. A face that is valid as it was read stays as it is; every other one is
/// completed on its own, all faces side by side; ShapeFix sees a whole body only when some face of it, or how they hang
/// together, is not valid then. Names and colours follow the shapes. Notes the bodies that are valid now.
void fix_raw_bodies(Document& document, const CancelToken* cancel, const BlockLoop& loop);

}  // namespace tetloom::cad
