#include "core/mesh/curved_cell.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

namespace tetloom {
namespace {

constexpr std::size_t kMostVerts = 8, kMostEdges = 12;

// Derivatives of the functions of vertices and mid nodes along three directions at one place. Functions of vertices are
// those of the straight cell: what bends is the mid nodes' alone.
struct Slopes {
  std::array<Vec3, kMostVerts> of_verts{};
  std::array<Vec3, kMostEdges> of_mids{};
};

// A linear function of one coordinate that is 1 at `end`, 0 or 1, and 0 at the other; and its slope.
double linear(int end, double x) { return end == 1 ? x : 1 - x; }
double slope(int end) { return end == 1 ? 1 : -1; }

// Places of the corners of the base in turn.
constexpr std::array<std::array<int, 2>, 4> kBase{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};

double bump(double x) { return 4 * x * (1 - x); }
double bump_slope(double x) { return 4 - 8 * x; }

Slopes hex_slopes(double u, double v, double w) {
  const auto corner_of = [](std::size_t i) { return std::array{kBase[i % 4][0], kBase[i % 4][1], i < 4 ? 0 : 1}; };
  const std::array x{u, v, w};
  Slopes slopes;
  for (std::size_t i = 0; i < 8; ++i) {
    const auto [a, b, c] = corner_of(i);
    slopes.of_verts[i] = {slope(a) * linear(b, v) * linear(c, w), linear(a, u) * slope(b) * linear(c, w),
                          linear(a, u) * linear(b, v) * slope(c)};
  }
  const CellShape& shape = shape_of(CellKind::Hex);
  for (std::size_t e = 0; e < shape.edge_count; ++e) {
    const auto one = corner_of(shape.edge[e][0]), other = corner_of(shape.edge[e][1]);
    for (std::size_t along = 0; along < 3; ++along) {
      double value = 1;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool is_edge = one[axis] != other[axis];
        const double factor = is_edge ? bump(x[axis]) : linear(one[axis], x[axis]);
        const double change = is_edge ? bump_slope(x[axis]) : slope(one[axis]);
        value *= axis == along ? change : factor;
      }
      slopes.of_mids[e][static_cast<int>(along)] = value;
    }
  }
  return slopes;
}

// With the triangle's coordinates r = u (1 - v) and s = v; along r, s and w.
Slopes prism_slopes(double u, double v, double w) {
  const std::array<double, 3> l{1 - u * (1 - v) - v, u * (1 - v), v};
  constexpr std::array<std::array<double, 2>, 3> kChange{{{-1, -1}, {1, 0}, {0, 1}}};
  Slopes slopes;
  for (std::size_t i = 0; i < 6; ++i) {
    const std::size_t c = i % 3;
    const int up = i < 3 ? 0 : 1;
    slopes.of_verts[i] = {kChange[c][0] * linear(up, w), kChange[c][1] * linear(up, w), l[c] * slope(up)};
  }
  const CellShape& shape = shape_of(CellKind::Prism);
  for (std::size_t e = 0; e < shape.edge_count; ++e) {
    const std::size_t i = shape.edge[e][0] % 3, j = shape.edge[e][1] % 3;
    const int up = shape.edge[e][0] < 3 ? 0 : 1;
    if (i == j) {
      slopes.of_mids[e] = {kChange[i][0] * bump(w), kChange[i][1] * bump(w), l[i] * bump_slope(w)};
      continue;
    }
    const auto along = [&](std::size_t k) { return 4 * (kChange[i][k] * l[j] + l[i] * kChange[j][k]) * linear(up, w); };
    slopes.of_mids[e] = {along(0), along(1), 4 * l[i] * l[j] * slope(up)};
  }
  return slopes;
}

// A cube that narrows towards w = 1; along u and v divided by 1 - w, and along w.
Slopes pyramid_slopes(double u, double v, double w) {
  Slopes slopes;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto [a, b] = kBase[i];
    const double across = linear(a, u) * linear(b, v);
    slopes.of_verts[i] = {slope(a) * linear(b, v), linear(a, u) * slope(b), -across};
    slopes.of_mids[4 + i] = {4 * w * slope(a) * linear(b, v), 4 * w * linear(a, u) * slope(b), bump_slope(w) * across};
    const auto [c, d] = kBase[(i + 1) % 4];
    const double x = a != c ? bump(u) : linear(a, u), dx = a != c ? bump_slope(u) : slope(a);
    const double y = b != d ? bump(v) : linear(b, v), dy = b != d ? bump_slope(v) : slope(b);
    slopes.of_mids[i] = {dx * y * (1 - w), x * dy * (1 - w), -2 * x * y * (1 - w)};
  }
  slopes.of_verts[4] = {0, 0, 1};
  return slopes;
}

