#include "mesher/layers/side_plane.hpp"

#include <limits>

namespace tetloom::layers {
namespace {

class PlaneGeometry : public FaceGeometry {
 public:
  explicit PlaneGeometry(const SidePlane& plane) : plane_(plane) {}

  Parametrization parametrization() override { return Parametrization::Smooth; }
  ParameterBox parameter_box() override {
    constexpr double kLarge = std::numeric_limits<double>::max();
    return {{-kLarge, -kLarge}, {kLarge, kLarge}};
  }
  Vec2 period() override { return {}; }
  Vec3 evaluate(const Vec2& uv) override {
    return plane_.project(plane_.origin + uv.u * plane_.first + uv.v * plane_.second);
  }
  SurfaceDerivatives derivatives(const Vec2& uv) override { return {evaluate(uv), plane_.first, plane_.second}; }
  Vec3 normal(const Vec2&) override { return plane_.normal; }
  PrincipalCurvatures curvature(const Vec2&) override { return {}; }
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>&) override {
    const Vec3 point = plane_.project(x);
    return {plane_.to_plane(point), point, distance(x, point)};
  }
  Vec2 edge_parameters(const EdgeUse&, double) override { return {}; }
  ParameterRange edge_range(const EdgeUse&) override { return {}; }
  Tessellation tessellate(double, double) override { return {}; }

 private:
  SidePlane plane_;
};

}  // namespace

std::unique_ptr<FaceGeometry> make_geometry(const SidePlane& plane) { return std::make_unique<PlaneGeometry>(plane); }

}  // namespace tetloom::layers
