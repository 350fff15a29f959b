#include "core/discrete/discrete_builder.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <sstream>
#include <utility>

#include "core/discrete/facet_model.hpp"
#include "core/discrete/open_rims.hpp"

namespace tetloom::detail {
namespace {

/// Counts the edges for which `holds`, and warns with the middle of the first one.
template <class Predicate>
void warn_of_edges(const FacetSurface& surface, ErrorCode code, const char* what, ModelDocument& document,
                   Predicate&& holds) {
  std::size_t count = 0, first = 0;
  for (std::size_t edge = 0; edge < surface.edges.size(); ++edge) {
    if (!holds(edge)) continue;
    if (count++ == 0) first = edge;
  }
  if (count == 0) return;
  const auto& ends = surface.edges.edge_to_vert[first];
  const Vec3 middle = 0.5 * (surface.points[ends[0]] + surface.points[ends[1]]);
  document.warnings.push_back({code, std::to_string(count) + what, {}, middle, {}});
}

/// Where the surface is open: how many edges in how many rims, and the widest of them.
void warn_of_open_rims(const FacetSurface& surface, ModelDocument& document) {
  const std::vector<OpenRim> rims = find_open_rims(surface.points, surface.edges);
  if (rims.empty()) return;
  const auto widest = std::ranges::max_element(rims, {}, &OpenRim::width);
  std::size_t count = 0;
  for (const OpenRim& rim : rims) count += rim.edges;
  std::ostringstream message;
  message << count << " facet edges are open, in " << rims.size() << (rims.size() == 1 ? " rim " : " rims up to ")
          << widest->width << " wide: the surface there bounds no region";
  document.warnings.push_back({ErrorCode::OpenShell, message.str(), {}, widest->point, {}});
}

void warn_of_irregular_edges(const FacetSurface& surface, ModelDocument& document) {
  const auto facets = [&](std::size_t edge) { return surface.edges.halves(edge).size(); };
  warn_of_open_rims(surface, document);
  warn_of_edges(surface, ErrorCode::InputUnsuitable, " facet edges cut a one-sided surface open", document,
                [&](std::size_t edge) { return facets(edge) == 2 && !surface.edge_is_joint[edge]; });
}

void check_feature_angle(double angle) {
  if (angle > 0 && angle <= std::numbers::pi) return;
  throw Error(ErrorCode::InvalidArgument, "the feature angle must lie between 0 and pi");
}

}  // namespace

ModelDocument build_discrete_model(FacetSoup&& soup, const ReadOptions& options, const CancelToken* cancel) {
  check_feature_angle(options.feature_angle);
  if (!(options.fill_holes >= 0))
    throw Error(ErrorCode::InvalidArgument, "the width of holes to fill must not be negative");
  ModelDocument document;
  for (const std::string& remark : soup.remarks) {
    document.warnings.push_back({ErrorCode::InputUnsuitable, remark, {}, {}, {}});
  }
  std::vector<std::string> group_names = std::move(soup.group_names);
  document.healing = clean_soup(soup, options.fill_holes, cancel);
  std::vector<bool> turned_over;
  FacetSurface surface = orient_facets(std::move(soup), turned_over);
  check_cancelled(cancel);
  FacetRegions regions = find_regions(surface);
  turn_leaves_over(surface, regions.turn, turned_over);
  check_cancelled(cancel);
  const auto turned = static_cast<std::size_t>(std::count(turned_over.begin(), turned_over.end(), true));
  if (turned > 0) document.healing.push_back({"facets turned over", turned});
  std::move(regions.warnings.begin(), regions.warnings.end(), std::back_inserter(document.warnings));
  warn_of_irregular_edges(surface, document);
  auto parts = std::make_shared<const DiscreteParts>(std::move(surface), options.feature_angle);
  check_cancelled(cancel);
  document.model = std::make_unique<FacetModel>(std::move(parts), regions, std::move(group_names), options);
  return document;
}

}  // namespace tetloom::detail