Slopes slopes_at(CellKind kind, double u, double v, double w) {
  if (kind == CellKind::Prism) return prism_slopes(u, v, w);
  return kind == CellKind::Pyramid ? pyramid_slopes(u, v, w) : hex_slopes(u, v, w);
}

// From the values of a polynomial at equal steps from 0 to 1 to its Bézier coefficients, row by row.
std::vector<double> to_coefficients(std::size_t count) {
  const std::size_t degree = count - 1;
  std::vector<double> left(count * count), right(count * count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    const double x = static_cast<double>(i) / static_cast<double>(degree);
    double binomial = 1;
    for (std::size_t j = 0; j < count; ++j) {
      left[i * count + j] =
          binomial * std::pow(x, static_cast<double>(j)) * std::pow(1 - x, static_cast<double>(degree - j));
      binomial = binomial * static_cast<double>(degree - j) / static_cast<double>(j + 1);
    }
    right[i * count + i] = 1;
  }
  // Gauss and Jordan: at most 6 x 6, the diagonal is the largest of its column below.
  for (std::size_t p = 0; p < count; ++p) {
    const double pivot = left[p * count + p];
    for (std::size_t j = 0; j < count; ++j) left[p * count + j] /= pivot, right[p * count + j] /= pivot;
    for (std::size_t i = 0; i < count; ++i) {
      if (i == p) continue;
      const double factor = left[i * count + p];
      for (std::size_t j = 0; j < count; ++j) {
        left[i * count + j] -= factor * left[p * count + j];
        right[i * count + j] -= factor * right[p * count + j];
      }
    }
  }
  return right;
}

using Counts = std::array<std::size_t, 3>;

// The determinant of one kind of cell as a polynomial on a cube: where it is sampled, and with which slopes.
class Basis {
 public:
  // One more than the degrees along u, v and w.
  Basis(CellKind kind, const Counts& counts) : kind_(kind), counts_(counts) {
    for (std::size_t axis = 0; axis < 3; ++axis) to_coefficients_[axis] = tetloom::to_coefficients(counts[axis]);
    const auto at = [&](std::size_t i, std::size_t axis) {
      return static_cast<double>(i) / static_cast<double>(counts_[axis] - 1);
    };
    for (std::size_t k = 0; k < counts[2]; ++k)
      for (std::size_t j = 0; j < counts[1]; ++j)
        for (std::size_t i = 0; i < counts[0]; ++i) {
          samples_.push_back(slopes_at(kind, at(i, 0), at(j, 1), at(k, 2)));
          weights_.push_back(weight(i, 0) * weight(j, 1) * weight(k, 2));
        }
  }
  const Counts& counts() const { return counts_; }

  std::vector<double> coefficients(const CurvedCell& cell) const {
    std::vector<double> values(samples_.size());
    for (std::size_t s = 0; s < samples_.size(); ++s) values[s] = determinant(cell, samples_[s]);
    for (std::size_t axis = 0, step = 1; axis < 3; step *= counts_[axis++]) change_lines(values, axis, step);
    return values;
  }

