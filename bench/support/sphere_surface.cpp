#include "bench/support/sphere_surface.hpp"

#include <algorithm>
#include <map>
#include <utility>

namespace tetloom::bench {

Sphere make_sphere(int levels) {
  Sphere sphere{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}}, {}};
  for (std::uint32_t x : {0u, 1u})
    for (std::uint32_t y : {2u, 3u})
      for (std::uint32_t z : {4u, 5u}) {
        const bool even = (x + y + z) % 2 == 0;
        sphere.tri_to_vert.push_back(even ? std::array{x, y, z} : std::array{x, z, y});
      }
  for (int level = 0; level < levels; ++level) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [it, added] = middles.try_emplace(std::minmax(a, b), static_cast<std::uint32_t>(sphere.points.size()));
      if (added) sphere.points.push_back(normalized(sphere.points[a] + sphere.points[b]));
      return it->second;
    };
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : sphere.tri_to_vert) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
    }
    sphere.tri_to_vert = std::move(finer);
  }
  return sphere;
}

}  // namespace tetloom::bench
