#include "core/discrete/facet_model.hpp"

#include <algorithm>
#include <utility>

#include "core/discrete/discrete_edge.hpp"
#include "core/discrete/discrete_face.hpp"

namespace tetloom::detail {

FacetModel::FacetModel(std::shared_ptr<const DiscreteParts> parts, const FacetRegions& regions,
                       std::vector<std::string> group_names, const ReadOptions& options)
    : parts_(std::move(parts)), group_names_(std::move(group_names)), options_(options) {
  for (const Vec3& p : parts_->surface().points) bounding_box_.add(p);
  set_topology(regions);
  measure();
  for (int dim = 0; dim <= 3; ++dim) attributes_[dim].resize(topology_.count(dim));
  set_names();
}

Vec3 FacetModel::vertex_point(ModelVertexId id) const {
  return parts_->surface().points[parts_->segmentation().model_vert_to_vert[id.value]];
}

std::unique_ptr<EdgeGeometry> FacetModel::edge_geometry(ModelEdgeId id) const {
  return std::make_unique<DiscreteEdge>(std::shared_ptr<const Polyline>(parts_, &parts_->polyline(id.value)));
}

std::unique_ptr<FaceGeometry> FacetModel::face_geometry(ModelFaceId id) const {
  return std::make_unique<DiscreteFace>(std::shared_ptr<const FaceFacets>(parts_, &parts_->face(id.value)),
                                        std::shared_ptr<const std::vector<double>>(parts_, &parts_->edge_lengths()));
}

void FacetModel::set_topology(const FacetRegions& regions) {
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

void FacetModel::measure() {
  const FacetSurface& surface = parts_->surface();
  const Vec3 center = bounding_box_.center();
  face_to_area_.assign(topology_.face_count(), 0);
  region_to_volume_.assign(topology_.region_count(), 0);
  for (std::size_t tri = 0; tri < surface.tri_to_vert.size(); ++tri) {
    const Triangle& t = surface.tri_to_vert[tri];
    const std::uint32_t face = parts_->segmentation().tri_to_face[tri];
    face_to_area_[face] += norm(facet_normal(surface.points, t)) / 2;
    const Vec3 a = surface.points[t[0]] - center, b = surface.points[t[1]] - center, c = surface.points[t[2]] - center;
    const double volume = dot(a, cross(b, c)) / 6;
    const FaceSides& sides = topology_.face_to_sides[face];
    if (sides.back.valid()) region_to_volume_[sides.back.value] += volume;
    if (sides.front.valid()) region_to_volume_[sides.front.value] -= volume;
  }
}

void FacetModel::set_names() {
  const std::vector<std::string>& names = group_names_;
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

}  // namespace tetloom::detail
