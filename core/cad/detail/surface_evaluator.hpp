#pragma once
// Points and derivatives of a surface, fast: the inner loop of the surface mesher. Planes, cylinders, cones, spheres
// and tori are evaluated in closed form in world coordinates; B-spline and Bézier surfaces as polynomials per span;
// the rest (extrusions, revolutions, offsets) through OpenCASCADE.
//
// Private to core/cad. An evaluator belongs to one task: it shares nothing mutable with another evaluator.
#include <array>
#include <Geom_Surface.hxx>
#include <memory>
#include <optional>

#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::cad {

/// A point of a surface with its derivatives up to the second order.
struct SurfaceJet {
  Vec3 point, du, dv, duu, duv, dvv;
};

/// The surface of a face, with its derivatives.
class SurfaceEvaluator {
 public:
  virtual ~SurfaceEvaluator() = default;
  virtual Vec3 point(const Vec2& uv) = 0;
  virtual SurfaceDerivatives derivatives(const Vec2& uv) = 0;
  virtual SurfaceJet jet(const Vec2& uv) = 0;
  /// The (u,v) of the surface point nearest to `x`, for surfaces that know it in closed form. `hint` stands in for
  /// parameters that are undetermined (the angle at a pole) and picks between equally near points.
  virtual std::optional<Vec2> invert(const Vec3& x, const Vec2& hint) = 0;
  /// How many polynomial pieces the surface has along u and v (1 where it has no such thing).
  virtual std::array<int, 2> pieces() const { return {1, 1}; }
};

/// The evaluator for `surface`, which already stands in world coordinates. Trimmed surfaces are seen through.
std::unique_ptr<SurfaceEvaluator> make_evaluator(const Handle(Geom_Surface) & surface);

/// The surface under any number of rectangular trims.
Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface);

}  // namespace tetloom::cad
