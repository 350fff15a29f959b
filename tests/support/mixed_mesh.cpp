#include "tests/support/mixed_mesh.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <random>
#include <set>
#include <stdexcept>
#include <utility>

#include "core/mesh/mesh_access.hpp"

namespace tetloom::test {
namespace {

using Place = std::array<int, 3>;
/// Where something lies, per axis: 0 low side, 1 inside, 2 high side or middle plane, 3 inside behind that, 4 high
/// side.
using Code = std::array<int, 3>;

int dimension(const Code& c) { return (c[0] & 1) + (c[1] & 1) + (c[2] & 1); }

Code join(const Code& a, const Code& b) {
  Code c;
  for (std::size_t axis = 0; axis < 3; ++axis) c[axis] = a[axis] == b[axis] ? a[axis] : std::min(a[axis], b[axis]) | 1;
  return c;
}

/// Collects points and cells; then finds the elements of lower dimension and the classification of all.
class BoxBuilder {
 public:
  explicit BoxBuilder(const BoxSpec& spec) : spec_(spec), cubes_{spec.nx, spec.ny, spec.nz} {
    for (int k = 0; k <= spec.nz; ++k)
      for (int j = 0; j <= spec.ny; ++j)
        for (int i = 0; i <= spec.nx; ++i)
          add_point({code(0, i), code(1, j), code(2, k)}, {i * spec.h, j * spec.h, k * spec.h});
  }

  /// The eight corners of a cube in the order of a hex.
  std::array<std::uint32_t, 8> corners(const Place& at) const {
    const auto [i, j, k] = at;
    return {id(i, j, k),     id(i + 1, j, k),     id(i + 1, j + 1, k),     id(i, j + 1, k),
            id(i, j, k + 1), id(i + 1, j, k + 1), id(i + 1, j + 1, k + 1), id(i, j + 1, k + 1)};
  }
  /// A new point in the middle of a cube.
  std::uint32_t add_center(const Place& at) {
    const auto cube = corners(at);
    Vec3 center;
    for (const std::uint32_t v : cube) center += mesh_.points[v] / 8;
    add_point(joined(cube), center);
    return static_cast<std::uint32_t>(mesh_.points.size() - 1);
  }
  Mesh& mesh() { return mesh_; }

  Mesh finish() {
    for_each_cell_kind(mesh_, [&](CellKind kind, const auto& cells, auto& regions) {
      for (const auto& cell : cells) {
        regions.push_back(region(joined(cell)));
        for (const LocalFace& face : shape_of(kind).faces()) add_face(cell, face, regions.back());
      }
    });
    move_points();
    mesh_.face_to_sides.resize(tables_[2].size());
    for (const auto& [face, sides] : sides_) mesh_.face_to_sides[face] = sides;
    return std::move(mesh_);
  }

 private:
  int code(std::size_t axis, int position) const {
    if (axis == 0 && spec_.two_regions) {
      const int middle = spec_.nx / 2;
      return position == 0 ? 0 : position < middle ? 1 : position == middle ? 2 : position < spec_.nx ? 3 : 4;
    }
    return position == 0 ? 0 : position < cubes_[axis] ? 1 : 2;
  }
  static std::uint32_t region(const Code& c) { return c[0] == 3 ? 1 : 0; }
  std::uint32_t id(int i, int j, int k) const {
    return static_cast<std::uint32_t>(i + (spec_.nx + 1) * (j + (spec_.ny + 1) * k));
  }
  template <class Vertices>
  Code joined(const Vertices& vertices) const {
    Code c = codes_[vertices[0]];
    for (const std::uint32_t v : vertices) c = join(c, codes_[v]);
    return c;
  }
  ModelEntity entity(const Code& c) {
    if (dimension(c) == 3) return {3, region(c)};
    auto& table = tables_[static_cast<std::size_t>(dimension(c))];
    return {dimension(c), table.try_emplace(c, static_cast<std::uint32_t>(table.size())).first->second};
  }
  void add_point(const Code& c, const Vec3& x) {
    codes_.push_back(c);
    mesh_.points.push_back(x);
    mesh_.point_to_entity.push_back(entity(c));
  }

  template <class Cell>
  void add_face(const Cell& cell, const LocalFace& face, std::uint32_t region_of_cell) {
    std::vector<std::uint32_t> cycle;
    for (const std::uint8_t v : face.vertices()) cycle.push_back(cell[v]);
    const Code c = joined(cycle);
    if (dimension(c) != 2) return;
    const std::uint32_t on = entity(c).index;
    const bool from_second = spec_.two_regions && c[0] == 2 && region_of_cell == 1;
    (from_second ? sides_[on].front : sides_[on].back) = ModelRegionId(region_of_cell);
    if (from_second) return;
    if (cycle.size() == 3) {
      mesh_.tri_to_vert.push_back({cycle[0], cycle[1], cycle[2]});
      mesh_.tri_to_entity.push_back(on);
    } else {
      mesh_.quad_to_vert.push_back({cycle[0], cycle[1], cycle[2], cycle[3]});
      mesh_.quad_to_entity.push_back(on);
    }
    for (std::size_t i = 0; i < cycle.size(); ++i) add_edge(cycle[i], cycle[(i + 1) % cycle.size()]);
  }
  void add_edge(std::uint32_t a, std::uint32_t b) {
    const Code c = join(codes_[a], codes_[b]);
    if (dimension(c) != 1 || !edges_.insert(std::minmax(a, b)).second) return;
    mesh_.edge_to_vert.push_back({a, b});
    mesh_.edge_to_entity.push_back(entity(c).index);
  }

