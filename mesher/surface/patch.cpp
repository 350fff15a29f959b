#include "mesher/surface/patch.hpp"

#include <algorithm>

#include "core/predicates/predicates.hpp"

namespace tetloom {
namespace {

// The 16 low bits of x spread to the even bits of the result.
std::uint32_t spread_bits(std::uint32_t x) {
  x = (x | (x << 8)) & 0x00ff00ffu;
  x = (x | (x << 4)) & 0x0f0f0f0fu;
  x = (x | (x << 2)) & 0x33333333u;
  return (x | (x << 1)) & 0x55555555u;
}

class CurveKey {
 public:
  explicit CurveKey(const std::vector<PatchVertex>& vertices) {
    lo_ = hi_ = vertices.front().place.plane;
    for (const PatchVertex& vertex : vertices) {
      const Vec2& p = vertex.place.plane;
      lo_ = {std::min(lo_.u, p.u), std::min(lo_.v, p.v)};
      hi_ = {std::max(hi_.u, p.u), std::max(hi_.v, p.v)};
    }
    width_ = std::max({hi_.u - lo_.u, hi_.v - lo_.v, 1e-300});
  }
  std::uint32_t operator()(const Vec2& p) const {
    return spread_bits(cell(p.u - lo_.u)) | spread_bits(cell(p.v - lo_.v)) << 1;
  }

 private:
  std::uint32_t cell(double x) const {
    return static_cast<std::uint32_t>(std::clamp(65535.0 * (x / width_), 0.0, 65535.0));
  }

  Vec2 lo_, hi_;
  double width_ = 1;
};

}  // namespace

void sort_spatially(Patch& patch) {
  const auto count = static_cast<std::uint32_t>(patch.vertices.size());
  if (count == 0) return;
  const CurveKey key(patch.vertices);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> order;  // (key, vertex); rim vertices keep their places
  std::uint32_t rim = 0;
  while (rim < count && patch.vertices[rim].node != Triangulation::kNone) ++rim;
  for (std::uint32_t v = rim; v < count; ++v) order.push_back({key(patch.vertices[v].place.plane), v});
  std::sort(order.begin(), order.end());
  std::vector<std::uint32_t> numbers(count);
  std::vector<PatchVertex> vertices;
  vertices.reserve(count);
  vertices.assign(patch.vertices.begin(), patch.vertices.begin() + rim);
  for (std::uint32_t v = 0; v < rim; ++v) numbers[v] = v;
  for (const auto& [k, v] : order) {
    numbers[v] = static_cast<std::uint32_t>(vertices.size());
    vertices.push_back(patch.vertices[v]);
  }
  patch.vertices = std::move(vertices);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> triangles;  // (key, triangle)
  for (std::uint32_t tri = 0; tri < patch.topology.slots(); ++tri) {
    if (!patch.topology.alive(tri)) continue;
    Vec2 sum;
    for (const std::uint32_t v : patch.topology.triangle(tri)) sum += patch.vertices[numbers[v]].place.plane;
    triangles.push_back({key((1.0 / 3) * sum), tri});
  }
  std::sort(triangles.begin(), triangles.end());
  std::vector<std::uint32_t> triangle_order;
  triangle_order.reserve(triangles.size());
  for (const auto& [k, tri] : triangles) triangle_order.push_back(tri);
  patch.topology.renumber(numbers, triangle_order);
}

PatchPlace PatchSurface::at_plane(const Vec2& plane) const {
  const SurfaceDerivatives d = face_.derivatives({plane.u / scale_.u, plane.v / scale_.v});
  const Vec3 du = d.du / scale_.u, dv = d.dv / scale_.v;
  const Vec3 n = cross(du, dv);
  // At a pole one derivative vanishes but for rounding, and the product points anywhere; an apex has no normal at all.
  constexpr double kPole = 1e-10;
  const bool regular = norm(n) > kPole * (norm2(du) + norm2(dv));
  return {plane, d.point, du, dv, regular ? normalized(n) : Vec3{}};
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
  const auto agrees = [&](const Vec3& normal) { return normal == Vec3{} || dot(n, normal) > kLeastCosine; };
  return n != Vec3{} && agrees(a.normal) && agrees(b.normal) && agrees(c.normal);
}

}  // namespace tetloom
