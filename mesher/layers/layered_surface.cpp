#include "mesher/layers/layered_surface.hpp"

#include <algorithm>
#include <array>

namespace tetloom::layers {
namespace {

class SurfaceMaker {
 public:
  SurfaceMaker(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls, const SideFaces& sides,
               const LayerCounts& counts, std::span<const SideMesh> side_meshes)
      : mesh_(mesh),
        face_to_sides_(face_to_sides),
        walls_(walls),
        sides_(sides),
        counts_(counts),
        side_meshes_(side_meshes),
        face_is_anew_(face_to_sides.size(), 0) {
    for (const SideMesh& side : side_meshes) face_is_anew_[side.face] = 1;
  }

  LayeredSurface run() {
    Mesh& mesh = surface_.mesh;
    mesh.points = mesh_.points;
    mesh.point_to_entity = mesh_.point_to_entity;
    add_tops();
    surface_.free_to_slide = mesh.point_to_entity;
    add_triangles();
    add_fans();
    for (const SideMesh& side : side_meshes_) add_side(side);
    keep_edges();
    return std::move(surface_);
  }

 private:
  void add_tops() {
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      if (counts_.count(c) == 0) {
        surface_.curve_to_top.push_back(walls_.curve_to_vert[c]);
        continue;
      }
      surface_.curve_to_top.push_back(static_cast<std::uint32_t>(surface_.mesh.points.size()));
      surface_.mesh.points.push_back(counts_.top(c));
      surface_.mesh.point_to_entity.push_back(sides_.entity_of(c));
    }
  }

  bool has_layers(std::uint32_t wall) const {
    return wall != kNone &&
           std::ranges::any_of(walls_.triangles[wall].curves, [&](std::uint32_t c) { return counts_.count(c) > 0; });
  }

  void add_triangle(const std::array<std::uint32_t, 3>& verts, std::uint32_t face, const FaceSides& sides,
                    std::uint32_t stack) {
    surface_.mesh.tri_to_vert.push_back(verts);
    surface_.mesh.tri_to_entity.push_back(face);
    surface_.tri_to_sides.push_back(sides);
    surface_.is_top.push_back(stack != kNone);
    surface_.tri_to_stack.push_back(stack);
  }

  // Walls are sorted by triangle, the front side first.
  void add_triangles() {
    std::uint32_t next = 0;
    for (std::uint32_t t = 0; t < mesh_.tri_to_vert.size(); ++t) {
      std::array<std::uint32_t, 2> walls{kNone, kNone};  // in front, behind
      for (; next < walls_.triangles.size() && walls_.triangles[next].triangle == t; ++next)
        walls[walls_.triangles[next].is_front ? 0 : 1] = next;
      const std::uint32_t face = mesh_.tri_to_entity[t];
      if (face_is_anew_[face]) continue;
      FaceSides left = face_to_sides_[face];
      const bool bounds_any = left.front.valid() || left.back.valid();
      if (has_layers(walls[0])) add_top(walls[0], face, left.front);
      if (has_layers(walls[1])) add_top(walls[1], face, left.back);
      if (bounds_any && !left.front.valid() && !left.back.valid()) {
        surface_.covered.push_back(mesh_.tri_to_vert[t]);
        surface_.covered_to_entity.push_back(face);
      } else {
        add_triangle(mesh_.tri_to_vert[t], face, left, kNone);
      }
    }
  }

  // In the place of one side of a wall triangle, which is no boundary of its region any more.
  void add_top(std::uint32_t wall, std::uint32_t face, ModelRegionId& side) {
    const WallTriangle& triangle = walls_.triangles[wall];
    std::array<std::uint32_t, 3> verts;
    for (std::size_t i = 0; i < 3; ++i) verts[i] = surface_.curve_to_top[triangle.curves[i]];
    add_triangle(verts, face, {side, {}}, wall);
    side = {};
    for (std::size_t i = 0; i < 3; ++i) {
      keep(verts[i], verts[(i + 1) % 3]);
      keep(triangle.verts[i], triangle.verts[(i + 1) % 3]);
    }
  }

  void add_fans() {
    for (std::size_t f = 0; f < walls_.fans.size(); ++f) {
      const FanElement& fan = walls_.fans[f];
      const auto stack = static_cast<std::uint32_t>(walls_.triangles.size() + f);
      std::vector<std::uint32_t> rim;
      for (const std::uint32_t c : walls_.curves_of(stack))
        if (const std::uint32_t top = surface_.curve_to_top[c]; std::ranges::count(rim, top) == 0) rim.push_back(top);
      surface_.fan_to_apex.push_back(rim.size() == 4 ? add_apex(fan) : kNone);
      if (rim.size() == 3) add_fan_top({rim[0], rim[1], rim[2]}, stack);
      for (std::size_t i = 0; rim.size() == 4 && i < 4; ++i)
        add_fan_top({rim[i], rim[(i + 1) % 4], surface_.fan_to_apex.back()}, stack);
    }
  }