  void move_points() {
    if (spec_.seed == 0) return;
    std::mt19937_64 random(spec_.seed);
    // The generator is the same everywhere; the distributions of the standard library need not be.
    const auto offset = [&] { return spec_.h * spec_.jitter * (static_cast<double>(random() >> 11) * 0x1p-52 - 1); };
    for (std::size_t i = 0; i < mesh_.points.size(); ++i)
      if (mesh_.point_to_entity[i].dim == 3)
        for (int axis = 0; axis < 3; ++axis) mesh_.points[i][axis] += offset();
  }

  BoxSpec spec_;
  Place cubes_;
  Mesh mesh_;
  std::vector<Code> codes_;
  std::array<std::map<Code, std::uint32_t>, 3> tables_;
  std::map<std::uint32_t, FaceSides> sides_;
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges_;
};

template <class Fill>
void for_each_cube(const BoxSpec& spec, const Fill& fill) {
  for (int k = 0; k < spec.nz; ++k)
    for (int j = 0; j < spec.ny; ++j)
      for (int i = 0; i < spec.nx; ++i) fill(Place{i, j, k});
}

// All ways to cut a cube run their diagonals from the lowest to the highest corner of a face, so they fit.

void add_tets(BoxBuilder& box, const Place& at) {
  const auto v = box.corners(at);
  for (const auto& [a, b] : {std::pair{1, 2}, {2, 3}, {3, 7}, {7, 4}, {4, 5}, {5, 1}})
    box.mesh().tet_to_vert.push_back({v[0], v[a], v[b], v[6]});
}

void add_prisms(BoxBuilder& box, const Place& at) {
  const auto v = box.corners(at);
  box.mesh().prism_to_vert.push_back({v[0], v[1], v[2], v[4], v[5], v[6]});
  box.mesh().prism_to_vert.push_back({v[0], v[2], v[3], v[4], v[6], v[7]});
}

bool has_prisms_on_top(const Place& at) { return (at[0] + at[1]) % 3 == 2; }

void add_transition(BoxBuilder& box, const Place& at) {
  const auto v = box.corners(at);
  const std::uint32_t center = box.add_center(at);
  const auto add_triangle = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    box.mesh().tet_to_vert.push_back({a, c, b, center});
  };
  for (const LocalFace& face : shape_of(CellKind::Hex).faces()) {
    std::array<std::uint32_t, 4> cycle;
    for (std::size_t i = 0; i < 4; ++i) cycle[i] = v[face.vert[i]];
    const bool on_top = face.vert == std::array<std::uint8_t, 4>{4, 5, 6, 7};
    if (on_top && !has_prisms_on_top(at)) {
      box.mesh().pyramid_to_vert.push_back({cycle[3], cycle[2], cycle[1], cycle[0], center});
      continue;
    }
    std::rotate(cycle.begin(), std::min_element(cycle.begin(), cycle.end()), cycle.end());
    add_triangle(cycle[0], cycle[1], cycle[2]);
    add_triangle(cycle[0], cycle[2], cycle[3]);
  }
}

}  // namespace

Mesh make_tet_box(const BoxSpec& spec) {
  BoxBuilder box(spec);
  for_each_cube(spec, [&](const Place& at) { add_tets(box, at); });
  return box.finish();
}

Mesh make_tet_box(int nx, int ny, int nz, unsigned seed, bool two_regions) {
  return make_tet_box({.nx = nx, .ny = ny, .nz = nz, .two_regions = two_regions, .seed = seed});
}

Mesh make_unit_cube(int n, bool two_regions) {
  BoxSpec spec{n, n, n, two_regions, 1};
  spec.h = 1.0 / n;
  return make_tet_box(spec);
}

Mesh make_mixed_box(const BoxSpec& spec) {
  if (spec.nz < 4) throw std::invalid_argument("a mixed box needs four layers");
  BoxBuilder box(spec);
  for_each_cube(spec, [&](const Place& at) {
    const int below_top = spec.nz - 1 - at[2];
    if (at[2] == 0 || (below_top == 0 && has_prisms_on_top(at)))
      add_prisms(box, at);
    else if (below_top == 0)
      box.mesh().hex_to_vert.push_back(box.corners(at));
    else if (below_top == 1)
      add_transition(box, at);
    else
      add_tets(box, at);
  });
  return box.finish();
}

Mesh make_mixed_box(int nx, int ny, int nz, unsigned seed, bool two_regions) {
  return make_mixed_box({.nx = nx, .ny = ny, .nz = nz, .two_regions = two_regions, .seed = seed});
}

}  // namespace tetloom::test
