#pragma once
// A face without a CAD kernel, for the benches of single steps: z = a sin(2πu) cos(2πv) over the unit square.
#include <cstdint>

#include "mesher/surface/patch.hpp"
#include "tetloom/model.hpp"

namespace tetloom::bench {

/// The surface over the unit square; its edges are those of the square and belong to no model.
class WavyFace final : public FaceGeometry {
 public:
  explicit WavyFace(double amplitude) : amplitude_(amplitude) {}
  Parametrization parametrization() override { return Parametrization::Smooth; }
  ParameterBox parameter_box() override { return {{0, 0}, {1, 1}}; }
  Vec2 period() override { return {0, 0}; }
  Vec3 evaluate(const Vec2& uv) override;
  SurfaceDerivatives derivatives(const Vec2& uv) override;
  Vec3 normal(const Vec2& uv) override;
  /// Throws Error(Internal): no step that is measured asks for the rest.
  PrincipalCurvatures curvature(const Vec2& uv) override;
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) override;
  Vec2 edge_parameters(const EdgeUse& use, double t) override;
  ParameterRange edge_range(const EdgeUse& use) override;
  Tessellation tessellate(double chord, double angle) override;

 private:
  double amplitude_;
};

/// The unit square's rim in pieces of about `size`, triangulated without inner points, as the frontal refinement wants
/// it.
Patch make_square_patch(const PatchSurface& surface, double size);

}  // namespace tetloom::bench
