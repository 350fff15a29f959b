// Curved pyramids, prisms and hexahedra: the bound of their Jacobian against the shape functions of their nodes.
#include "core/mesh/curved_cell.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include "tests/support/mixed_mesh.hpp"
#include "tests/support/second_order_mesh.hpp"
#include "tetloom/check.hpp"

using namespace tetloom;
using test::with_mid_nodes;

namespace {

constexpr std::array kKinds{CellKind::Pyramid, CellKind::Prism, CellKind::Hex};

CurvedCell curved_reference(CellKind kind) {
  CurvedCell cell{kind, {}, {}};
  switch (kind) {
    case CellKind::Pyramid: cell.verts = {{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}, {0, 0, 1}}}; break;
    case CellKind::Prism: cell.verts = {{{0, 0, -1}, {1, 0, -1}, {0, 1, -1}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}}}; break;
    default:
      cell.verts = {
          {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};
  }
  return cell;
}

/// The nodal functions as text books have them: vertices, then mid nodes in the order of kCellShapes.
std::vector<double> nodal_functions(CellKind kind, const Vec3& x) {
  const CurvedCell at = curved_reference(kind);
  const CellShape& shape = shape_of(kind);
  std::vector<double> values(shape.vertex_count + shape.edge_count);
  if (kind == CellKind::Prism) {
    const std::array<double, 3> l{1 - x.x - x.y, x.x, x.y};
    for (std::size_t v = 0; v < 6; ++v) {
      const double up = 1 + (v < 3 ? -x.z : x.z), c = l[v % 3];
      values[v] = 0.5 * c * (2 * c - 1) * up - 0.5 * c * (1 - x.z * x.z);
    }
    for (std::size_t e = 0; e < 9; ++e) {
      const auto [a, b] = shape.edge[e];
      values[6 + e] = e < 6 ? 2 * l[a % 3] * l[b % 3] * (1 + (e < 3 ? -x.z : x.z)) : l[a % 3] * (1 - x.z * x.z);
    }
  } else if (kind == CellKind::Hex) {
    for (std::size_t v = 0; v < 8; ++v) {
      const Vec3& n = at.verts[v];
      values[v] = (1 + n.x * x.x) * (1 + n.y * x.y) * (1 + n.z * x.z) * (n.x * x.x + n.y * x.y + n.z * x.z - 2) / 8;
    }
    for (std::size_t e = 0; e < 12; ++e) {
      const Vec3 n = 0.5 * (at.verts[shape.edge[e][0]] + at.verts[shape.edge[e][1]]);
      values[8 + e] = 0.25;
      for (int axis = 0; axis < 3; ++axis)
        values[8 + e] *= n[axis] == 0 ? 1 - x[axis] * x[axis] : 1 + n[axis] * x[axis];
    }
  } else {
    const double left = 1 - x.z;
    for (std::size_t v = 0; v < 4; ++v) {
      const double a = at.verts[v].x * x.x, b = at.verts[v].y * x.y;
      values[v] = 0.25 * (a + b - 1) * ((1 + a) * (1 + b) - x.z + a * b * x.z / left);
      values[9 + v] = x.z * (left + a) * (left + b) / left;
      const Vec3 n = 0.5 * (at.verts[v] + at.verts[(v + 1) % 4]);
      const double along = n.x == 0 ? x.x : x.y, across = n.x == 0 ? n.y * x.y : n.x * x.x;
      values[5 + v] = 0.5 * (left - along) * (left + along) * (left + across) / left;
    }
    values[4] = x.z * (2 * x.z - 1);
  }
  return values;
}

/// By central differences.
double sampled_determinant(const CurvedCell& cell, const Vec3& x) {
  constexpr double kStep = 1e-5;
  const CellShape& shape = shape_of(cell.kind);
  const auto place = [&](const Vec3& at) {
    const std::vector<double> values = nodal_functions(cell.kind, at);
    Vec3 sum;
    for (std::size_t v = 0; v < shape.vertex_count; ++v) sum += values[v] * cell.verts[v];
    for (std::size_t e = 0; e < shape.edge_count; ++e) {
      const auto [a, b] = shape.edge[e];
      sum += values[shape.vertex_count + e] * (0.5 * (cell.verts[a] + cell.verts[b]) + cell.bends[e]);
    }
    return sum;
  };
  std::array<Vec3, 3> columns;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 low = x, high = x;
    low[axis] -= kStep, high[axis] += kStep;
    columns[static_cast<std::size_t>(axis)] = (place(high) - place(low)) / (2 * kStep);
  }
  return dot(cross(columns[0], columns[1]), columns[2]);
}

