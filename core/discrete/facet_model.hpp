#pragma once
// The geometric model of facets. Private to core/discrete.
#include <memory>
#include <string>
#include <vector>

#include "core/discrete/discrete_parts.hpp"
#include "core/discrete/facet_regions.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// A model over the parts of a facet surface, with what it was made with.
class FacetModel final : public GeometricModel {
 public:
  FacetModel(std::shared_ptr<const DiscreteParts> parts, const FacetRegions& regions,
             std::vector<std::string> group_names, const ReadOptions& options);

  Vec3 vertex_point(ModelVertexId id) const override;
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override;
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override;
  double area(ModelFaceId id) const override { return face_to_area_[id.value]; }
  double volume(ModelRegionId id) const override { return region_to_volume_[id.value]; }

  const DiscreteParts& parts() const { return *parts_; }
  const std::vector<std::string>& group_names() const { return group_names_; }
  const ReadOptions& options() const { return options_; }

 private:
  void set_topology(const FacetRegions& regions);
  void measure();
  void set_names();

  std::shared_ptr<const DiscreteParts> parts_;
  std::vector<std::string> group_names_;
  ReadOptions options_;
  std::vector<double> face_to_area_, region_to_volume_;
};

}  // namespace tetloom::detail
