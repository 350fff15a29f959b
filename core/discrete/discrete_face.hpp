#pragma once
// A model face of a discrete model. Private to core/discrete.
#include <memory>
#include <vector>

#include "core/discrete/face_facets.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// (u,v) as tetloom/model.hpp defines them. Values outside of a facet are brought to its border.
class DiscreteFace final : public FaceGeometry {
 public:
  /// `edge_lengths`: of all edges of the model.
  DiscreteFace(std::shared_ptr<const FaceFacets> facets, std::shared_ptr<const std::vector<double>> edge_lengths);

  Parametrization parametrization() override { return Parametrization::Piecewise; }
  ParameterBox parameter_box() override;
  Vec2 period() override { return {}; }
  Vec3 evaluate(const Vec2& uv) override;
  SurfaceDerivatives derivatives(const Vec2& uv) override;
  Vec3 normal(const Vec2& uv) override;
  PrincipalCurvatures curvature(const Vec2& uv) override;
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) override;
  Vec2 edge_parameters(const EdgeUse& use, double t) override;
  ParameterRange edge_range(const EdgeUse& use) override;
  Tessellation tessellate(double chord, double angle) override;

 private:
  struct Place {
    std::uint32_t tri;
    double b0, b1, b2;
  };
  Place decode(const Vec2& uv) const;
  const Vec3& corner(const Place& place, int i) const { return facets_.points[facets_.tri_to_vert[place.tri][i]]; }

  std::shared_ptr<const FaceFacets> held_;
  const FaceFacets& facets_;
  std::shared_ptr<const std::vector<double>> edge_lengths_;
};

}  // namespace tetloom::detail
