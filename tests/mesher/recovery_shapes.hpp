#pragma once
// Surfaces for the tests of the boundary recovery, all free of self-intersections.
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <utility>
#include <vector>

#include "mesher/tets/obstacles.hpp"
#include "mesher/tets/segment_triangle.hpp"

namespace tetloom::tets::recovery_tests {

struct Shape {
  std::vector<Vec3> points;
  std::vector<TriangleVerts> triangles;

  void append(const Shape& other) {
    const auto offset = static_cast<std::uint32_t>(points.size());
    points.insert(points.end(), other.points.begin(), other.points.end());
    for (const auto& t : other.triangles) triangles.push_back({t[0] + offset, t[1] + offset, t[2] + offset});
  }
};

/// A prism over a regular n-gon whose upper end is turned against the diagonals of its sides. For n = 3 and a turn
/// of 30 degrees that of Schönhardt (1928), which has no tetrahedra between its own points.
inline Shape twisted_prism(std::uint32_t n, double turn, double height = 1) {
  Shape shape;
  for (std::uint32_t k = 0; k < 2 * n; ++k) {
    const double angle = 2 * std::numbers::pi * (k % n) / n + (k < n ? 0 : turn);
    shape.points.push_back({std::cos(angle), std::sin(angle), k < n ? 0 : height});
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    const std::uint32_t next = (k + 1) % n;
    shape.triangles.push_back({k, next, n + k});
    shape.triangles.push_back({next, n + next, n + k});
    if (k >= 2) shape.triangles.push_back({0, k, k - 1});
    if (k >= 2) shape.triangles.push_back({n, n + k - 1, n + k});
  }
  return shape;
}

/// Triangles of an octahedron, each divided `levels` times.
inline Shape sphere(int levels) {
  Shape shape{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
              {{0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, is_new] = middles.emplace(std::minmax(a, b), static_cast<std::uint32_t>(shape.points.size()));
      if (is_new) shape.points.push_back(normalized(shape.points[a] + shape.points[b]));
      return entry->second;
    };
    std::vector<TriangleVerts> finer;
    for (const auto& [a, b, c] : shape.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    shape.triangles = finer;
  }
  return shape;
}

/// Star-shaped about the origin: radii between `low` and 1.
inline Shape spiky_ball(std::mt19937_64& random, int levels, double low) {
  Shape shape = sphere(levels);
  std::uniform_real_distribution<double> radius(low, 1);
  for (Vec3& p : shape.points) p = radius(random) * p;
  return shape;
}

/// The space between a spiky ball and a smaller copy of it.
inline Shape thin_shell(std::mt19937_64& random, int levels, double low, double scale) {
  Shape shape = spiky_ball(random, levels, low), inner = shape;
  for (Vec3& p : inner.points) p = scale * p;
  for (TriangleVerts& t : inner.triangles) std::swap(t[1], t[2]);
  shape.append(inner);
  return shape;
}

/// The squares between unequal cubes of a block, with any diagonals: all kinds of exact coincidences, edges and
/// vertices where more than two squares meet.
inline Shape cubes(std::mt19937_64& random, int n, unsigned regions, const Vec3& scale, double jitter) {
  Shape shape;
  std::map<std::array<int, 3>, std::uint32_t> ids;
  std::vector<unsigned> full(static_cast<std::size_t>(n * n * n));
  for (std::size_t i = 0; i < full.size(); ++i) full[i] = static_cast<unsigned>(random() % regions);
  const auto at = [&](std::array<int, 3> c) {
    for (const int x : c) {
      if (x < 0 || x >= n) return 0u;
    }
    return full[static_cast<std::size_t>((c[0] * n + c[1]) * n + c[2])];
  };
  const auto id = [&](std::array<int, 3> c) {
    const auto [entry, is_new] = ids.emplace(c, static_cast<std::uint32_t>(shape.points.size()));
    if (is_new) shape.points.push_back({double(c[0]), double(c[1]), double(c[2])});
    return entry->second;
  };
  for (int axis = 0; axis < 3; ++axis) {
    for (int i = 0; i < (n + 1) * (n + 1) * (n + 1); ++i) {
      const std::array<int, 3> c{i / (n + 1) / (n + 1), i / (n + 1) % (n + 1), i % (n + 1)};
      std::array<int, 3> before = c;
      --before[axis];
      if (at(c) == at(before)) continue;
      std::array<std::uint32_t, 4> v;
      for (int k = 0; k < 4; ++k) {
        std::array<int, 3> corner = c;
        corner[(axis + 1) % 3] += k == 1 || k == 2;
        corner[(axis + 2) % 3] += k >= 2;
        v[static_cast<std::size_t>(k)] = id(corner);
      }
      const std::size_t s = random() % 2;
      shape.triangles.push_back({v[s], v[s + 1], v[s + 2]});
      shape.triangles.push_back({v[s], v[s + 2], v[(s + 3) % 4]});
    }
  }
  std::uniform_real_distribution<double> shift(-jitter, jitter);
  for (Vec3& p : shape.points) {
    p += {shift(random), shift(random), shift(random)};
    p = {p.x * scale.x, p.y * scale.y, p.z * scale.z};
  }
  return shape;
}

inline bool triangles_meet(const std::vector<Vec3>& points, const TriangleVerts& s, const TriangleVerts& t) {
  const auto point = [&](std::uint32_t v) -> const Vec3& { return points[v]; };
  const auto sign = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
    return orient3d(points[a], points[b], points[c], points[d]);
  };
  for (std::size_t i = 0; i < 3; ++i) {
    if (segment_meets_triangle(sign, point, s[i], s[(i + 1) % 3], t)) return true;
    if (segment_meets_triangle(sign, point, t[i], t[(i + 1) % 3], s)) return true;
  }
  return false;
}

/// Triangles between random points, as many of `trials` as do not meet others: open, with edges of many triangles.
inline Shape loose_triangles(std::mt19937_64& random, std::uint32_t point_count, int trials, bool on_grid) {
  Shape shape;
  std::uniform_real_distribution<double> coordinate(0, 1);
  std::map<std::array<double, 3>, int> seen;
  while (shape.points.size() < point_count) {
    Vec3 p{coordinate(random), coordinate(random), coordinate(random)};
    if (on_grid) p = {std::floor(p.x * 5), std::floor(p.y * 5), std::floor(p.z * 5)};
    if (seen[{p.x, p.y, p.z}]++ == 0) shape.points.push_back(p);
  }
  for (int i = 0; i < trials; ++i) {
    TriangleVerts t;
    for (std::uint32_t& v : t) v = static_cast<std::uint32_t>(random() % point_count);
    if (t[0] == t[1] || t[1] == t[2] || t[2] == t[0]) continue;
    if (collinear(shape.points[t[0]], shape.points[t[1]], shape.points[t[2]])) continue;
    bool free = true;
    for (const auto& other : shape.triangles) {
      free = free && sorted(other).verts != sorted(t).verts && !triangles_meet(shape.points, t, other);
    }
    // No other point on it.
    for (std::uint32_t v = 0; v < point_count && free; ++v) {
      if (v == t[0] || v == t[1] || v == t[2]) continue;
      const auto point = [&](std::uint32_t x) -> const Vec3& { return shape.points[x]; };
      const auto sign = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        return orient3d(point(a), point(b), point(c), point(d));
      };
      if (sign(t[0], t[1], t[2], v) != 0) continue;
      const PlaneTurn turn(point(t[0]), point(t[1]), point(t[2]));
      free = turn(point(t[0]), point(t[1]), point(v)) < 0 || turn(point(t[1]), point(t[2]), point(v)) < 0 ||
             turn(point(t[2]), point(t[0]), point(v)) < 0;
    }
    if (free) shape.triangles.push_back(t);
  }
  return shape;
}

}  // namespace tetloom::tets::recovery_tests