  std::uint32_t add_apex(const FanElement& fan) {
    surface_.mesh.points.push_back(counts_.apex(fan));
    surface_.mesh.point_to_entity.push_back(ModelRegionId(walls_.triangles[fan.wall].region));
    surface_.free_to_slide.emplace_back();
    return static_cast<std::uint32_t>(surface_.mesh.points.size() - 1);
  }

  void add_fan_top(const std::array<std::uint32_t, 3>& verts, std::uint32_t stack) {
    const WallTriangle& wall = walls_.wall_of(stack);
    add_triangle(verts, mesh_.tri_to_entity[wall.triangle], {ModelRegionId(wall.region), {}}, stack);
    for (std::size_t i = 0; i < 3; ++i) keep(verts[i], verts[(i + 1) % 3]);
  }

  void keep(std::uint32_t a, std::uint32_t b) {
    surface_.kept_edges.push_back({std::min(a, b), std::max(a, b)});
    surface_.free_to_slide[a] = surface_.free_to_slide[b] = {};
  }

  void add_side(const SideMesh& side) {
    Mesh& mesh = surface_.mesh;
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    mesh.points.insert(mesh.points.end(), side.mesh.points.begin(), side.mesh.points.end());
    mesh.point_to_entity.resize(mesh.points.size(), ModelFaceId(side.face));
    surface_.free_to_slide.resize(mesh.points.size(), ModelFaceId(side.face));
    for (const auto& verts : side.mesh.tri_to_vert) {
      std::array<std::uint32_t, 3> global;
      for (std::size_t i = 0; i < 3; ++i) {
        if (verts[i] & FaceMesh::kInner) {
          global[i] = first + (verts[i] & ~FaceMesh::kInner);
        } else {
          const SideMesh::Node& node = side.nodes[verts[i]];
          global[i] = node.curve != kNone ? surface_.curve_to_top[node.curve] : node.vert;
        }
      }
      add_triangle(global, side.face, face_to_sides_[side.face], kNone);
    }
  }

  // Pieces of model edges, shorter where layers have taken the place of the first ones.
  void keep_edges() {
    Mesh& mesh = surface_.mesh;
    std::vector<std::uint32_t> vert_to_new(mesh_.points.size());
    for (std::uint32_t v = 0; v < vert_to_new.size(); ++v) vert_to_new[v] = v;
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      const CurveTop top{counts_.top(c), distance(counts_.point(c, 0), counts_.top(c)), counts_.count(c) > 0};
      if (!top.grows || !sides_.is_along_edge(c)) continue;
      for (const std::uint32_t v : sides_.dropped_by(c, top)) vert_to_new[v] = surface_.curve_to_top[c];
      foot_and_curve_.push_back({walls_.curve_to_vert[c], c});
    }
    std::ranges::sort(foot_and_curve_);
    for (std::size_t i = 0; i < mesh_.edge_to_vert.size(); ++i) {
      auto [a, b] = mesh_.edge_to_vert[i];
      const ModelEntity edge = ModelEdgeId(mesh_.edge_to_entity[i]);
      // The piece at the foot starts at the top where nothing behind it was dropped.
      const std::uint32_t from_a = top_along(a, b, edge), from_b = top_along(b, a, edge);
      a = from_a != kNone ? from_a : vert_to_new[a];
      b = from_b != kNone ? from_b : vert_to_new[b];
      if (a == b) continue;
      mesh.edge_to_vert.push_back({a, b});
      mesh.edge_to_entity.push_back(edge.index);
    }
    surface_.kept_edges.insert(surface_.kept_edges.end(), mesh.edge_to_vert.begin(), mesh.edge_to_vert.end());
  }

  // The top of the curve that starts at the vertex and runs along the edge to the next one, or none.
  std::uint32_t top_along(std::uint32_t vert, std::uint32_t next, const ModelEntity& edge) const {
    auto i = std::ranges::lower_bound(foot_and_curve_, std::array{vert, 0u});
    for (; i != foot_and_curve_.end() && (*i)[0] == vert; ++i)
      if (sides_.entity_of((*i)[1]) == edge && sides_.at((*i)[1])->next == next) return surface_.curve_to_top[(*i)[1]];
    return kNone;
  }

  const Mesh& mesh_;
  std::span<const FaceSides> face_to_sides_;
  const Walls& walls_;
  const SideFaces& sides_;
  const LayerCounts& counts_;
  std::span<const SideMesh> side_meshes_;
  std::vector<std::uint8_t> face_is_anew_;
  std::vector<std::array<std::uint32_t, 2>> foot_and_curve_;  // of curves along model edges, ascending
  LayeredSurface surface_;
};

}  // namespace

VolumeInput LayeredSurface::input(const GeometricModel& model, const SizeField& sizes) const {
  return {mesh.points, mesh.tri_to_vert, tri_to_sides, mesh.tri_to_entity, &model, &sizes, free_to_slide, kept_edges};
}

LayeredSurface make_layered_surface(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls,
                                    const SideFaces& sides, const LayerCounts& counts,
                                    std::span<const SideMesh> side_meshes) {
  return SurfaceMaker(mesh, face_to_sides, walls, sides, counts, side_meshes).run();
}

}  // namespace tetloom::layers
