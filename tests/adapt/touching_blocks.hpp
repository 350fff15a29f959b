#pragma once
// Bodies made of blocks, some of which touch in an edge or a vertex alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <utility>
#include <vector>

#include "adapt/parts/whole_mesh.hpp"
#include "tests/adapt/box_mesh.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

using Block = std::array<int, 3>;
/// The region of a block; -1: nothing is there.
using Filling = std::function<int(const Block&)>;

/// n blocks to each side of the unit cube, cut into cubes at `cuts` places, six tets each. Every side of a block is a
/// model face of its own.
class Blocks {
 public:
  Blocks(int n, int cuts, const Filling& filling) : n_(n), cuts_(cuts), filling_(filling) {}

  Mesh run() {
    const BoxMesh box = make_box_mesh(n_ * cuts_, 0, 1, [&](const Vec3& x) { return region_at(x) >= 0; });
    mesh_.tet_to_vert = box.tets;
    for (const TetVerts& v : box.tets)
      mesh_.tet_to_entity.push_back(static_cast<std::uint32_t>(
          region_at((box.points[v[0]] + box.points[v[1]] + box.points[v[2]] + box.points[v[3]]) / 4)));
    for (const TetVerts& v : box.tets)
      for (std::size_t i = 0; i < 4; ++i) add_face(box, {v[i == 0], v[i <= 1 ? 2 : 1], v[i <= 2 ? 3 : 2]});
    drop_unused(box);
    // Edges and corners get their names.
    return make_mesh_of(make_whole_mesh(mesh_, TaskRunner(1)), mesh_, TaskRunner(1));
  }

 private:
  Block block_at(const Vec3& x) const {
    return {static_cast<int>(std::floor(x.x * n_)), static_cast<int>(std::floor(x.y * n_)),
            static_cast<int>(std::floor(x.z * n_))};
  }
  int region_at(const Vec3& x) const {
    const Block block = block_at(x);
    for (const int i : block)
      if (i < 0 || i >= n_) return -1;
    return filling_(block);
  }

  // Those in a plane between blocks of which one is empty, or of another region. From both sides, once.
  void add_face(const BoxMesh& box, std::array<std::uint32_t, 3> face) {
    const auto& x = box.points;
    const Vec3 middle = (x[face[0]] + x[face[1]] + x[face[2]]) / 3;
    for (int axis = 0; axis < 3; ++axis) {
      const double plane = x[face[0]][axis];
      if (x[face[1]][axis] != plane || x[face[2]][axis] != plane) continue;
      if (std::abs(plane * n_ - std::round(plane * n_)) > 1e-9) continue;
      Vec3 step;
      step[axis] = 1e-3;
      const Block low = block_at(middle - step), high = block_at(middle + step);
      if (region_at(middle - step) == region_at(middle + step)) continue;
      std::sort(face.begin(), face.end());
      if (!known_.emplace(face, 0).second) continue;
      const auto name = static_cast<std::uint32_t>(names_.size());
      const std::uint32_t number = names_.emplace(std::pair(low, high), name).first->second;
      if (cross(x[face[1]] - x[face[0]], x[face[2]] - x[face[0]])[axis] < 0) std::swap(face[1], face[2]);
      mesh_.tri_to_vert.push_back(face);
      mesh_.tri_to_entity.push_back(number);
    }
  }

  void drop_unused(const BoxMesh& box) {
    std::vector<std::uint32_t> to_new(box.points.size(), kNone);
    for (TetVerts& v : mesh_.tet_to_vert)
      for (std::uint32_t& vert : v) {
        if (to_new[vert] == kNone) {
          to_new[vert] = static_cast<std::uint32_t>(mesh_.points.size());
          mesh_.points.push_back(box.points[vert]);
        }
        vert = to_new[vert];
      }
    for (auto& v : mesh_.tri_to_vert)
      for (std::uint32_t& vert : v) vert = to_new[vert];
  }

  int n_, cuts_;
  const Filling& filling_;
  Mesh mesh_;
  std::map<std::pair<Block, Block>, std::uint32_t> names_;
  std::map<std::array<std::uint32_t, 3>, int> known_;
};

struct TouchingShape {
  const char* name;
  int blocks;  ///< to each side
  Filling filling;
};

inline int solid(bool is_there) { return is_there ? 0 : -1; }

inline const TouchingShape kTouchingShapes[] = {
    {"two regions that touch in an edge", 2, [](const Block& b) { return b[2] > 0 || b[0] != b[1] ? -1 : b[0]; }},
    {"one region, of two bodies that touch in an edge", 2,
     [](const Block& b) { return solid(b[2] == 0 && b[0] == b[1]); }},
    {"two regions that touch in a vertex", 2, [](const Block& b) { return b[0] != b[1] || b[1] != b[2] ? -1 : b[0]; }},
    {"four bodies that touch in edges, and all in a vertex", 2,
     [](const Block& b) { return solid((b[0] + b[1] + b[2]) % 2 == 0); }},
    {"a body that touches itself in an edge", 2, [](const Block& b) { return solid(b[2] == 0 || b[0] == b[1]); }},
    {"a body that touches itself between two ends of an edge", 3,
     [](const Block& b) { return solid(b[0] < 2 && b[1] < 2 && (b[2] != 1 || b[0] == b[1])); }},
    {"two voids that touch in a vertex", 4,
     [](const Block& b) {
       return solid(b != Block{1, 1, 1} && b != Block{2, 2, 2});
     }},
    {"two voids that touch in an edge", 4,
     [](const Block& b) {
       return solid(b != Block{1, 1, 1} && b != Block{2, 2, 1});
     }},
};

inline Mesh mesh_of(const TouchingShape& shape, int cuts) { return Blocks(shape.blocks, cuts, shape.filling).run(); }

}  // namespace tetloom::adapt
