#pragma once
// From facets in any state to a geometric model. Private to core/discrete.
#include "core/discrete/facet_soup.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// Fills everything of the document but `format`. Errors: as read_discrete_model.
ModelDocument build_discrete_model(FacetSoup&& soup, const ReadOptions& options, const CancelToken* cancel);

}  // namespace tetloom::detail
