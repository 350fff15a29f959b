#include "mesher/layers/layered_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mesher/layers/layer_cells.hpp"

namespace tetloom::layers {
namespace {

class Assembly {
 public:
  Assembly(const LayerGrowth& growth, const Mesh& given, Mesh&& filled, bool all_tets)
      : growth_(growth),
        walls_(growth.walls()),
        counts_(growth.counts()),
        mesh_(std::move(filled)),
        all_tets_(all_tets) {
    mesh_.entities = given.entities;
    mesh_.face_to_sides = given.face_to_sides;
  }

  Mesh run() {
    drop_tops();
    add_level_points();
    add_edges();
    add_cells();
    add_sides();
    add_fields();
    drop_unused_points();
    return std::move(mesh_);
  }

 private:
  // The model's surface is what is left, and the walls below the layers.
  void drop_tops() {
    const LayeredSurface& surface = growth_.surface();
    std::size_t kept = 0;
    for (std::size_t t = 0; t < surface.is_top.size(); ++t) {
      if (surface.is_top[t]) continue;
      mesh_.tri_to_vert[kept] = mesh_.tri_to_vert[t];
      mesh_.tri_to_entity[kept++] = mesh_.tri_to_entity[t];
    }
    mesh_.tri_to_vert.resize(kept);
    mesh_.tri_to_entity.resize(kept);
    mesh_.tri_to_vert.insert(mesh_.tri_to_vert.end(), surface.covered.begin(), surface.covered.end());
    mesh_.tri_to_entity.insert(mesh_.tri_to_entity.end(), surface.covered_to_entity.begin(),
                               surface.covered_to_entity.end());
  }

  // Between feet and tops.
  void add_level_points() {
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      first_level_.push_back(static_cast<std::uint32_t>(mesh_.points.size()));
      for (int level = 1; level < counts_.count(c); ++level) {
        mesh_.points.push_back(counts_.point(c, level));
        mesh_.point_to_entity.push_back(growth_.sides().entity_of(c));
      }
      if (mesh_.points.size() >= kNone) throw std::bad_alloc();
    }
  }

  std::uint32_t point(std::uint32_t curve, int level) const {
    if (level == 0) return walls_.curve_to_vert[curve];
    if (level == counts_.count(curve)) return growth_.surface().curve_to_top[curve];
    return first_level_[curve] + static_cast<std::uint32_t>(level) - 1;
  }

  void add_edges() {
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      if (growth_.sides().count(c) != 2) continue;
      for (int level = 0; level < counts_.count(c); ++level) {
        mesh_.edge_to_vert.push_back({point(c, level), point(c, level + 1)});
        mesh_.edge_to_entity.push_back(growth_.sides().entity_of(c).index);
      }
    }
  }

  void add_cells() {
    tets_above_ = mesh_.tet_to_vert.size();
    for (const WallTriangle& wall : walls_.triangles) {
      std::array<int, 3> counts;
      for (std::size_t i = 0; i < 3; ++i) counts[i] = counts_.count(wall.curves[i]);
      int layer = 0;
      for_each_cell(counts, [&](CellKind, const auto& corners) { add_cell(wall, corners, ++layer); });
    }
  }

  template <std::size_t N>
  void add_cell(const WallTriangle& wall, const std::array<LevelCorner, N>& corners, int layer) {
    std::array<std::uint32_t, N> verts;
    for (std::size_t i = 0; i < N; ++i) verts[i] = point(wall.curves[corners[i].corner], corners[i].level);
    const double height = height_of(wall, corners);
    if constexpr (N == 6) {
      if (all_tets_) return split_prism(wall, corners, verts, layer, height);
      add(mesh_.prism_to_vert, mesh_.prism_to_entity, CellKind::Prism, verts, wall.region, layer, height);
    } else if constexpr (N == 5) {
      if (all_tets_) return split_pyramid(wall, corners, verts, layer, height);
      add(mesh_.pyramid_to_vert, mesh_.pyramid_to_entity, CellKind::Pyramid, verts, wall.region, layer, height);
    } else {
      add(mesh_.tet_to_vert, mesh_.tet_to_entity, CellKind::Tet, verts, wall.region, layer, height);
    }
  }

