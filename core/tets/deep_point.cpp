#include "core/tets/deep_point.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/tets/working_mesh.hpp"

namespace tetloom::tets {

namespace {

constexpr int kMostSteps = 80;
constexpr double kShrink = 0.2;         // of the barrier's weight, once its minimum is near
constexpr double kNear = 0.5;           // Newton decrement there
constexpr double kPrecision = 0.1;      // of the depth
constexpr double kLeastWeight = 1e-12;  // of the barrier, in lengths of the star: below, there is no depth
constexpr double kShareOfWay = 0.9;     // of a step that would reach a plane

using Vec4 = std::array<double, 4>;  // a place and a depth

// The solution of a symmetric positive definite system, by Cholesky's factors; false where it is singular.
bool solve(std::array<Vec4, 4> m, Vec4& b) {
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t k = 0; k < j; ++k) m[j][j] -= m[j][k] * m[j][k];
    if (!(m[j][j] > 0)) return false;
    m[j][j] = std::sqrt(m[j][j]);
    for (std::size_t i = j + 1; i < 4; ++i) {
      for (std::size_t k = 0; k < j; ++k) m[i][j] -= m[i][k] * m[j][k];
      m[i][j] /= m[j][j];
    }
  }
  for (std::size_t i = 0; i < 4; ++i) {
    for (std::size_t k = 0; k < i; ++k) b[i] -= m[i][k] * b[k];
    b[i] /= m[i][i];
  }
  for (std::size_t i = 4; i-- > 0;) {
    for (std::size_t k = i + 1; k < 4; ++k) b[i] -= m[k][i] * b[k];
    b[i] /= m[i][i];
  }
  return true;
}

constexpr std::size_t kMostFaces = 2 * WorkingMesh::kMostTets;

class DepthSearch {
 public:
  // Values in units of the largest one at the origin.
  explicit DepthSearch(std::span<AffineFunction> functions) : functions_(functions) {
    for (const AffineFunction& f : functions_) scale_ = std::max(scale_, std::abs(f.offset));
    for (AffineFunction& f : functions_) {
      f.offset /= scale_;
      depth_ = std::min(depth_, f.offset - 1);
    }
  }

  std::optional<DeepPoint> run() {
    if (functions_.size() < 4 || !(scale_ > 0)) return std::nullopt;
    for (int i = 0; i < kMostSteps; ++i) {
      const double decrement = step();
      if (!(decrement >= 0)) break;
      if (decrement > kNear) continue;
      // The least distance is at most the depth here and, near the path's point, the weight per plane.
      const double slack = 2 * weight_ * static_cast<double>(functions_.size());
      if (depth_ > 0 ? slack < kPrecision * depth_ : depth_ + slack < 0) break;
      if (weight_ < kLeastWeight) break;
      weight_ *= kShrink;
    }
    double depth = HUGE_VAL;
    for (const auto& [normal, offset] : functions_) depth = std::min(depth, offset + dot(normal, at_));
    return DeepPoint{scale_ * at_, scale_ * depth};
  }

 private:
  // One step of Newton's method on -depth - weight * sum of the logarithms of what the distances exceed the depth by;
  // its decrement before, in units of the weight. Negative where the system is singular.
  double step() {
    std::array<Vec4, 4> hessian{};
    Vec4 gradient{0, 0, 0, -1 / weight_};
    for (const auto& [n, offset] : functions_) {
      const double inverse = 1 / (offset + dot(n, at_) - depth_);
      const Vec4 v{n.x * inverse, n.y * inverse, n.z * inverse, -inverse};
      for (std::size_t i = 0; i < 4; ++i) {
        gradient[i] -= v[i];
        for (std::size_t j = 0; j <= i; ++j) hessian[i][j] += v[i] * v[j];
      }
    }
    Vec4 d{-gradient[0], -gradient[1], -gradient[2], -gradient[3]};
    if (!solve(hessian, d)) return -1;
    double decrement2 = 0;
    for (std::size_t i = 0; i < 4; ++i) decrement2 -= gradient[i] * d[i];
    const Vec3 move{d[0], d[1], d[2]};
    double share = 1;
    for (const auto& [n, offset] : functions_) {
      const double room = offset + dot(n, at_) - depth_, change = dot(n, move) - d[3];
      if (room + share / kShareOfWay * change < 0) share = -kShareOfWay * room / change;
    }
    at_ += share * move;
    depth_ += share * d[3];
    return share < 1 ? HUGE_VAL : std::sqrt(std::max(0.0, decrement2));
  }

  std::span<AffineFunction> functions_;
  double scale_ = 0, depth_ = HUGE_VAL, weight_ = 1;
  Vec3 at_;
};

}  // namespace

std::optional<DeepPoint> maximize_least(std::span<AffineFunction> functions) { return DepthSearch(functions).run(); }

std::optional<DeepPoint> find_deep_point(std::span<const StarTet> star) {
  constexpr double kNoArea = 1e-12;  // of the squared edges: such a face has no plane
  std::array<AffineFunction, kMostFaces> planes;
  std::size_t count = 0;
  for (const StarTet& tet : star) {
    const double length = norm(tet.normal);
    if (length > kNoArea * tet.squares) planes[count++] = {tet.normal / length, tet.volume / length};
  }
  return maximize_least(std::span(planes).first(count));
}

}  // namespace tetloom::tets
