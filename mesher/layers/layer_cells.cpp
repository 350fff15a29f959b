#include "mesher/layers/layer_cells.hpp"

#include <span>

#include "core/predicates/predicates.hpp"

namespace tetloom::layers {
namespace {

// Beside the tets of its corners.
constexpr std::array<CellCorner, 12> kPrismTets{{{0, 1, 2, 3},
                                                 {0, 1, 2, 4},
                                                 {0, 1, 2, 5},
                                                 {3, 5, 4, 0},
                                                 {3, 5, 4, 1},
                                                 {3, 5, 4, 2},
                                                 {0, 1, 5, 3},
                                                 {0, 1, 5, 4},
                                                 {1, 2, 3, 4},
                                                 {1, 2, 3, 5},
                                                 {2, 0, 4, 3},
                                                 {2, 0, 4, 5}}};

bool are_positive(std::span<const CellCorner> tets, std::span<const Vec3> x) {
  return std::ranges::all_of(
      tets, [&](const CellCorner& tet) { return orient3d(x[tet[0]], x[tet[1]], x[tet[2]], x[tet[3]]) > 0; });
}

double least_jacobian(std::span<const CellCorner> corners, std::span<const Vec3> x) {
  constexpr double kOfEquilateral = 0.8660254037844386;
  double least = 1;
  for (const auto& [o, a, b, c] : corners) {
    const Vec3 u = x[a] - x[o], v = x[b] - x[o], w = x[c] - x[o];
    const double lengths = norm(u) * norm(v) * norm(w);
    least = std::min(least, lengths > 0 ? dot(cross(u, v), w) / (lengths * kOfEquilateral) : 0);
  }
  return least;
}

}  // namespace

bool is_positive(const std::array<Vec3, 6>& prism) { return are_positive(kPrismTets, prism); }
bool is_positive(const std::array<Vec3, 5>& pyramid) { return are_positive(kPyramidCorners, pyramid); }
bool is_positive(const std::array<Vec3, 4>& tet) { return are_positive(kTetCorners, tet); }

double scaled_jacobian(const std::array<Vec3, 6>& prism) { return least_jacobian(kPrismCorners, prism); }
double scaled_jacobian(const std::array<Vec3, 5>& pyramid) { return least_jacobian(kPyramidCorners, pyramid); }
double scaled_jacobian(const std::array<Vec3, 4>& tet) { return least_jacobian(kTetCorners, tet); }

}  // namespace tetloom::layers
