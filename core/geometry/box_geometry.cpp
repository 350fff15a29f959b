#include "core/geometry/box_geometry.hpp"

#include <algorithm>

namespace tetloom {
namespace {

class SegmentGeometry : public EdgeGeometry {
 public:
  SegmentGeometry(const Vec3& from, const Vec3& to) : from_(from), length_(distance(from, to)) {
    along_ = (to - from) / length_;
  }
  ParameterRange range() override { return {0, length_}; }
  double period() override { return 0; }
  Vec3 evaluate(double t) override { return from_ + t * along_; }
  Vec3 derivative(double) override { return along_; }
  double curvature(double) override { return 0; }
  CurvePoint closest_point(const Vec3& x) override {
    const double t = std::clamp(dot(x - from_, along_), 0.0, length_);
    return {t, evaluate(t), distance(x, evaluate(t))};
  }

 private:
  Vec3 from_, along_;
  double length_;
};

class RectangleGeometry : public FaceGeometry {
 public:
  RectangleGeometry(const Box3& box, int side, std::uint32_t first_edge, std::uint32_t first_vertex)
      : box_(box), side_(side), first_edge_(first_edge), first_vertex_(first_vertex) {}

  Parametrization parametrization() override { return Parametrization::Smooth; }
  ParameterBox parameter_box() override {
    return {{0, 0}, {box_.hi[side_.u] - box_.lo[side_.u], box_.hi[side_.v] - box_.lo[side_.v]}};
  }
  Vec2 period() override { return {}; }
  Vec3 evaluate(const Vec2& uv) override {
    Vec3 x;
    x[side_.axis] = side_.above ? box_.hi[side_.axis] : box_.lo[side_.axis];
    x[side_.u] = box_.lo[side_.u] + uv.u;
    x[side_.v] = box_.lo[side_.v] + uv.v;
    return x;
  }
  SurfaceDerivatives derivatives(const Vec2& uv) override {
    SurfaceDerivatives result{evaluate(uv), {}, {}};
    result.du[side_.u] = result.dv[side_.v] = 1;
    return result;
  }
  Vec3 normal(const Vec2&) override {
    Vec3 n;
    n[side_.axis] = side_.above ? 1 : -1;
    return n;
  }
  PrincipalCurvatures curvature(const Vec2&) override { return {}; }
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>&) override {
    const ParameterBox range = parameter_box();
    const Vec2 uv{std::clamp(x[side_.u] - box_.lo[side_.u], 0.0, range.hi.u),
                  std::clamp(x[side_.v] - box_.lo[side_.v], 0.0, range.hi.v)};
    return {uv, evaluate(uv), distance(x, evaluate(uv))};
  }
  Vec2 edge_parameters(const EdgeUse& use, double t) override {
    const auto [from, to] = edge_of_box(static_cast<int>(use.edge.value - first_edge_));
    const Vec3 start = corner_of(box_, from), end = corner_of(box_, to);
    const Vec3 x = start + t / distance(start, end) * (end - start);
    return {x[side_.u] - box_.lo[side_.u], x[side_.v] - box_.lo[side_.v]};
  }
  ParameterRange edge_range(const EdgeUse& use) override {
    const auto [from, to] = edge_of_box(static_cast<int>(use.edge.value - first_edge_));
    return {0, distance(corner_of(box_, from), corner_of(box_, to))};
  }
  Tessellation tessellate(double, double) override {
    Tessellation result;
    for (const int corner : side_.corners()) {
      const Vec3 x = corner_of(box_, corner);
      result.points.push_back(x);
      result.uv.push_back({x[side_.u] - box_.lo[side_.u], x[side_.v] - box_.lo[side_.v]});
      result.classification.emplace_back(0, first_vertex_ + static_cast<std::uint32_t>(corner));
      result.edge_parameter.push_back(0);
    }
    result.tri_to_vert = {{0, 1, 2}, {0, 2, 3}};
    return result;
  }

 private:
  Box3 box_;
  BoxSide side_;
  std::uint32_t first_edge_, first_vertex_;
};

}  // namespace

Vec3 corner_of(const Box3& box, int corner) {
  return {(corner & 1) ? box.hi.x : box.lo.x, (corner & 2) ? box.hi.y : box.lo.y, (corner & 4) ? box.hi.z : box.lo.z};
}

BoxEdge edge_of_box(int edge) {
  const int axis = edge / 4, first = (axis + 1) % 3, second = (axis + 2) % 3;
  const int from = ((edge & 1) << first) | (((edge >> 1) & 1) << second);
  return {from, from | (1 << axis)};
}

std::unique_ptr<EdgeGeometry> edge_geometry_of(const Box3& box, int edge) {
  const auto [from, to] = edge_of_box(edge);
  return std::make_unique<SegmentGeometry>(corner_of(box, from), corner_of(box, to));
}

std::unique_ptr<FaceGeometry> face_geometry_of(const Box3& box, int side, std::uint32_t first_edge,
                                               std::uint32_t first_vertex) {
  return std::make_unique<RectangleGeometry>(box, side, first_edge, first_vertex);
}

}  // namespace tetloom
