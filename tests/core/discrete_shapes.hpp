#pragma once
// Facetted shapes and files of them, for the tests of the discrete model.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"
#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::shapes {

using Triangle = std::array<std::uint32_t, 3>;

struct Facets {
  std::vector<Vec3> points;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> groups;
};

inline void append(Facets& to, const Facets& from, bool turn_over = false) {
  const auto first = static_cast<std::uint32_t>(to.points.size());
  to.points.insert(to.points.end(), from.points.begin(), from.points.end());
  for (Triangle t : from.triangles) {
    if (turn_over) std::swap(t[1], t[2]);
    to.triangles.push_back({t[0] + first, t[1] + first, t[2] + first});
  }
}

/// An axis-aligned box with n × n × 2 facets a side; group = side (x lo, x hi, y lo, y hi, z lo, z hi).
inline Facets make_box(const Vec3& lo, const Vec3& hi, std::uint32_t n = 1) {
  Facets box;
  for (int side = 0; side < 6; ++side) {
    const int axis = side / 2, a = (axis + 1) % 3, b = (axis + 2) % 3;
    const auto first = static_cast<std::uint32_t>(box.points.size());
    for (std::uint32_t j = 0; j <= n; ++j) {
      for (std::uint32_t i = 0; i <= n; ++i) {
        Vec3 p;
        p[axis] = side % 2 ? hi[axis] : lo[axis];
        p[a] = lo[a] + (hi[a] - lo[a]) * i / n, p[b] = lo[b] + (hi[b] - lo[b]) * j / n;
        box.points.push_back(p);
      }
    }
    for (std::uint32_t j = 0; j < n; ++j) {
      for (std::uint32_t i = 0; i < n; ++i) {
        const std::uint32_t p = first + j * (n + 1) + i, q = p + 1, r = p + n + 2, s = p + n + 1;
        box.triangles.push_back(side % 2 ? Triangle{p, q, r} : Triangle{p, r, q});
        box.triangles.push_back(side % 2 ? Triangle{p, r, s} : Triangle{p, s, r});
        box.groups.insert(box.groups.end(), 2, static_cast<std::uint32_t>(side));
      }
    }
  }
  return box;
}

/// A closed or open grid of (columns × rows) quads over position(i, j); wraps in i, and in j when asked.
template <class Position>
Facets make_grid(std::uint32_t columns, std::uint32_t rows, bool wrap_j, Position&& position, bool wrap_i = true) {
  Facets grid;
  const std::uint32_t width = wrap_i ? columns : columns + 1, height = wrap_j ? rows : rows + 1;
  for (std::uint32_t j = 0; j < height; ++j) {
    for (std::uint32_t i = 0; i < width; ++i) grid.points.push_back(position(i, j));
  }
  const auto at = [&](std::uint32_t i, std::uint32_t j) { return j % height * width + i % width; };
  for (std::uint32_t j = 0; j < rows; ++j) {
    for (std::uint32_t i = 0; i < columns; ++i) {
      const std::uint32_t p = at(i, j), q = at(i + 1, j), r = at(i + 1, j + 1), s = at(i, j + 1);
      grid.triangles.push_back({p, q, r});
      grid.triangles.push_back({p, r, s});
    }
  }
  return grid;
}

/// Outward; a sphere from an icosahedron, every triangle cut in four `levels` times.
inline Facets make_sphere(const Vec3& center, double radius, int levels) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  Facets sphere;
  sphere.points = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                   {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  sphere.triangles = {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
                      {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
                      {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}};
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [entry, is_new] =
          middles.try_emplace(std::minmax({a, b}), static_cast<std::uint32_t>(sphere.points.size()));
      if (is_new) sphere.points.push_back(0.5 * (normalized(sphere.points[a]) + normalized(sphere.points[b])));
      return entry->second;
    };
    std::vector<Triangle> finer;
    for (const auto& [a, b, c] : sphere.triangles) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    sphere.triangles = std::move(finer);
  }
  for (Vec3& p : sphere.points) p = center + radius * normalized(p);
  return sphere;
}

/// A cylinder about the z axis from 0 to `height`; caps are fans about their centres.
inline Facets make_cylinder(double radius, double height, std::uint32_t columns, std::uint32_t rows) {
  Facets cylinder = make_grid(columns, rows, false, [&](std::uint32_t i, std::uint32_t j) {
    const double angle = 2 * M_PI * i / columns;
    return Vec3{radius * std::cos(angle), radius * std::sin(angle), height * j / rows};
  });
  const auto bottom = static_cast<std::uint32_t>(cylinder.points.size()), top = bottom + 1;
  cylinder.points.push_back({0, 0, 0}), cylinder.points.push_back({0, 0, height});
  for (std::uint32_t i = 0; i < columns; ++i) {
    const std::uint32_t next = (i + 1) % columns, last = rows * columns;
    cylinder.triangles.push_back({bottom, next, i});
    cylinder.triangles.push_back({top, last + i, last + next});
  }
  return cylinder;
}

inline Facets make_torus(double major, double minor, std::uint32_t columns, std::uint32_t rows) {
  return make_grid(columns, rows, true, [&](std::uint32_t i, std::uint32_t j) {
    const double a = 2 * M_PI * i / columns, b = 2 * M_PI * j / rows, rho = major + minor * std::cos(b);
    return Vec3{rho * std::cos(a), rho * std::sin(a), minor * std::sin(b)};
  });
}

inline double volume_of(const Facets& facets) {
  double sum = 0;
  for (const auto& [a, b, c] : facets.triangles) {
    sum += dot(facets.points[a], cross(facets.points[b], facets.points[c])) / 6;
  }
  return sum;
}

inline double area_of(const Facets& facets) {
  double sum = 0;
  for (const auto& [a, b, c] : facets.triangles) {
    sum += norm(cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a])) / 2;
  }
  return sum;
}

using test::TemporaryFolder;

inline std::string binary_stl(const Facets& facets, const std::string& header = "facets") {
  std::string bytes(84 + 50 * facets.triangles.size(), '\0');
  bytes.replace(0, std::min<std::size_t>(header.size(), 80), header.substr(0, 80));
  const auto count = static_cast<std::uint32_t>(facets.triangles.size());
  std::memcpy(bytes.data() + 80, &count, 4);
  char* at = bytes.data() + 84;
  for (const Triangle& t : facets.triangles) {
    at += 12;
    for (const std::uint32_t v : t) {
      for (int axis = 0; axis < 3; ++axis, at += 4) {
        const auto value = static_cast<float>(facets.points[v][axis]);
        std::memcpy(at, &value, 4);
      }
    }
    at += 2;
  }
  return bytes;
}

inline std::string ascii_stl(const Facets& facets, const std::string& name, const char* format = "%.9g") {
  std::string text = "solid " + name + "\n";
  char number[64];
  for (const Triangle& t : facets.triangles) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const std::uint32_t v : t) {
      text += "      vertex";
      for (int axis = 0; axis < 3; ++axis) {
        std::snprintf(number, sizeof number, format, facets.points[v][axis]);
        text += std::string(" ") + number;
      }
      text += "\n";
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid " + name + "\n";
}

/// Cut where facets meet at more than 0.7 radians.
inline std::unique_ptr<GeometricModel> model_of(const Facets& facets, bool with_groups = false) {
  return make_discrete_model(
      facets.points, facets.triangles, 0.7,
      with_groups ? std::span<const std::uint32_t>(facets.groups) : std::span<const std::uint32_t>());
}

}  // namespace tetloom::shapes
