#include "core/cad/detail/surface_evaluator.hpp"

#include <Geom_BezierSurface.hxx>
#include <Geom_ConicalSurface.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <GeomConvert.hxx>
#include <numbers>
#include <type_traits>

#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/spline_surface.hpp"

namespace tetloom::cad {
namespace {

/// A right- or left-handed orthonormal frame.
struct AxisFrame {
  Vec3 origin, x, y, z;
  explicit AxisFrame(const gp_Ax3& axes)
      : origin(to_vec3(axes.Location())),
        x(to_vec3(axes.XDirection())),
        y(to_vec3(axes.YDirection())),
        z(to_vec3(axes.Direction())) {}
  Vec3 local(const Vec3& p) const { return {dot(p - origin, x), dot(p - origin, y), dot(p - origin, z)}; }
};

class PlaneEvaluator final : public SurfaceEvaluator {
 public:
  explicit PlaneEvaluator(const gp_Ax3& axes) : frame_(axes) {}
  Vec3 point(const Vec2& uv) override { return frame_.origin + uv.u * frame_.x + uv.v * frame_.y; }
  SurfaceDerivatives derivatives(const Vec2& uv) override { return {point(uv), frame_.x, frame_.y}; }
  SurfaceJet jet(const Vec2& uv) override { return {point(uv), frame_.x, frame_.y, {}, {}, {}}; }
  std::optional<Vec2> invert(const Vec3& x, const Vec2&) override {
    const Vec3 p = frame_.local(x);
    return Vec2{p.x, p.y};
  }

 private:
  AxisFrame frame_;
};

/// A point of a meridian in the half plane (radius, height), with derivatives in v.
struct Meridian {
  double r = 0, h = 0, dr = 0, dh = 0, ddr = 0, ddh = 0;
};

struct CylinderMeridian {
  double radius;
  Meridian at(double v) const { return {radius, v, 0, 1, 0, 0}; }
  double nearest(double, double h) const { return h; }
};

struct ConeMeridian {
  double radius, sine, cosine;
  Meridian at(double v) const { return {radius + v * sine, v * cosine, sine, cosine, 0, 0}; }
  double nearest(double r, double h) const { return (r - radius) * sine + h * cosine; }
};

struct SphereMeridian {
  double radius;
  Meridian at(double v) const {
    const double c = radius * std::cos(v), s = radius * std::sin(v);
    return {c, s, -s, c, -c, -s};
  }
  double nearest(double r, double h) const { return std::atan2(h, r); }
};

struct TorusMeridian {
  double major, minor;
  Meridian at(double v) const {
    const double c = minor * std::cos(v), s = minor * std::sin(v);
    return {major + c, s, -s, c, -c, -s};
  }
  double nearest(double r, double h) const { return std::atan2(h, r - major); }
};

double near_period(double angle, double hint) {
  constexpr double turn = 2 * std::numbers::pi;
  return angle + turn * std::round((hint - angle) / turn);
}

/// A meridian turned about the z axis of a frame by u.
template <class Curve>
class TurnedEvaluator final : public SurfaceEvaluator {
 public:
  TurnedEvaluator(const gp_Ax3& axes, Curve curve) : frame_(axes), curve_(curve) {}

  Vec3 point(const Vec2& uv) override {
    const Meridian m = curve_.at(uv.v);
    return frame_.origin + (m.r * std::cos(uv.u)) * frame_.x + (m.r * std::sin(uv.u)) * frame_.y + m.h * frame_.z;
  }
  SurfaceDerivatives derivatives(const Vec2& uv) override {
    const Meridian m = curve_.at(uv.v);
    const double c = std::cos(uv.u), s = std::sin(uv.u);
    const Vec3 out = c * frame_.x + s * frame_.y, along = c * frame_.y - s * frame_.x;
    return {frame_.origin + m.r * out + m.h * frame_.z, m.r * along, m.dr * out + m.dh * frame_.z};
  }
  SurfaceJet jet(const Vec2& uv) override {
    const Meridian m = curve_.at(uv.v);
    const double c = std::cos(uv.u), s = std::sin(uv.u);
    const Vec3 out = c * frame_.x + s * frame_.y, along = c * frame_.y - s * frame_.x;
    return {frame_.origin + m.r * out + m.h * frame_.z,
            m.r * along,
            m.dr * out + m.dh * frame_.z,
            -m.r * out,
            m.dr * along,
            m.ddr * out + m.ddh * frame_.z};
  }
  // The nearest point lies in the half plane of x or in the one opposite, where the meridian may have negative radius
  // (beyond a cone's apex, inside a spindle torus).
  std::optional<Vec2> invert(const Vec3& x, const Vec2& hint) override {
    const Vec3 p = frame_.local(x);
    const double r = std::hypot(p.x, p.y);
    const double u = r > 0 ? std::atan2(p.y, p.x) : hint.u;
    const Vec2 same = place(u, r, p.z, hint);
    if constexpr (std::is_same_v<Curve, SphereMeridian> || std::is_same_v<Curve, CylinderMeridian>) return same;
    const Vec2 opposite = place(u + std::numbers::pi, -r, p.z, hint);
    const double near = norm2(point(same) - x), far = norm2(point(opposite) - x);
    const double noise = 1e-24 * norm2(p);
    return near <= far + noise ? same : opposite;
  }

