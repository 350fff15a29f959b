#pragma once
// The walls of a surface mesh and the growth curves that start on them.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/layers.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"

namespace tetloom::layers {

/// The heights of layers: layer i is first · growth^i high.
struct LayerHeights {
  double first = 0, growth = 1;
  int count = 0;

  /// Of the first `layers` together.
  double sum(int layers) const;
  double last(int layers) const;
};

/// A triangle of the surface mesh seen from one of its sides, on which it has layers.
struct WallTriangle {
  std::uint32_t triangle = 0;            ///< of the surface mesh
  std::uint32_t region = 0;              ///< on this side
  bool is_front = false;                 ///< the side into which the face's normal points
  std::array<std::uint32_t, 3> verts{};  ///< counter-clockwise seen from the region
  std::array<std::uint32_t, 3> curves{};
};

/// What the cells of a fan stand on: a piece of a sharp convex edge, or a vertex of one, opened between growth curves.
/// Counter-clockwise seen from the region, as all surfaces of cells are seen from above.
///
///   quad: an edge p–q   a--d  a and b have the foot p, c and d the foot q
///                       |  |
///                       b--c
///   end: of a fan       a is the only curve of its foot, b and c have one foot
///   corner: a vertex    a, b and c have one foot
struct FanElement {
  enum class Kind : std::uint8_t { Quad, End, Corner };
  Kind kind = Kind::Quad;
  std::array<std::uint32_t, 4> curves{kNone, kNone, kNone, kNone};
  std::uint32_t wall = 0;  ///< the wall triangle beside it

  std::size_t size() const { return kind == Kind::Quad ? 4 : 3; }
};

/// The growth curves of one foot.
struct FanVertex {
  std::vector<std::uint32_t> curves;  ///< those of wall triangles first
};

/// A piece of the line where a wall meets a face of the same region that is none: layers stand on that face.
struct WallRim {
  std::uint32_t wall = 0;           ///< index of the wall triangle
  std::uint32_t corner = 0;         ///< the piece runs from this one of its corners to the next
  std::uint32_t side_face = 0;      ///< of the model
  std::uint32_t side_triangle = 0;  ///< of the surface mesh, on the other side of the line
};

/// Growth curves (Garimella & Shephard 2000) start at the vertices of walls and carry the points of layers. A vertex
/// has one for every sector: wall triangles around it that hang together on the same side. So walls inside of regions,
/// and edges where more than two faces meet, are no special cases.
///
/// A sector has several curves, a fan, where sharp convex edges part it: one for the triangles between two of them, and
/// others in between that no wall triangle has. A stack stands on a wall triangle or on an element of a fan; stacks are
/// numbered in this order.
struct Walls {
  std::vector<WallTriangle> triangles;  ///< by surface triangle, front side first
  std::vector<WallRim> rims;
  std::vector<FanElement> fans;
  std::vector<FanVertex> fan_vertices;
  std::vector<std::uint32_t> curve_to_fan_vertex;  ///< none for curves that have their foot for themselves
  std::vector<Vec3> curve_to_direction;            ///< of curves without wall triangles, of length 1; else zero
  std::vector<std::uint8_t> curve_is_late;         ///< ends of fans: in the first layer, neighbours go first
  std::vector<std::uint32_t> blunt_verts;          ///< of sharp edges at which no fan was made, ascending
  std::vector<std::uint32_t> curve_to_region;
  std::vector<std::uint32_t> curve_to_vert;
  std::vector<LayerHeights> curve_to_heights;               ///< the finest asked for on its triangles
  std::vector<double> curve_to_width;                       ///< mean length of the wall's edges there
  std::vector<std::uint32_t> curve_begin, curve_triangles;  ///< wall triangles at curve c: [begin[c], begin[c + 1])

  std::size_t curve_count() const { return curve_to_vert.size(); }
  std::size_t stack_count() const { return triangles.size() + fans.size(); }
  bool is_fan(std::size_t stack) const { return stack >= triangles.size(); }
  const FanElement& fan(std::size_t stack) const { return fans[stack - triangles.size()]; }
  /// Three or four.
  std::span<const std::uint32_t> curves_of(std::size_t stack) const {
    if (is_fan(stack)) return std::span(fan(stack).curves).first(fan(stack).size());
    return triangles[stack].curves;
  }
  const WallTriangle& wall_of(std::size_t stack) const { return triangles[is_fan(stack) ? fan(stack).wall : stack]; }
  /// One of the curves of its foot, the same for all of them.
  std::uint32_t first_at_foot(std::uint32_t curve) const {
    const std::uint32_t fan = curve_to_fan_vertex[curve];
    return fan == kNone ? curve : fan_vertices[fan].curves.front();
  }
  std::span<const std::uint32_t> triangles_at(std::uint32_t curve) const {
    return std::span(curve_triangles).subspan(curve_begin[curve], curve_begin[curve + 1] - curve_begin[curve]);
  }
  /// Marks all curves that share a wall triangle with this one; it as well, but for those of fans alone.
  void mark_around(std::uint32_t curve, std::vector<std::uint8_t>& is_marked) const {
    for (const std::uint32_t w : triangles_at(curve))
      for (const std::uint32_t other : triangles[w].curves) is_marked[other] = 1;
  }
};

/// The walls that `options` ask for on the surface mesh of a model. Faces without regions on the asked sides have none.
/// Vertices of `blunt_verts`, ascending, get no fans. The result depends on the arguments alone.
Walls find_walls(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const LayerOptions& options,
                 std::span<const std::uint32_t> blunt_verts = {});

}  // namespace tetloom::layers
