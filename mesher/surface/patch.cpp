#include "mesher/surface/patch.hpp"

#include <algorithm>

#include "core/predicates/predicates.hpp"

namespace tetloom {

PatchSurface::PatchSurface(FaceGeometry& face, const SizeField& sizes, Vec2 scale)
    : face_(face), sizes_(sizes), scale_(scale), smooth_(face.parametrization() == Parametrization::Smooth) {}

PatchPlace PatchSurface::at_plane(const Vec2& plane) const {
  const SurfaceDerivatives d = face_.derivatives({plane.u / scale_.u, plane.v / scale_.v});
  const Vec3 du = d.du / scale_.u, dv = d.dv / scale_.v;
  return {plane, d.point, du, dv, normalized(cross(du, dv))};
}

PatchPlace PatchSurface::nearest(const Vec3& x, const Vec2& guess) const {
  const SurfacePoint found = face_.closest_point(x, guess);
  const Vec3 n = face_.normal(found.uv);
  const Vec3 axis = std::abs(n.x) < 0.6 ? Vec3{1, 0, 0} : std::abs(n.y) < 0.6 ? Vec3{0, 1, 0} : Vec3{0, 0, 1};
  const Vec3 du = normalized(cross(axis, n));
  return {found.uv, found.point, du, cross(n, du), n};
}

PatchPlace PatchSurface::displaced(const PatchPlace& from, const Vec2& step) const {
  if (smooth_) return at_plane(from.plane + step);
  return nearest(from.point + step.u * from.du + step.v * from.dv, from.plane);
}

PatchPlace PatchSurface::midpoint(const PatchPlace& a, const PatchPlace& b) const {
  if (smooth_) return at_plane(0.5 * (a.plane + b.plane));
  return nearest(0.5 * (a.point + b.point), a.plane);
}

double PatchSurface::edge_length(const PatchPlace& a, const PatchPlace& b) const {
  const double chord2 = norm2(b.point - a.point);
  if (!smooth_) return std::sqrt(chord2);
  const Vec2 step = b.plane - a.plane;
  const double from_a = norm2(step.u * a.du + step.v * a.dv), from_b = norm2(step.u * b.du + step.v * b.dv);
  return std::sqrt(std::max(chord2, std::min(from_a, from_b)));
}

bool PatchSurface::oriented(const PatchPlace& a, const PatchPlace& b, const PatchPlace& c) const {
  if (smooth_) return orient2d(a.plane, b.plane, c.plane) > 0;
  const Vec3 n = normalized(cross(b.point - a.point, c.point - a.point));
  constexpr double kLeastCosine = 0.1;
  return dot(n, a.normal) > kLeastCosine && dot(n, b.normal) > kLeastCosine && dot(n, c.normal) > kLeastCosine;
}

}  // namespace tetloom