 private:
  Vec2 place(double u, double r, double h, const Vec2& hint) const {
    double v = curve_.nearest(r, h);
    if constexpr (std::is_same_v<Curve, TorusMeridian>) v = near_period(v, hint.v);
    return {near_period(u, hint.u), v};
  }

  AxisFrame frame_;
  Curve curve_;
};

class OcctEvaluator final : public SurfaceEvaluator {
 public:
  // Offset surfaces keep helper surfaces inside: a copy makes sure that nothing is shared with another task.
  explicit OcctEvaluator(const Handle(Geom_Surface) & surface)
      : adaptor_(Handle(Geom_Surface)::DownCast(surface->Copy())) {}
  Vec3 point(const Vec2& uv) override { return to_vec3(adaptor_.Value(uv.u, uv.v)); }
  SurfaceDerivatives derivatives(const Vec2& uv) override {
    gp_Pnt p;
    gp_Vec du, dv;
    adaptor_.D1(uv.u, uv.v, p, du, dv);
    return {to_vec3(p), to_vec3(du), to_vec3(dv)};
  }
  SurfaceJet jet(const Vec2& uv) override {
    gp_Pnt p;
    gp_Vec du, dv, duu, dvv, duv;
    adaptor_.D2(uv.u, uv.v, p, du, dv, duu, dvv, duv);
    return {to_vec3(p), to_vec3(du), to_vec3(dv), to_vec3(duu), to_vec3(duv), to_vec3(dvv)};
  }
  std::optional<Vec2> invert(const Vec3&, const Vec2&) override { return std::nullopt; }
  std::array<int, 2> pieces() const override {
    return {adaptor_.NbUIntervals(GeomAbs_C2), adaptor_.NbVIntervals(GeomAbs_C2)};
  }

 private:
  GeomAdaptor_Surface adaptor_;
};

template <class Curve>
std::unique_ptr<SurfaceEvaluator> turned(const gp_Ax3& axes, Curve curve) {
  return std::make_unique<TurnedEvaluator<Curve>>(axes, curve);
}

}  // namespace

Handle(Geom_Surface) untrimmed(Handle(Geom_Surface) surface) {
  for (;;) {
    Handle(Geom_RectangularTrimmedSurface) trimmed = Handle(Geom_RectangularTrimmedSurface)::DownCast(surface);
    if (trimmed.IsNull()) return surface;
    surface = trimmed->BasisSurface();
  }
}

std::unique_ptr<SurfaceEvaluator> make_evaluator(const Handle(Geom_Surface) & trimmed) {
  const Handle(Geom_Surface) surface = untrimmed(trimmed);
  if (auto plane = Handle(Geom_Plane)::DownCast(surface); !plane.IsNull())
    return std::make_unique<PlaneEvaluator>(plane->Position());
  if (auto cylinder = Handle(Geom_CylindricalSurface)::DownCast(surface); !cylinder.IsNull())
    return turned(cylinder->Position(), CylinderMeridian{cylinder->Radius()});
  if (auto cone = Handle(Geom_ConicalSurface)::DownCast(surface); !cone.IsNull())
    return turned(cone->Position(),
                  ConeMeridian{cone->RefRadius(), std::sin(cone->SemiAngle()), std::cos(cone->SemiAngle())});
  if (auto sphere = Handle(Geom_SphericalSurface)::DownCast(surface); !sphere.IsNull())
    return turned(sphere->Position(), SphereMeridian{sphere->Radius()});
  if (auto torus = Handle(Geom_ToroidalSurface)::DownCast(surface); !torus.IsNull())
    return turned(torus->Position(), TorusMeridian{torus->MajorRadius(), torus->MinorRadius()});
  Handle(Geom_BSplineSurface) spline = Handle(Geom_BSplineSurface)::DownCast(surface);
  if (!Handle(Geom_BezierSurface)::DownCast(surface).IsNull()) spline = GeomConvert::SurfaceToBSplineSurface(surface);
  if (!spline.IsNull() && spline->UDegree() <= SplineSurface::kMaxDegree &&
      spline->VDegree() <= SplineSurface::kMaxDegree)
    return std::make_unique<SplineSurface>(spline);
  return std::make_unique<OcctEvaluator>(surface);
}

}  // namespace tetloom::cad
