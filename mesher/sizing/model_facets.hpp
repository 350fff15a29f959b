#pragma once
// The model as facets: what size sources are made of, and what rays are shot at. Private to mesher/sizing.
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/bad_geometry.hpp"
#include "core/spatial/bvh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// How closely facets follow their face.
struct FacetTolerance {
  double chord = 0;  ///< model length
  double angle = 0;  ///< radians
};

/// Facets of every face within its tolerance, in parallel. A face that cannot be facetted stays empty: whoever meshes
/// it reports it.
std::vector<Tessellation> facet_faces(const GeometricModel& model, const std::vector<FacetTolerance>& tolerances,
                                      const SharedWork& work);

/// Where a ray meets the model.
struct FacetHit {
  std::uint32_t face = 0;  ///< model face
  double distance = 0;
  Vec3 normal;                ///< unit, of the facet
  ModelRegionId near_region;  ///< on the side of the facet from which the ray came
};

/// All facets of a model in a hierarchy. Immutable after construction.
class FacetTree {
 public:
  FacetTree(const GeometricModel& model, const std::vector<Tessellation>& faces, const TaskRunner& runner);

  /// The first facet at a distance within (from, to) along the unit vector `direction`.
  std::optional<FacetHit> first_hit(const Vec3& origin, const Vec3& direction, double from, double to) const;

  /// Whether every face has facets, so that what is far from all facets is far from the model's surface.
  bool is_complete() const { return complete_; }

  /// Whether a facet meets the cube around `center`, `half_width` to each side.
  bool any_in(const Vec3& center, double half_width) const;

  /// The region that holds `x`; invalid outside of all. Decided by the first facet in several directions, so that the
  /// hairline gaps between the facets of different faces do not matter.
  ModelRegionId region_at(const Vec3& x) const;

 private:
  struct Facet {
    Vec3 a, b, c;
    std::uint32_t face;
  };

  const GeometricModel& model_;
  std::vector<Facet> facets_;  ///< in the order of the hierarchy
  Bvh bvh_;
  bool complete_ = true;
};

}  // namespace tetloom