  template <class Cell>
  void add(std::vector<Cell>& cells, std::vector<std::uint32_t>& entities, CellKind kind, const Cell& verts,
           std::uint32_t region, int layer, double height) {
    cells.push_back(verts);
    entities.push_back(region);
    layers_[static_cast<std::size_t>(kind)].push_back(layer);
    heights_[static_cast<std::size_t>(kind)].push_back(height);
  }
  void add_tet(const std::array<std::uint32_t, 4>& verts, std::uint32_t region, int layer, double height) {
    add(mesh_.tet_to_vert, mesh_.tet_to_entity, CellKind::Tet, verts, region, layer, height);
  }

  // The mean way from one level to the next, along curves that have it.
  template <std::size_t N>
  double height_of(const WallTriangle& wall, const std::array<LevelCorner, N>& corners) const {
    double sum = 0;
    int count = 0, level = 0;
    for (const LevelCorner& corner : corners) level = std::max(level, corner.level);
    for (const std::uint32_t c : wall.curves) {
      if (counts_.count(c) < level) continue;
      sum += distance(counts_.point(c, level - 1), counts_.point(c, level));
      ++count;
    }
    return sum / count;
  }

  // Even permutations of the curves keep a tet positive, odd ones are mended by a swap. The
  // diagonals start below at the curve of lower number and end above.
  void split_prism(const WallTriangle& wall, const std::array<LevelCorner, 6>& corners,
                   const std::array<std::uint32_t, 6>& verts, int layer, double height) {
    std::array<std::size_t, 3> order{0, 1, 2};
    std::ranges::sort(order, {}, [&](std::size_t i) { return wall.curves[corners[i].corner]; });
    const bool is_even = (order[1] + 3 - order[0]) % 3 == 1;
    const auto low = [&](std::size_t i) { return verts[order[i]]; };
    const auto high = [&](std::size_t i) { return verts[order[i] + 3]; };
    for (std::array<std::uint32_t, 4> tet :
         {std::array{low(0), low(1), low(2), high(2)}, std::array{low(0), low(1), high(2), high(1)},
          std::array{low(0), high(1), high(2), high(0)}}) {
      if (!is_even) std::swap(tet[1], tet[2]);
      add_tet(tet, wall.region, layer, height);
    }
  }

  void split_pyramid(const WallTriangle& wall, const std::array<LevelCorner, 5>& corners,
                     const std::array<std::uint32_t, 5>& verts, int layer, double height) {
    // 0 is below 1 on one curve, 3 below 2 on the other.
    const bool is_first_lower = wall.curves[corners[0].corner] < wall.curves[corners[3].corner];
    const auto& [a, b, c, d, apex] = verts;
    if (is_first_lower) {  // from a, below, to c, above
      add_tet({a, b, c, apex}, wall.region, layer, height);
      add_tet({a, c, d, apex}, wall.region, layer, height);
    } else {
      add_tet({a, b, d, apex}, wall.region, layer, height);
      add_tet({b, c, d, apex}, wall.region, layer, height);
    }
  }

  // Quadrilaterals and triangles of layers on side faces.
  void add_sides() {
    for (const WallRim& rim : walls_.rims) {
      const WallTriangle& wall = walls_.triangles[rim.wall];
      const std::uint32_t c = wall.curves[rim.corner], d = wall.curves[(rim.corner + 1) % 3];
      const int both = std::min(counts_.count(c), counts_.count(d)),
                most = std::max(counts_.count(c), counts_.count(d));
      if (most == 0) continue;
      const bool is_outward = growth_.model().topology().face_to_sides[rim.side_face].back.value == wall.region;
      for (int level = 0; level < both; ++level)
        add_quad({point(c, level), point(d, level), point(d, level + 1), point(c, level + 1)}, c < d, rim.side_face,
                 is_outward);
      for (int level = both; level < most; ++level) {
        const bool c_grows = counts_.count(c) > level;
        add_triangle({point(c, std::min(level, counts_.count(c))), point(d, std::min(level, counts_.count(d))),
                      c_grows ? point(c, level + 1) : point(d, level + 1)},
                     rim.side_face, is_outward);
      }
    }
  }

