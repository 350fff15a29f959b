#include "mesher/layers/spherical_polygon.hpp"

#include <algorithm>

namespace tetloom::layers {
namespace {

class PolygonCutter {
 public:
  explicit PolygonCutter(std::span<const Vec3> nodes) : nodes_(nodes), best_(nodes.size() * nodes.size(), {1, 0}) {}

  SphericalTriangulation run() {
    const auto count = static_cast<std::uint32_t>(nodes_.size());
    for (std::uint32_t width = 2; width < count; ++width)
      for (std::uint32_t i = 0; i + width < count; ++i) cut(i, i + width);
    SphericalTriangulation found;
    found.least = at(0, count - 1).least;
    collect(0, count - 1, found.triangles);
    return found;
  }

 private:
  struct Best {
    double least;
    std::uint32_t middle;
  };
  Best& at(std::uint32_t i, std::uint32_t k) { return best_[i * nodes_.size() + k]; }

  void cut(std::uint32_t i, std::uint32_t k) {
    at(i, k).least = -2;
    for (std::uint32_t j = i + 1; j < k; ++j) {
      const double product = dot(nodes_[i], cross(nodes_[j], nodes_[k]));
      const double least = std::min({product, at(i, j).least, at(j, k).least});
      if (least > at(i, k).least) at(i, k) = {least, j};
    }
  }

  void collect(std::uint32_t i, std::uint32_t k, std::vector<std::array<std::uint32_t, 3>>& triangles) {
    if (k < i + 2) return;
    const std::uint32_t j = at(i, k).middle;
    collect(i, j, triangles);
    collect(j, k, triangles);
    triangles.push_back({i, j, k});
  }

  std::span<const Vec3> nodes_;
  std::vector<Best> best_;  // of the nodes from i to k
};

}  // namespace

SphericalTriangulation triangulate_on_sphere(std::span<const Vec3> nodes) { return PolygonCutter(nodes).run(); }

}  // namespace tetloom::layers
