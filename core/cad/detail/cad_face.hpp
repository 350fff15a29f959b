#pragma once
// One face of an OpenCASCADE shape as a FaceGeometry. Private to core/cad.
#include <Geom2dAdaptor_Curve.hxx>
#include <memory>
#include <vector>

#include "core/cad/detail/face_shape.hpp"
#include "core/cad/detail/surface_evaluator.hpp"
#include "tetloom/model.hpp"

namespace tetloom::cad {

/// A direction of a parametrisation counts as collapsed when crossing the whole box along it moves less than this share
/// of the face's size.
inline constexpr double kCollapsed = 1e-9;

/// A trimmed surface of OpenCASCADE's as the model's face.
class CadFace final : public FaceGeometry {
 public:
  /// `topology` belongs to the model and outlives this. Errors: FaceFailed.
  CadFace(std::shared_ptr<const FaceShape> shape, const ModelTopology& topology, ModelFaceId id, NamedEntity who);

  /// Another one of the same face, which shares nothing mutable with this: much cheaper than to look at the shape
  /// again, above all where parameter curves on planes have to be made. Thread safety: any number of threads, while
  /// nobody else uses this. Errors: FaceFailed.
  std::unique_ptr<CadFace> another() const;

  Parametrization parametrization() override { return Parametrization::Smooth; }
  ParameterBox parameter_box() override { return box_; }
  Vec2 period() override { return period_; }
  Vec3 evaluate(const Vec2& uv) override;
  SurfaceDerivatives derivatives(const Vec2& uv) override;
  Vec3 normal(const Vec2& uv) override;
  PrincipalCurvatures curvature(const Vec2& uv) override;
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) override;
  Vec2 edge_parameters(const EdgeUse& use, double t) override;
  ParameterRange edge_range(const EdgeUse& use) override;
  Tessellation tessellate(double chord, double angle) override;

 private:
  /// The parameter curve of one side of an edge, with the affine map from the edge's t to the curve's.
  struct ParameterCurve {
    EdgeUse use;
    Geom2dAdaptor_Curve curve;
    ParameterRange range;  ///< of the edge's t
    double scale = 1, shift = 0;
  };
  struct Descent {
    SurfacePoint found;
    bool converged = false;
  };

  CadFace(const CadFace& other);

  ParameterCurve& parameter_curve(const EdgeUse& use);
  ParameterCurve make_parameter_curve(const EdgeUse& use) const;
  void find_box();
  Vec2 pull_inside(const Vec2& uv, double share) const;
  Vec3 limit_normal(const Vec2& uv);
  Vec2 into_box(Vec2 uv) const;
  Descent descend(const Vec3& x, Vec2 start);
  Descent descend_past_poles(const Vec3& x, const Vec2& start);
  std::optional<Vec2> way_from_pole(const Vec3& x, const Vec2& uv);
  SurfacePoint search(const Vec3& x);
  void make_samples();
  int samples_along(bool u, int pieces);
  bool is_least_around(int i, int j) const;
  Vec2 at_share(double u, double v) const;

  std::shared_ptr<const FaceShape> shape_;
  const ModelTopology& topology_;
  ModelFaceId id_;
  NamedEntity who_;
  Handle(Geom_Surface) geometry_;  ///< untrimmed
  std::unique_ptr<SurfaceEvaluator> surface_;
  ParameterBox box_, search_box_;
  Vec2 period_;
  double length_scale_ = 1;  ///< about the face's size, for tolerances
  std::vector<ParameterCurve> curves_;
  std::vector<Vec2> sample_uv_;  ///< a grid over the box; empty until the first search
  std::vector<Vec3> samples_;
  std::vector<double> sample_values_;  ///< squared distances of the current search
  std::array<int, 2> sample_count_{};
};

}  // namespace tetloom::cad