  double integral(std::span<const double> coefficients) const {
    double sum = 0;
    for (std::size_t c = 0; c < coefficients.size(); ++c) sum += weights_[c] * coefficients[c];
    return sum;
  }

 private:
  double determinant(const CurvedCell& cell, const Slopes& slopes) const {
    const CellShape& shape = shape_of(kind_);
    Vec3 a, b, c;
    const auto add = [&](const Vec3& slope, const Vec3& x) { a += slope.x * x, b += slope.y * x, c += slope.z * x; };
    // From the first vertex, so that small cells far from the origin lose nothing.
    for (std::size_t v = 1; v < shape.vertex_count; ++v) add(slopes.of_verts[v], cell.verts[v] - cell.verts[0]);
    for (std::size_t e = 0; e < shape.edge_count; ++e)
      if (cell.bends[e] != Vec3{}) add(slopes.of_mids[e], cell.bends[e]);
    return dot(cross(a, b), c);
  }

  void change_lines(std::vector<double>& values, std::size_t axis, std::size_t step) const {
    const std::size_t count = counts_[axis];
    const std::vector<double>& matrix = to_coefficients_[axis];
    std::array<double, 6> line{};
    for (std::size_t first = 0; first < values.size(); ++first) {
      if (first / step % count != 0) continue;
      for (std::size_t i = 0; i < count; ++i) line[i] = values[first + i * step];
      for (std::size_t i = 0; i < count; ++i) {
        double sum = 0;
        for (std::size_t j = 0; j < count; ++j) sum += matrix[i * count + j] * line[j];
        values[first + i * step] = sum;
      }
    }
  }

  // The integral of a Bézier polynomial times the factor that was divided out: (1 - v) of a prism, (1 - w)^2 of a
  // pyramid.
  double weight(std::size_t at, std::size_t axis) const {
    const double n = static_cast<double>(counts_[axis]), left = n - static_cast<double>(at);
    if (kind_ == CellKind::Prism && axis == 1) return left / (n * (n + 1));
    if (kind_ == CellKind::Pyramid && axis == 2) return left * (left + 1) / (n * (n + 1) * (n + 2));
    return 1 / n;
  }

  CellKind kind_;
  Counts counts_;
  std::vector<Slopes> samples_;  // u fastest
  std::vector<double> weights_;  // of coefficients in the integral
  std::array<std::vector<double>, 3> to_coefficients_;
};

const Basis& basis_of(const CurvedCell& cell) {
  static const Basis hex(CellKind::Hex, {6, 6, 6}), pyramid(CellKind::Pyramid, {6, 6, 4});
  static const Basis prism(CellKind::Prism, {5, 5, 6}), upright(CellKind::Prism, {5, 5, 3});
  if (cell.kind == CellKind::Hex) return hex;
  if (cell.kind == CellKind::Pyramid) return pyramid;
  // With straight edges between its triangles a prism is linear from one to the other.
  const bool is_upright = std::all_of(&cell.bends[6], &cell.bends[9], [](const Vec3& bend) { return bend == Vec3{}; });
  return is_upright ? upright : prism;
}

struct CellPiece {
  std::vector<double> coefficients;
  int depth = 0;
};

// The two halves along an axis (de Casteljau).
std::array<CellPiece, 2> halves_of(const CellPiece& piece, const Counts& counts, std::size_t axis) {
  std::array<CellPiece, 2> halves{piece, piece};
  for (CellPiece& half : halves) ++half.depth;
  const std::size_t count = counts[axis], step = axis == 0 ? 1 : axis == 1 ? counts[0] : counts[0] * counts[1];
  std::array<double, 6> value{};
  for (std::size_t first = 0; first < piece.coefficients.size(); ++first) {
    if (first / step % count != 0) continue;
    for (std::size_t i = 0; i < count; ++i) value[i] = piece.coefficients[first + i * step];
    for (std::size_t left = count; left > 0; --left) {
      halves[0].coefficients[first + (count - left) * step] = value[0];
      halves[1].coefficients[first + (left - 1) * step] = value[left - 1];
      for (std::size_t i = 0; i + 1 < left; ++i) value[i] = 0.5 * (value[i] + value[i + 1]);
    }
  }
  return halves;
}

