#pragma once
// Meshes of boxes with a full classification, for the tests of core/mesh and core/io.
#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <random>
#include <set>

#include "tetloom/mesh_data.hpp"

namespace tetloom::test {

/// A box of nx * ny * nz cells of edge length `h`, six tets each (Kuhn 1960). With `two_regions` (nx even) the plane in
/// the middle of x is an internal face between two regions. All model entities are classified as those of a CAD box.
class BoxMesher {
 public:
  BoxMesher(int nx, int ny, int nz, bool two_regions, double h)
      : cells_{nx, ny, nz}, two_regions_(two_regions), h_(h) {}

  Mesh make() {
    for (int k = 0; k <= cells_[2]; ++k)
      for (int j = 0; j <= cells_[1]; ++j)
        for (int i = 0; i <= cells_[0]; ++i) add_point({i, j, k});
    for (int k = 0; k < cells_[2]; ++k)
      for (int j = 0; j < cells_[1]; ++j)
        for (int i = 0; i < cells_[0]; ++i) add_cell({i, j, k});
    for (std::size_t t = 0; t < mesh_.tet_to_vert.size(); ++t) add_triangles(t);
    mesh_.face_to_sides.resize(faces_.size());
    for (const auto& [face, sides] : sides_) mesh_.face_to_sides[face] = sides;
    return std::move(mesh_);
  }

 private:
  using Code =
      std::array<int, 3>;  // per axis: 0 low side, 1 inside, 2 high side or middle plane, 3 inside, 4 high side

  int code(int axis, int position) const {
    if (axis == 0 && two_regions_) {
      const int middle = cells_[0] / 2;
      return position == 0 ? 0 : position < middle ? 1 : position == middle ? 2 : position < cells_[0] ? 3 : 4;
    }
    return position == 0 ? 0 : position < cells_[axis] ? 1 : 2;
  }
  static int dimension(const Code& c) { return (c[0] & 1) + (c[1] & 1) + (c[2] & 1); }
  static Code join(const Code& a, const Code& b) {
    Code c;
    for (int axis = 0; axis < 3; ++axis) c[axis] = a[axis] == b[axis] ? a[axis] : std::min(a[axis], b[axis]) | 1;
    return c;
  }
  ModelEntity entity(const Code& c) {
    auto& table = dimension(c) == 2 ? faces_ : others_[dimension(c)];
    return {dimension(c), table.try_emplace(c, static_cast<std::uint32_t>(table.size())).first->second};
  }
  void add_point(const std::array<int, 3>& at) {
    codes_.push_back({code(0, at[0]), code(1, at[1]), code(2, at[2])});
    mesh_.points.push_back({at[0] * h_, at[1] * h_, at[2] * h_});
    mesh_.point_to_entity.push_back(entity(codes_.back()));
  }
  std::uint32_t id(const std::array<int, 3>& at) const {
    return static_cast<std::uint32_t>(at[0] + (cells_[0] + 1) * (at[1] + (cells_[1] + 1) * at[2]));
  }
  void add_cell(const std::array<int, 3>& at) {
    std::array<int, 3> axes{0, 1, 2};
    do {
      std::array<int, 3> corner = at;
      std::array<std::uint32_t, 4> tet{id(corner), 0, 0, 0};
      for (int step = 0; step < 3; ++step) ++corner[axes[step]], tet[step + 1] = id(corner);
      const bool odd = (axes[0] > axes[1]) ^ (axes[0] > axes[2]) ^ (axes[1] > axes[2]);
      if (odd) std::swap(tet[2], tet[3]);
      mesh_.tet_to_vert.push_back(tet);
      Code c = codes_[tet[0]];
      for (const std::uint32_t v : tet) c = join(c, codes_[v]);
      mesh_.tet_to_entity.push_back(entity(c).index);
    } while (std::next_permutation(axes.begin(), axes.end()));
  }
  void add_triangles(std::size_t t) {
    const auto& v = mesh_.tet_to_vert[t];
    for (const auto& f : std::array<std::array<int, 3>, 4>{{{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}}}) {
      const std::array<std::uint32_t, 3> triangle{v[f[0]], v[f[1]], v[f[2]]};
      const Code c = join(join(codes_[triangle[0]], codes_[triangle[1]]), codes_[triangle[2]]);
      if (dimension(c) != 2) continue;
      const std::uint32_t face = entity(c).index;
      const bool from_second = two_regions_ && c[0] == 2 && mesh_.tet_to_entity[t] == 1;
      (from_second ? sides_[face].front : sides_[face].back) = ModelRegionId(mesh_.tet_to_entity[t]);
      if (from_second) continue;
      mesh_.tri_to_vert.push_back(triangle);
      mesh_.tri_to_entity.push_back(face);
      for (int i = 0; i < 3; ++i) add_edge(triangle[i], triangle[(i + 1) % 3]);
    }
  }
  void add_edge(std::uint32_t a, std::uint32_t b) {
    const Code c = join(codes_[a], codes_[b]);
    if (dimension(c) != 1 || !edges_.insert(std::minmax(a, b)).second) return;
    mesh_.edge_to_vert.push_back({a, b});
    mesh_.edge_to_entity.push_back(entity(c).index);
  }

  std::array<int, 3> cells_;
  bool two_regions_;
  double h_;
  Mesh mesh_;
  std::vector<Code> codes_;
  std::map<Code, std::uint32_t> faces_;
  std::array<std::map<Code, std::uint32_t>, 4> others_;
  std::map<std::uint32_t, FaceSides> sides_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges_;
};

inline Mesh make_box(int nx, int ny, int nz, bool two_regions = false, double h = 1) {
  return BoxMesher(nx, ny, nz, two_regions, h).make();
}

/// Moves the points inside of regions by at most `amount` in each direction.
inline void jitter(Mesh& mesh, double amount, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> offset(-amount, amount);
  for (std::size_t i = 0; i < mesh.points.size(); ++i)
    if (mesh.point_to_entity[i].dim == 3) mesh.points[i] += {offset(random), offset(random), offset(random)};
}

/// Names, colours, layers and tolerances for all entities of a box mesh, with characters that files like to trip over.
inline void decorate(Mesh& mesh) {
  const std::array<std::size_t, 4> counts{12, 20, mesh.face_to_sides.size(), 2};
  for (std::size_t dim = 0; dim < 4; ++dim) mesh.entities[dim].resize(counts[dim]);
  for (std::size_t i = 0; i < counts[2]; i += 2) mesh.entities[2][i].name = "face <" + std::to_string(i) + "> & more";
  for (std::size_t i = 0; i < counts[2]; i += 3)
    mesh.entities[2][i].color = Color{0.25f * static_cast<float>(i), 0.5f, 1};
  mesh.entities[3][0].name = "Gehäuse 'links'";
  mesh.entities[3][1].name = "steel";
  mesh.entities[3][1].layer = "Layer 1";
  mesh.entities[1][3].tolerance = 1e-7;
}

}  // namespace tetloom::test