/// Over that of the straight reference cell, which is the same everywhere.
double least_sampled(const CurvedCell& cell) {
  constexpr int kSteps = 10;
  double least = HUGE_VAL;
  for (int k = 0; k <= kSteps; ++k)
    for (int j = 0; j <= kSteps; ++j)
      for (int i = 0; i <= kSteps; ++i) {
        const double u = i / 10.0, v = j / 10.0, w = k / 10.0;
        Vec3 x{2 * u - 1, 2 * v - 1, 2 * w - 1};
        if (cell.kind == CellKind::Prism) x = {u * (1 - v), v, 2 * w - 1};
        if (cell.kind == CellKind::Pyramid) x = {(2 * u - 1) * (1 - 0.99 * w), (2 * v - 1) * (1 - 0.99 * w), 0.99 * w};
        least = std::min(least, sampled_determinant(cell, x));
      }
  return least;
}

CurvedCell bent(CellKind kind, unsigned seed, double by) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-by, by);
  CurvedCell cell = curved_reference(kind);
  for (std::size_t e = 0; e < cell.edge_count(); ++e) cell.bends[e] = {any(random), any(random), any(random)};
  return cell;
}

}  // namespace

TEST_CASE("straight cells of any kind have the Jacobian of their corners throughout") {
  for (const CellKind kind : kKinds) {
    const CurvedCell cell = curved_reference(kind);
    CHECK(cell.is_straight());
    CHECK(least_jacobian(cell_jacobian(cell), 0.5) == Approx(1));
    CHECK(has_positive_jacobian(cell_jacobian(cell)));
    CHECK(cell_jacobian(cell).volume == Approx(kind == CellKind::Hex ? 8 : kind == CellKind::Prism ? 1 : 4.0 / 3));
  }
}

TEST_CASE("the bound is below the Jacobian that the nodes' functions have, and not far below") {
  for (const CellKind kind : kKinds) {
    for (unsigned seed = 1; seed <= 12; ++seed) {
      const CurvedCell cell = bent(kind, seed, seed * 0.02);
      CHECK_FALSE(cell.is_straight());
      const double bound = least_jacobian(cell_jacobian(cell), 2), sampled = least_sampled(cell);
      INFO(to_string(kind) << " " << seed);
      CHECK(bound <= sampled + 1e-6);
      CHECK(bound > sampled - 0.15);
      if (std::abs(sampled) > 0.05) CHECK(has_positive_jacobian(cell_jacobian(cell)) == (sampled > 0));
    }
  }
}

TEST_CASE("a cell that is inverted at one place alone is not positive") {
  for (const CellKind kind : kKinds) {
    CurvedCell cell = curved_reference(kind);
    cell.bends[0] = {0, 0, 2.2};
    CHECK(least_sampled(cell) < 0);
    CHECK_FALSE(has_positive_jacobian(cell_jacobian(cell)));
    CurvedCell flat = curved_reference(kind);
    flat.verts[3] = flat.verts[0];
    flat.bends[0] = {0, 0, 0.01};
    CHECK_FALSE(has_positive_jacobian(cell_jacobian(flat)));
  }
}

TEST_CASE("bent faces between cells take from one volume what they give to the other") {
  for (const CellKind kind : kKinds) {
    // A face of the base that bulges outwards by a parabola: the edge 0 1 by .1 towards -y and -z.
    CurvedCell cell = curved_reference(kind);
    const double before = cell_jacobian(cell).volume;
    cell.bends[0] = {0, 0, -0.1};
    CHECK(cell_jacobian(cell).volume > before);
    cell.bends[0] = {0, 0, 0.1};
    CHECK(cell_jacobian(cell).volume < before);
  }
  // Whatever the mid nodes inside are, the box has the volume that its boundary bounds.
  const Mesh straight = test::make_mixed_box(3, 3, 4);
  const auto inside = [&](const Vec3& x) {
    const double f = x.x * (3 - x.x) * x.y * (3 - x.y) * x.z * (4 - x.z);
    return Vec3{0.004 * f, 0.003 * f, -0.002 * f};
  };
  const Mesh mesh = with_mid_nodes(straight, inside);
  const QualityReport quality = compute_quality(mesh);
  CHECK(quality.curved.count > 20);
  CHECK(quality.curved.not_positive == 0);
  CHECK(quality.curved.volume == Approx(36).epsilon(1e-10));
  CHECK(validate_mesh(mesh).valid());
}

TEST_CASE("inverted cells of second order are a problem of the mesh, whatever their kind") {
  const Mesh straight = test::make_mixed_box(2, 2, 4);
  Mesh mesh = with_mid_nodes(straight);
  CHECK(compute_quality(mesh).curved.count == 0);
  const MidNodes mids(mesh);
  const std::uint32_t mid = CellMids(CellKind::Hex, mesh.hex_to_vert.front(), mids)[8];
  mesh.points[vertex_count(mesh) + mid] += Vec3{3, 3, 0};
  const ValidationReport report = validate_mesh(mesh);
  REQUIRE_FALSE(report.valid());
  for (const auto& problem : report.problems) CHECK(problem.kind == ProblemKind::NonPositiveJacobian);
  CHECK(compute_quality(mesh).curved.not_positive == report.problems[0].count);
}