double least_of(std::span<const double> values) { return *std::ranges::min_element(values); }

// The least of the values at the corners of the cube.
double least_at_corners(std::span<const double> coefficients, const Counts& counts) {
  double least = HUGE_VAL;
  const std::array steps{counts[0] - 1, (counts[1] - 1) * counts[0], (counts[2] - 1) * counts[0] * counts[1]};
  for (std::size_t corner = 0; corner < 8; ++corner)
    least = std::min(least,
                     coefficients[(corner & 1) * steps[0] + (corner >> 1 & 1) * steps[1] + (corner >> 2) * steps[2]]);
  return least;
}

double least_of_straight(const CurvedCell& cell) {
  double least = HUGE_VAL;
  for (const auto& [o, a, b, c] : corners_of(cell.kind)) {
    const Vec3& x = cell.verts[o];
    least = std::min(least, dot(cross(cell.verts[a] - x, cell.verts[b] - x), cell.verts[c] - x));
  }
  return least;
}

}  // namespace

bool CurvedCell::is_straight() const {
  return std::all_of(bends.begin(), bends.begin() + edge_count(), [](const Vec3& bend) { return bend == Vec3{}; });
}

CurvedCell curved_cell_of(const Mesh& mesh, const MidNodes& mids, CellKind kind, std::span<const std::uint32_t> verts) {
  CurvedCell cell{kind, {}, {}};
  for (std::size_t v = 0; v < verts.size(); ++v) cell.verts[v] = mesh.points[verts[v]];
  const std::size_t first_mid = vertex_count(mesh);
  const CellMids own(kind, verts, mids);
  for (std::size_t e = 0; e < own.size(); ++e)
    cell.bends[e] = mesh.points[first_mid + own[e]] - middle_of_edge(mesh, own[e]);
  return cell;
}

CellJacobian cell_jacobian(const CurvedCell& cell) {
  const Basis& basis = basis_of(cell);
  CellJacobian jacobian{basis.coefficients(cell), basis.counts(), 0};
  jacobian.volume = basis.integral(jacobian.coefficients);
  const double straight = least_of_straight(cell);
  for (double& coefficient : jacobian.coefficients)
    coefficient = straight > 0 ? coefficient / straight : -std::numeric_limits<double>::infinity();
  return jacobian;
}

double least_jacobian(const CellJacobian& jacobian, double enough) {
  constexpr double kPrecision = 1e-3;
  constexpr int kMostHalvings = 24;
  const Counts& counts = jacobian.counts;
  double found = least_at_corners(jacobian.coefficients, counts), bound = enough;
  if (const double first = least_of(jacobian.coefficients); first >= enough || !(found - first > kPrecision))
    return first;
  std::vector<CellPiece> open{{jacobian.coefficients, 0}};
  while (!open.empty()) {
    const CellPiece piece = std::move(open.back());
    open.pop_back();
    found = std::min(found, least_at_corners(piece.coefficients, counts));
    const double lowest = least_of(piece.coefficients);
    if (lowest >= enough) continue;
    if (lowest >= found - kPrecision || piece.depth == kMostHalvings) {
      bound = std::min(bound, lowest);
      continue;
    }
    for (CellPiece& half : halves_of(piece, counts, static_cast<std::size_t>(piece.depth) % 3))
      open.push_back(std::move(half));
  }
  return bound;
}

bool has_positive_jacobian(const CellJacobian& jacobian) {
  constexpr double kEnough = 1e-9;
  return least_jacobian(jacobian, kEnough) > 0;
}

}  // namespace tetloom
