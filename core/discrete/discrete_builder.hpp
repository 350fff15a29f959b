#pragma once
// From facets in any state to a geometric model. Private to core/discrete.
#include <optional>
#include <vector>

#include "core/discrete/facet_soup.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// Fills everything of the document but `format`. Errors: as read_discrete_model.
ModelDocument build_discrete_model(FacetSoup&& soup, const ReadOptions& options, const CancelToken* cancel);

/// Of a model of facets, as `rebuild_solids`: regions whose boundary crosses itself and has nothing else on its other
/// side become what they enclose. Nothing where none of them could be changed, and for other models.
/// Errors: Cancelled.
std::optional<ModelDocument> rebuild_regions(const ModelDocument& document, const std::vector<ModelRegionId>& regions,
                                             const CancelToken* cancel);

}  // namespace tetloom::detail
