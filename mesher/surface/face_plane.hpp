#pragma once
// A face over the plane that fits its edges best: the way out where its own parametrisation is of no use, because it
// folds over or because the parameter curves are wrong.
#include <optional>

#include "mesher/surface/face_mesher.hpp"
#include "mesher/surface/face_rim.hpp"

namespace tetloom {

/// Orthonormal and right-handed, through the middle of the rim.
struct FittedPlane {
  Vec3 origin, first, second, normal;
  Vec2 to_plane(const Vec3& x) const { return {dot(x - origin, first), dot(x - origin, second)}; }
};

/// The plane normal to the vector area of the face's loops (Newell), which is on the side that the face has as its
/// front. None where the loops bound no area.
std::optional<FittedPlane> fit_plane(const ModelTopology& topology, ModelFaceId face, const RimNodes& rim);

/// The rim with every node where it stands over the plane. Degenerate edges and pieces that are run through up and
/// down are left out.
FaceRim trace_rim(const ModelTopology& topology, ModelFaceId face, const FittedPlane& plane, const RimNodes& rim);

/// The length of the rim where every piece is run through as often forward as backward; none where it bounds an area.
std::optional<double> length_of_cancelled_rim(const ModelTopology& topology, ModelFaceId face, const RimNodes& rim);

/// The geometry of a face with (u,v) in the plane: every point is the surface's point above or below it, as near to the
/// plane as there is one, or a point of the plane where there is none within `reach` (model length). Only what the
/// plane path of the face mesher asks for is answered: evaluate, derivatives and normal.
class FaceOverPlane : public FaceGeometry {
 public:
  FaceOverPlane(FaceGeometry& face, const FittedPlane& plane, const FaceRim& rim, double reach);

  Parametrization parametrization() override { return Parametrization::Smooth; }
  ParameterBox parameter_box() override { return box_; }
  Vec2 period() override { return {}; }
  Vec3 evaluate(const Vec2& uv) override { return derivatives(uv).point; }
  SurfaceDerivatives derivatives(const Vec2& uv) override;
  Vec3 normal(const Vec2& uv) override;
  PrincipalCurvatures curvature(const Vec2&) override { return {}; }
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) override;
  Vec2 edge_parameters(const EdgeUse&, double) override { return {}; }
  ParameterRange edge_range(const EdgeUse&) override { return {}; }
  Tessellation tessellate(double chord, double angle) override { return face_.tessellate(chord, angle); }

 private:
  FaceGeometry& face_;
  FittedPlane plane_;
  ParameterBox box_;
  double reach_;
  std::optional<Vec2> guess_;  // of the last point found
};

}  // namespace tetloom
