#include "core/discrete/discrete_builder.hpp"

#include <algorithm>
#include <iterator>
#include <numbers>
#include <sstream>
#include <utility>

#include "core/discrete/discrete_edge.hpp"
#include "core/discrete/discrete_face.hpp"
#include "core/discrete/discrete_parts.hpp"
#include "core/discrete/facet_regions.hpp"
#include "core/discrete/open_rims.hpp"

namespace tetloom::detail {
namespace {

class DiscreteModel final : public GeometricModel {
 public:
  DiscreteModel(std::shared_ptr<const DiscreteParts> parts, const FacetRegions& regions,
                const std::vector<std::string>& group_names)
      : parts_(std::move(parts)) {
    for (const Vec3& p : parts_->surface().points) bounding_box_.add(p);
    set_topology(regions);
    measure();
    for (int dim = 0; dim <= 3; ++dim) attributes_[dim].resize(topology_.count(dim));
    set_names(group_names);
  }

  Vec3 vertex_point(ModelVertexId id) const override {
    return parts_->surface().points[parts_->segmentation().model_vert_to_vert[id.value]];
  }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override {
    return std::make_unique<DiscreteEdge>(parts_, id.value);
  }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override {
    return std::make_unique<DiscreteFace>(parts_, id);
  }
  double area(ModelFaceId id) const override { return face_to_area_[id.value]; }
  double volume(ModelRegionId id) const override { return region_to_volume_[id.value]; }

 private:
  void set_topology(const FacetRegions& regions) {
    const Segmentation& segmentation = parts_->segmentation();
    topology_.vertex_count = segmentation.model_vert_to_vert.size();
    for (const auto& verts : segmentation.model_edge_to_verts) {
      const auto id = [&](std::uint32_t vert) { return ModelVertexId(segmentation.vert_to_model_vert[vert]); };
      topology_.edges.push_back({{id(verts.front()), id(verts.back())}, false});
    }
    topology_.face_to_loops = segmentation.face_to_loops;
    topology_.region_to_faces.resize(regions.region_count);
    for (std::uint32_t face = 0; face < segmentation.face_count; ++face) {
      const std::uint32_t leaf = parts_->surface().tri_to_leaf[parts_->members().of(face)[0]];
      const FaceSides sides = regions.leaf_to_sides[leaf];
      topology_.face_to_sides.push_back(sides);
      if (sides.back.valid()) topology_.region_to_faces[sides.back.value].push_back(ModelFaceId(face));
      if (sides.front.valid() && sides.front != sides.back) {
        topology_.region_to_faces[sides.front.value].push_back(ModelFaceId(face));
      }
    }
  }

  void measure() {
    const FacetSurface& surface = parts_->surface();
    const Vec3 center = bounding_box_.center();
    face_to_area_.assign(topology_.face_count(), 0);
    region_to_volume_.assign(topology_.region_count(), 0);
    for (std::size_t tri = 0; tri < surface.tri_to_vert.size(); ++tri) {
      const Triangle& t = surface.tri_to_vert[tri];
      const std::uint32_t face = parts_->segmentation().tri_to_face[tri];
      face_to_area_[face] += norm(facet_normal(surface.points, t)) / 2;
      const Vec3 a = surface.points[t[0]] - center, b = surface.points[t[1]] - center,
                 c = surface.points[t[2]] - center;
      const double volume = dot(a, cross(b, c)) / 6;
      const FaceSides& sides = topology_.face_to_sides[face];
      if (sides.back.valid()) region_to_volume_[sides.back.value] += volume;
      if (sides.front.valid()) region_to_volume_[sides.front.value] -= volume;
    }
  }

  void set_names(const std::vector<std::string>& names) {
    if (names.empty()) return;
    if (names.size() == 1) {
      for (EntityAttributes& region : attributes_[3]) region.name = names[0];
      if (attributes_[3].empty()) {
        for (EntityAttributes& face : attributes_[2]) face.name = names[0];
      }
      return;
    }
    for (std::uint32_t face = 0; face < topology_.face_count(); ++face) {
      attributes_[2][face].name = names[parts_->surface().group(parts_->members().of(face)[0])];
    }
    // A region whose faces all have one name has it too.
    for (std::size_t region = 0; region < topology_.region_count(); ++region) {
      const auto& faces = topology_.region_to_faces[region];
      const std::string& name = attributes_[2][faces[0].value].name;
      const bool alike = std::all_of(faces.begin(), faces.end(),
                                     [&](ModelFaceId face) { return attributes_[2][face.value].name == name; });
      if (alike) attributes_[3][region].name = name;
    }
  }

  std::shared_ptr<const DiscreteParts> parts_;
  std::vector<double> face_to_area_, region_to_volume_;
};

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
  const std::vector<std::string> group_names = std::move(soup.group_names);
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
  document.model = std::make_unique<DiscreteModel>(std::move(parts), regions, group_names);
  return document;
}

}  // namespace tetloom::detail
