#pragma once
// Solids that cross themselves, made anew. Private to core/cad.
#include "core/cad/detail/document.hpp"
#include "tetloom/model.hpp"

namespace tetloom::cad {

/// Replaces solids by the union with themselves: their faces are intersected with each other, the cells that these
/// enclose are found (BOPAlgo_MakerVolume), and the cells inside the old solid become the new ones. `solids` count as
/// the regions of a model. A solid of which no cell with volume is left stays as it is. Names and colours follow the
/// faces. Returns how many were replaced. Errors: Cancelled.
std::size_t rebuild_solids(Document& document, const std::vector<ModelRegionId>& solids, const CancelToken* cancel);

}  // namespace tetloom::cad
