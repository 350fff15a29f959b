#include "mesher/layers/layer_cells.hpp"

#include <cmath>
#include <span>

#include "core/predicates/predicates.hpp"

namespace tetloom::layers {
namespace {

// Beside the tets of its corners.
constexpr std::array<CellCorner, 6> kOtherPrismTets{
    {{0, 1, 2, 4}, {0, 1, 2, 5}, {3, 5, 4, 1}, {3, 5, 4, 2}, {0, 1, 5, 3}, {2, 0, 4, 3}}};
constexpr double kOfEquilateral = 0.8660254037844386;  // Jacobian of the straight prism above an equilateral triangle

struct CornerJacobian {
  double det, lengths2;  // the Jacobian; the product of the squared lengths
};

CornerJacobian corner_at(const CellCorner& corner, std::span<const Vec3> x) {
  const Vec3 u = x[corner[1]] - x[corner[0]], v = x[corner[2]] - x[corner[0]], w = x[corner[3]] - x[corner[0]];
  return {dot(cross(u, v), w), norm2(u) * norm2(v) * norm2(w)};
}

// The rounding errors of a determinant are below 8e-16 times a sum of six products of the lengths (Shewchuk 1997).
bool is_positive_tet(const CellCorner& tet, std::span<const Vec3> x) {
  constexpr double kCertain = 1e-28;
  const auto [det, lengths2] = corner_at(tet, x);
  if (det > 0 && det * det > kCertain * lengths2) return true;
  return orient3d(x[tet[0]], x[tet[1]], x[tet[2]], x[tet[3]]) > 0;
}

bool are_positive(std::span<const CellCorner> tets, std::span<const Vec3> x) {
  return std::ranges::all_of(tets, [&](const CellCorner& tet) { return is_positive_tet(tet, x); });
}

// Without square roots.
bool are_sound(std::span<const CellCorner> corners, std::span<const Vec3> x, double least) {
  const double bound = least * least;
  return std::ranges::all_of(corners, [&](const CellCorner& corner) {
    const auto [det, lengths2] = corner_at(corner, x);
    return det > 0 && det * det >= bound * lengths2;
  });
}

double least_jacobian(std::span<const CellCorner> corners, std::span<const Vec3> x, double best = kOfEquilateral) {
  double least = 1;  // signed square
  for (const CellCorner& corner : corners) {
    const auto [det, lengths2] = corner_at(corner, x);
    least = std::min(least, lengths2 > 0 ? det * std::abs(det) / lengths2 : 0);
  }
  return std::min(1.0, std::copysign(std::sqrt(std::abs(least)), least) / best);
}

}  // namespace

bool is_positive(const std::array<Vec3, 6>& prism) {
  return are_positive(kPrismCorners, prism) && are_positive(kOtherPrismTets, prism);
}
bool is_positive(const std::array<Vec3, 8>& hex) {
  constexpr std::array<std::array<std::uint8_t, 3>, 4> kHalves{{{0, 1, 2}, {0, 2, 3}, {0, 1, 3}, {1, 2, 3}}};
  return std::ranges::all_of(kHalves, [&](const auto& half) {
    const auto& [a, b, c] = half;
    return is_positive(std::array{hex[a], hex[b], hex[c], hex[a + 4u], hex[b + 4u], hex[c + 4u]});
  });
}
bool is_positive(const std::array<Vec3, 5>& pyramid) { return are_positive(kPyramidCorners, pyramid); }
bool is_positive(const std::array<Vec3, 4>& tet) { return are_positive(kTetCorners, tet); }

bool is_sound(const std::array<Vec3, 8>& hex, double least) {
  return are_sound(kHexCorners, hex, least) && is_positive(hex);
}
bool is_sound(const std::array<Vec3, 6>& prism, double least) {
  return are_sound(kPrismCorners, prism, least * kOfEquilateral) && are_positive(kOtherPrismTets, prism);
}
bool is_sound(const std::array<Vec3, 5>& pyramid, double least) {
  return are_sound(kPyramidCorners, pyramid, least * kOfEquilateral);
}
bool is_sound(const std::array<Vec3, 4>& tet, double least) {
  return are_sound(kTetCorners, tet, least * kOfEquilateral);
}

double scaled_jacobian(const std::array<Vec3, 8>& hex) { return least_jacobian(kHexCorners, hex, 1); }
double scaled_jacobian(const std::array<Vec3, 6>& prism) { return least_jacobian(kPrismCorners, prism); }
double scaled_jacobian(const std::array<Vec3, 5>& pyramid) { return least_jacobian(kPyramidCorners, pyramid); }
double scaled_jacobian(const std::array<Vec3, 4>& tet) { return least_jacobian(kTetCorners, tet); }

}  // namespace tetloom::layers
