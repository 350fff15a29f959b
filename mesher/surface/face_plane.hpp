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

/// The geometry of a face with (u,v) in the plane: every point is the surface's point above or below it. Where there is
/// none, or one so high that the face would be a cliff seen from the rim (it lies on another sheet of a surface that
/// folds over), and everywhere unless `follow`, the point has the height of the rim around it, by mean value
/// coordinates (Hormann & Floater 2006). `nodes` are the points of the rim's nodes. Only what the plane path of the
/// face mesher asks for is answered: evaluate, derivatives and normal. Complexity of a question: linear in the rim.
class FaceOverPlane : public FaceGeometry {
 public:
  FaceOverPlane(FaceGeometry& face, const FittedPlane& plane, const FaceRim& rim, std::span<const Vec3> nodes,
                bool follow);

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
  struct RimPoint {
    Vec2 place;
    double height;
  };
  struct RimPiece {
    RimPoint start, end;
  };
  struct RimHeight {
    double height, distance;  // of the rim around a point, and of the nearest rim node from it
  };
  RimHeight rim_height(const Vec2& uv) const;
  SurfaceDerivatives spanned_at(const Vec2& uv, double height) const;
  std::optional<SurfaceDerivatives> surface_above(const Vec3& base);

  FaceGeometry& face_;
  FittedPlane plane_;
  std::vector<RimPiece> rim_;
  ParameterBox box_;
  bool follow_;
  double reach_ = 0;           // the extent of the rim
  std::optional<Vec2> guess_;  // of the last point found
};

}  // namespace tetloom