  void add_triangle(std::array<std::uint32_t, 3> verts, std::uint32_t face, bool is_outward) {
    if (!is_outward) std::swap(verts[1], verts[2]);
    mesh_.tri_to_vert.push_back(verts);
    mesh_.tri_to_entity.push_back(face);
  }

  void add_quad(std::array<std::uint32_t, 4> verts, bool from_first, std::uint32_t face, bool is_outward) {
    const auto& [a, b, above_b, above_a] = verts;
    if (!all_tets_) {
      if (!is_outward) std::swap(verts[1], verts[3]);
      mesh_.quad_to_vert.push_back(verts);
      mesh_.quad_to_entity.push_back(face);
    } else if (from_first) {
      add_triangle({a, b, above_b}, face, is_outward);
      add_triangle({a, above_b, above_a}, face, is_outward);
    } else {
      add_triangle({a, b, above_a}, face, is_outward);
      add_triangle({b, above_b, above_a}, face, is_outward);
    }
  }

  void add_fields() {
    MeshField layer{"layer", 1, std::vector<double>(tets_above_, 0)}, height{"height", 1, layer.values};
    for (std::size_t kind = 0; kind < kCellKinds; ++kind) {
      layer.values.insert(layer.values.end(), layers_[kind].begin(), layers_[kind].end());
      height.values.insert(height.values.end(), heights_[kind].begin(), heights_[kind].end());
    }
    mesh_.cell_fields.push_back(std::move(layer));
    mesh_.cell_fields.push_back(std::move(height));
  }

  template <class Visit>
  void for_each_block(const Visit& visit) {
    visit(mesh_.edge_to_vert), visit(mesh_.tri_to_vert), visit(mesh_.quad_to_vert), visit(mesh_.tet_to_vert);
    visit(mesh_.pyramid_to_vert), visit(mesh_.prism_to_vert);
  }

  // Points of model vertices stay, whatever has them.
  void drop_unused_points() {
    std::vector<std::uint32_t> number(mesh_.points.size(), kNone);
    for_each_block([&](const auto& elements) {
      for (const auto& element : elements)
        for (const std::uint32_t v : element) number[v] = 0;
    });
    std::uint32_t used = 0;
    for (std::size_t v = 0; v < number.size(); ++v) {
      if (number[v] == kNone && mesh_.point_to_entity[v].dim != 0) continue;
      number[v] = used;
      mesh_.points[used] = mesh_.points[v];
      mesh_.point_to_entity[used++] = mesh_.point_to_entity[v];
    }
    mesh_.points.resize(used);
    mesh_.point_to_entity.resize(used);
    for_each_block([&](auto& elements) {
      for (auto& element : elements)
        for (std::uint32_t& v : element) v = number[v];
    });
  }

  const LayerGrowth& growth_;
  const Walls& walls_;
  const LayerCounts& counts_;
  Mesh mesh_;
  bool all_tets_;
  std::size_t tets_above_ = 0;
  std::vector<std::uint32_t> first_level_;  // per curve, the point of level 1
  std::array<std::vector<int>, kCellKinds> layers_;
  std::array<std::vector<double>, kCellKinds> heights_;
};

}  // namespace

Mesh make_layered_mesh(const LayerGrowth& growth, const Mesh& given, Mesh&& filled, bool all_tets,
                       const TaskRunner& runner) {
  runner.check_cancelled();
  return Assembly(growth, given, std::move(filled), all_tets).run();
}

}  // namespace tetloom::layers
