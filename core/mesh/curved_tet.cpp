#include "core/mesh/curved_tet.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace tetloom {
namespace {

// How often each vertex counts in a coefficient; three in all.
using Exponents = std::array<std::uint8_t, 4>;

constexpr std::size_t kCoefficients = 20;

// Those of the vertices first.
constexpr std::array<Exponents, kCoefficients> kExponents = [] {
  std::array<Exponents, kCoefficients> all{};
  for (std::size_t i = 0; i < 4; ++i) all[i][i] = 3;
  std::size_t next = 4;
  for (std::uint8_t a = 0; a < 3; ++a)
    for (std::uint8_t b = 0; a + b <= 3; ++b)
      for (std::uint8_t c = 0; a + b + c <= 3; ++c) {
        const Exponents e{a, b, c, static_cast<std::uint8_t>(3 - a - b - c)};
        if (b < 3 && c < 3 && e[3] < 3) all[next++] = e;
      }
  return all;
}();

constexpr std::uint8_t find_exponents(const Exponents& e) {
  for (std::uint8_t i = 0; i < kCoefficients; ++i)
    if (kExponents[i] == e) return i;
  return kCoefficients;
}

// The coefficient to which a product of three linear functions belongs, by the vertices of those.
constexpr auto kProducts = [] {
  std::array<std::array<std::array<std::uint8_t, 4>, 4>, 4> products{};
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j < 4; ++j)
      for (std::size_t k = 0; k < 4; ++k) {
        Exponents e{};
        ++e[i], ++e[j], ++e[k];
        products[i][j][k] = find_exponents(e);
      }
  return products;
}();

// How many of the 64 products belong to each.
constexpr std::array<double, kCoefficients> kProductCounts = [] {
  std::array<double, kCoefficients> counts{};
  for (const auto& plane : kProducts)
    for (const auto& row : plane)
      for (const std::uint8_t at : row) ++counts[at];
  return counts;
}();

constexpr std::array<std::array<std::uint8_t, 4>, 4> kMidOfCorners = [] {
  std::array<std::array<std::uint8_t, 4>, 4> mids{};
  const CellShape& shape = shape_of(CellKind::Tet);
  for (std::uint8_t e = 0; e < shape.edge_count; ++e) {
    const auto [a, b] = shape.edge[e];
    mids[a][b] = mids[b][a] = static_cast<std::uint8_t>(4 + e);
  }
  return mids;
}();

// Rows of coefficients along which the exponents of two vertices share what those of the others leave.
struct Row {
  std::uint8_t count = 0;
  std::array<std::uint8_t, 4> at{};  // from all at the first vertex to all at the second
};

constexpr std::size_t kRows = 10;  // the others' exponents: (0,0), (0,1), (1,0), ...

constexpr std::array<Row, kRows> rows_of(std::size_t a, std::size_t b) {
  std::array<Row, kRows> rows{};
  std::array<std::size_t, 2> others{};
  for (std::size_t v = 0, n = 0; v < 4; ++v)
    if (v != a && v != b) others[n++] = v;
  std::size_t next = 0;
  for (std::uint8_t c = 0; c <= 3; ++c)
    for (std::uint8_t d = 0; c + d <= 3; ++d) {
      const auto rest = static_cast<std::uint8_t>(3 - c - d);
      Row& row = rows[next++];
      row.count = static_cast<std::uint8_t>(rest + 1);
      for (std::uint8_t i = 0; i <= rest; ++i) {
        Exponents e{};
        e[others[0]] = c, e[others[1]] = d, e[a] = static_cast<std::uint8_t>(rest - i), e[b] = i;
        row.at[i] = find_exponents(e);
      }
    }
  return rows;
}

constexpr std::array<std::array<Row, kRows>, 6> kRowsOfEdges = [] {
  std::array<std::array<Row, kRows>, 6> all{};
  const CellShape& shape = shape_of(CellKind::Tet);
  for (std::size_t e = 0; e < 6; ++e) all[e] = rows_of(shape.edge[e][0], shape.edge[e][1]);
  return all;
}();

struct TetPiece {
  TetJacobian jacobian;
  int depth = 0;
};

