#pragma once
// The curves and surfaces of the analytic test models: lines, circles, planes and surfaces of revolution.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <variant>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::test_models {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kTurn = 2 * kPi;
inline constexpr double kDegree = kPi / 180;

/// `value` moved by whole periods to lie nearest to `target`.
inline double wrap_near(double value, double target, double period) {
  return period > 0 ? value - period * std::round((value - target) / period) : value;
}

/// x(t) = origin + t direction + radius (cos t axis_x + sin t axis_y). A line has radius 0, a circle direction 0.
struct Curve {
  Vec3 origin, direction;
  double radius = 0;
  Vec3 axis_x{1, 0, 0}, axis_y{0, 1, 0};
  ParameterRange range;

  Vec3 evaluate(double t) const {
    return origin + t * direction + radius * (std::cos(t) * axis_x + std::sin(t) * axis_y);
  }
  Vec3 derivative(double t) const { return direction + radius * (std::cos(t) * axis_y - std::sin(t) * axis_x); }
  double curvature() const { return radius > 0 ? 1 / radius : 0; }
  double period() const { return radius > 0 ? kTurn : 0; }
  double closest(const Vec3& x) const {
    if (radius == 0) return std::clamp(dot(x - origin, direction) / norm2(direction), range.lo, range.hi);
    const double t = std::atan2(dot(x - origin, axis_y), dot(x - origin, axis_x));
    const double middle = 0.5 * (range.lo + range.hi);
    return std::clamp(wrap_near(t, middle, kTurn), range.lo, range.hi);
  }
};

/// x(u,v) = origin + u axis_x + v axis_y, with orthonormal axes.
struct Plane {
  Vec3 origin, axis_x{1, 0, 0}, axis_y{0, 1, 0};

  Vec3 evaluate(const Vec2& uv) const { return origin + uv.u * axis_x + uv.v * axis_y; }
  SurfaceDerivatives derivatives(const Vec2& uv) const { return {evaluate(uv), axis_x, axis_y}; }
  Vec3 normal(const Vec2&) const { return cross(axis_x, axis_y); }
  PrincipalCurvatures curvature(const Vec2&) const { return {}; }
  Vec2 closest(const Vec3& x, const std::optional<Vec2>&) const {
    return {dot(x - origin, axis_x), dot(x - origin, axis_y)};
  }
  Vec2 period() const { return {}; }
};

/// The surface that the profile (rho(v), z(v)) = (rho_0 + rho_1 v + r cos v, z_1 v + r sin v) sweeps about the z axis
/// through `center`: cylinders and cones (r = 0), spheres (rho_0 = 0) and tori.
struct Revolution {
  Vec3 center;
  double rho_0 = 0, rho_1 = 0, z_1 = 0, r = 0;

  double rho(double v) const { return rho_0 + rho_1 * v + r * std::cos(v); }
  double d_rho(double v) const { return rho_1 - r * std::sin(v); }
  double d_z(double v) const { return z_1 + r * std::cos(v); }
  Vec3 evaluate(const Vec2& uv) const {
    const double radius = rho(uv.v);
    return center + Vec3{radius * std::cos(uv.u), radius * std::sin(uv.u), z_1 * uv.v + r * std::sin(uv.v)};
  }
  SurfaceDerivatives derivatives(const Vec2& uv) const {
    const double c = std::cos(uv.u), s = std::sin(uv.u), radius = rho(uv.v), slope = d_rho(uv.v);
    return {evaluate(uv), {-radius * s, radius * c, 0}, {slope * c, slope * s, d_z(uv.v)}};
  }
  Vec3 normal(const Vec2& uv) const {
    return normalized(Vec3{d_z(uv.v) * std::cos(uv.u), d_z(uv.v) * std::sin(uv.u), -d_rho(uv.v)});
  }
  PrincipalCurvatures curvature(const Vec2& uv) const {
    const double speed = std::hypot(d_rho(uv.v), d_z(uv.v));
    const double along_profile = r > 0 ? -1 / r : 0;
    const double radius = std::max(rho(uv.v), 1e-12 * speed);
    const double around = r > 0 && rho_0 == 0 ? -1 / r : -d_z(uv.v) / (speed * radius);
    if (std::abs(around) >= std::abs(along_profile)) return {around, along_profile};
    return {along_profile, around};
  }
  Vec2 closest(const Vec3& x, const std::optional<Vec2>& guess) const {
    const Vec3 local = x - center;
    const double distance_to_axis = std::hypot(local.x, local.y);
    const double u = distance_to_axis > 0 ? std::atan2(local.y, local.x) : guess ? guess->u : 0;
    const double v = r > 0 ? std::atan2(local.z, distance_to_axis - rho_0)
                           : ((distance_to_axis - rho_0) * rho_1 + local.z * z_1) / (rho_1 * rho_1 + z_1 * z_1);
    return {wrap_near(u, guess ? guess->u : kPi, kTurn), wrap_near(v, guess ? guess->v : kPi, period().v)};
  }
  Vec2 period() const { return {kTurn, r > 0 && rho_0 > 0 ? kTurn : 0}; }
};

using Surface = std::variant<Plane, Revolution>;

/// The parameter curve of one edge use on a surface of revolution: (u,v) = origin + t direction.
struct ParameterLine {
  ModelEdgeId edge;
  bool second_side = false;
  Vec2 origin, direction;
  ParameterRange range;
};

/// How the facets of a face are laid out.
enum class Facets {
  Grid,  ///< over the parameter box
  Fan,   ///< of the corners of a convex polygon
  Disc,  ///< from the centre to one circle
  Ring   ///< between two circles
};

struct AnalyticFace {
  Surface surface;
  ParameterBox box;
  std::vector<ParameterLine> parameter_lines;  ///< empty on planes, where edges are projected
  Facets facets = Facets::Grid;
  std::vector<ModelLoop> loops;
  FaceSides sides;
  double area = 0;
};

/// The tables of a model before it is finished.
struct Parts {
  std::vector<Vec3> points;
  std::vector<Curve> curves;  ///< one per edge; unused for degenerate ones
  std::vector<ModelEdgeTopology> edges;
  std::vector<AnalyticFace> faces;
  std::vector<std::vector<ModelFaceId>> region_to_faces;
  std::vector<double> volumes;
  Box3 box;
};

}  // namespace tetloom::test_models
