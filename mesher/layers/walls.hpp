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
struct Walls {
  std::vector<WallTriangle> triangles;  ///< by surface triangle, front side first
  std::vector<WallRim> rims;
  std::vector<std::uint32_t> curve_to_vert;
  std::vector<LayerHeights> curve_to_heights;               ///< the finest asked for on its triangles
  std::vector<double> curve_to_width;                       ///< mean length of the wall's edges there
  std::vector<std::uint32_t> curve_begin, curve_triangles;  ///< wall triangles at curve c: [begin[c], begin[c + 1])

  std::size_t curve_count() const { return curve_to_vert.size(); }
  std::span<const std::uint32_t> triangles_at(std::uint32_t curve) const {
    return std::span(curve_triangles).subspan(curve_begin[curve], curve_begin[curve + 1] - curve_begin[curve]);
  }
};

/// The walls that `options` ask for on the surface mesh of a model. Faces without regions on the asked sides have none.
/// The result depends on the arguments alone.
Walls find_walls(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const LayerOptions& options);

}  // namespace tetloom::layers