// The polynomial on the two halves of the tet that the middle of an edge makes (de Casteljau).
std::array<TetPiece, 2> halves_of(const TetPiece& piece, std::size_t edge) {
  std::array<TetPiece, 2> halves{piece, piece};
  for (TetPiece& half : halves) ++half.depth;
  for (const Row& row : kRowsOfEdges[edge]) {
    std::array<double, 4> value{};
    for (std::size_t i = 0; i < row.count; ++i) value[i] = piece.jacobian[row.at[i]];
    for (std::size_t left = row.count; left > 0; --left) {
      halves[0].jacobian[row.at[row.count - left]] = value[0];
      halves[1].jacobian[row.at[left - 1]] = value[left - 1];
      for (std::size_t i = 0; i + 1 < left; ++i) value[i] = 0.5 * (value[i] + value[i + 1]);
    }
  }
  return halves;
}

double least(std::span<const double> values) { return *std::ranges::min_element(values); }

}  // namespace

TetNodes nodes_of_tet(const Mesh& mesh, const MidNodes& mids, std::size_t t) {
  const auto& verts = mesh.tet_to_vert[t];
  TetNodes nodes;
  for (std::size_t i = 0; i < 4; ++i) nodes[i] = mesh.points[verts[i]];
  const std::size_t first = vertex_count(mesh);
  const CellMids own(CellKind::Tet, mesh.tet_to_vert[t], mids);
  for (std::size_t e = 0; e < 6; ++e) nodes[4 + e] = mesh.points[first + own[e]];
  return nodes;
}

bool is_straight_tet(const Mesh& mesh, const MidNodes& mids, std::size_t t) {
  const CellMids own(CellKind::Tet, mesh.tet_to_vert[t], mids);
  return std::ranges::all_of(
      own, [&](std::uint32_t m) { return mesh.points[vertex_count(mesh) + m] == middle_of_edge(mesh, m); });
}

bool has_positive_jacobian(const Mesh& mesh, const MidNodes& mids, std::size_t t) {
  constexpr double kEnough = 1e-9;
  return least_jacobian(tet_jacobian(nodes_of_tet(mesh, mids, t)), kEnough) > 0;
}

// With control points b_ii = x_i and b_ij = 2 m_ij - (x_i + x_j) / 2 the derivative along the edge from vertex 0 to k
// is twice the sum of l_i (b_ik - b_i0) over the barycentric coordinates l_i.
TetJacobian tet_determinant(const TetNodes& nodes) {
  std::array<std::array<Vec3, 4>, 4> control;
  for (std::size_t i = 0; i < 4; ++i) {
    control[i][i] = nodes[i];
    for (std::size_t j = 0; j < i; ++j)
      control[i][j] = control[j][i] = 2 * nodes[kMidOfCorners[i][j]] - 0.5 * (nodes[i] + nodes[j]);
  }
  std::array<std::array<Vec3, 4>, 3> along;
  for (std::size_t k = 0; k < 3; ++k)
    for (std::size_t i = 0; i < 4; ++i) along[k][i] = control[i][k + 1] - control[i][0];
  TetJacobian sums{};
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec3 normal = cross(along[1][j], along[2][k]);
      for (std::size_t i = 0; i < 4; ++i) sums[kProducts[i][j][k]] += dot(along[0][i], normal);
    }
  for (std::size_t c = 0; c < kCoefficients; ++c) sums[c] *= 8 / kProductCounts[c];
  return sums;
}

TetJacobian tet_jacobian(const TetNodes& nodes) {
  TetJacobian jacobian = tet_determinant(nodes);
  const double straight = dot(nodes[1] - nodes[0], cross(nodes[2] - nodes[0], nodes[3] - nodes[0]));
  for (double& coefficient : jacobian) coefficient /= straight;
  return jacobian;
}

double least_jacobian(const TetJacobian& jacobian, double enough) {
  constexpr double kPrecision = 1e-3;
  constexpr int kMostHalvings = 24;
  double found = least(std::span(jacobian).first(4)), bound = enough;
  if (const double first = least(jacobian); first >= enough || !(found - first > kPrecision)) return first;
  std::vector<TetPiece> open{{jacobian, 0}};
  while (!open.empty()) {
    const TetPiece piece = open.back();
    open.pop_back();
    found = std::min(found, least(std::span(piece.jacobian).first(4)));
    const double lowest = least(piece.jacobian);
    if (lowest >= enough) continue;
    if (lowest >= found - kPrecision || piece.depth == kMostHalvings) {
      bound = std::min(bound, lowest);
      continue;
    }
    for (const TetPiece& half : halves_of(piece, static_cast<std::size_t>(piece.depth) % 6)) open.push_back(half);
  }
  return bound;
}

double mean_jacobian(const TetJacobian& jacobian) {
  return std::accumulate(jacobian.begin(), jacobian.end(), 0.0) / static_cast<double>(kCoefficients);
}

}  // namespace tetloom
