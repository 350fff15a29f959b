// Regions of facets whose boundary crosses itself, made anew from what they enclose.
#include <algorithm>
#include <utility>

#include "core/discrete/discrete_builder.hpp"
#include "core/discrete/facet_model.hpp"
#include "core/discrete/uncross.hpp"

namespace tetloom::detail {
namespace {

class RegionRebuilder {
 public:
  explicit RegionRebuilder(const FacetModel& model) : model_(model), surface_(model.parts().surface()) {
    soup_.points = surface_.points;
    soup_.group_names = model.group_names();
  }

  std::size_t rebuild(const std::vector<ModelRegionId>& regions, const CancelToken* cancel) {
    std::vector<bool> is_replaced(surface_.tri_to_vert.size(), false);
    std::size_t count = 0;
    for (const ModelRegionId region : regions) count += rebuild(region, is_replaced, cancel) ? 1 : 0;
    for (std::uint32_t tri = 0; tri < is_replaced.size(); ++tri)
      if (!is_replaced[tri]) add(surface_.tri_to_vert[tri], tri);
    return count;
  }

  FacetSoup take() { return std::move(soup_); }

 private:
  void add(const Triangle& verts, std::uint32_t tri) {
    soup_.tri_to_vert.push_back(verts);
    if (!surface_.tri_to_group.empty()) soup_.tri_to_group.push_back(surface_.tri_to_group[tri]);
  }

  // The facets that bound the region; none where one of its faces has something on its other side, or is missing.
  std::vector<std::uint32_t> boundary_of(ModelRegionId region) const {
    const ModelTopology& topology = model_.topology();
    std::vector<std::uint32_t> tris;
    if (region.value >= topology.region_count()) return tris;
    for (const ModelFaceId face : topology.region_to_faces[region.value]) {
      if (topology.face_to_sides[face.value].front.valid()) return {};
      for (const std::uint32_t tri : model_.parts().members().of(face.value)) tris.push_back(tri);
    }
    std::ranges::sort(tris);
    return tris;
  }

  bool rebuild(ModelRegionId region, std::vector<bool>& is_replaced, const CancelToken* cancel) {
    const std::vector<std::uint32_t> tris = boundary_of(region);
    if (tris.empty()) return false;
    std::vector<Triangle> verts;
    for (const std::uint32_t tri : tris) verts.push_back(surface_.tri_to_vert[tri]);
    const std::optional<UncrossedFacets> made = uncross_facets(surface_.points, verts, cancel);
    if (!made) return false;
    for (const std::uint32_t tri : tris) is_replaced[tri] = true;
    const auto first = static_cast<std::uint32_t>(soup_.points.size());
    soup_.points.insert(soup_.points.end(), made->points.begin(), made->points.end());
    for (std::size_t t = 0; t < made->tris.size(); ++t) {
      const auto& [a, b, c] = made->tris[t];
      add({first + a, first + b, first + c}, tris[made->tri_to_cut[t]]);
    }
    return true;
  }

  const FacetModel& model_;
  const FacetSurface& surface_;
  FacetSoup soup_;
};

}  // namespace

std::optional<ModelDocument> rebuild_regions(const ModelDocument& document, const std::vector<ModelRegionId>& regions,
                                             const CancelToken* cancel) {
  const auto* model = dynamic_cast<const FacetModel*>(document.model.get());
  if (model == nullptr || regions.empty()) return {};
  RegionRebuilder rebuilder(*model);
  const std::size_t count = rebuilder.rebuild(regions, cancel);
  if (count == 0) return {};
  ReadOptions options = model->options();
  options.fill_holes = 0;
  std::optional<ModelDocument> result;
  try {
    result = build_discrete_model(rebuilder.take(), options, cancel);
  } catch (const Error& error) {
    if (error.code() != ErrorCode::InputUnsuitable) throw;
    return {};
  }
  result->format = document.format;
  std::vector<HealingStep> healing = document.healing;
  healing.insert(healing.end(), result->healing.begin(), result->healing.end());
  healing.push_back({"solids that crossed themselves were made anew", count});
  result->healing = std::move(healing);
  return result;
}

}  // namespace tetloom::detail
