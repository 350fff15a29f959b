#pragma once
// Boxes of tetrahedra for tests.
#include <algorithm>
#include <array>
#include <functional>
#include <random>
#include <stdexcept>
#include <vector>

#include "tetloom/metric.hpp"

namespace tetloom::adapt {

struct BoxMesh {
  std::vector<Vec3> points;
  std::vector<TetVerts> tets;
  TetView view() const { return {points, tets}; }
};

/// n x n x n cubes of the unit cube, six tets each (Kuhn), those for which `keep(centre)` holds. Points inside are
/// shaken by up to `shake` of a cube. Points of dropped cubes stay, unused, unless all cubes are kept.
inline BoxMesh make_box_mesh(int n, double shake = 0, unsigned seed = 1,
                             const std::function<bool(const Vec3&)>& keep = {}) {
  BoxMesh mesh;
  std::mt19937 random(seed);
  const auto amount = [&] { return shake / n * (static_cast<double>(random()) / 2147483648.0 - 1); };
  const auto index = [&](int i, int j, int k) { return static_cast<std::uint32_t>((i * (n + 1) + j) * (n + 1) + k); };
  for (int i = 0; i <= n; ++i)
    for (int j = 0; j <= n; ++j)
      for (int k = 0; k <= n; ++k) {
        Vec3 p{double(i) / n, double(j) / n, double(k) / n};
        if (i % n != 0 && j % n != 0 && k % n != 0) p += Vec3{amount(), amount(), amount()};
        mesh.points.push_back(p);
      }
  std::array<int, 3> axes{0, 1, 2};
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        if (keep && !keep({(i + 0.5) / n, (j + 0.5) / n, (k + 0.5) / n})) continue;
        std::sort(axes.begin(), axes.end());
        do {
          std::array<int, 3> at{i, j, k};
          TetVerts tet{index(i, j, k)};
          for (std::size_t s = 0; s < 3; ++s) {
            ++at[static_cast<std::size_t>(axes[s])];
            tet[s + 1] = index(at[0], at[1], at[2]);
          }
          const int inversions = (axes[0] > axes[1]) + (axes[0] > axes[2]) + (axes[1] > axes[2]);
          if (inversions % 2 == 1) std::swap(tet[2], tet[3]);  // even permutations make positive tets
          const Vec3 a = mesh.points[tet[0]];
          if (dot(cross(mesh.points[tet[1]] - a, mesh.points[tet[2]] - a), mesh.points[tet[3]] - a) <= 0)
            throw std::logic_error("shaken too much");
          mesh.tets.push_back(tet);
        } while (std::next_permutation(axes.begin(), axes.end()));
      }
  return mesh;
}

}  // namespace tetloom::adapt
