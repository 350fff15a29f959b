#pragma once
// Where sharp convex edges get several growth curves at a vertex.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/layers/walls.hpp"

namespace tetloom::layers {

/// Wall triangles and how they hang together. Corner 3 · wall + i stands for vertex i of a wall triangle, and for the
/// edge that runs from it to the next one.
struct WallEdges {
  std::span<const Vec3> points;
  std::span<const WallTriangle> triangles;
  std::span<const std::uint32_t> across;  ///< per edge, the same one in the wall triangle on its other side, or none
};

constexpr std::uint32_t next_corner(std::uint32_t corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }
constexpr std::uint32_t last_corner(std::uint32_t corner) { return corner % 3 == 0 ? corner + 2 : corner - 1; }

/// Fans at all vertices where sharp edges part the triangles around them, but some.
///
/// Edges are sharp where the normals turn apart by more than an angle. Between their two sides lies one element, or two
/// where they turn by more than 100 degrees (trailing edges, rims of sheets). Where three or more sharp edges meet, the
/// sphere of directions between their curves is triangulated. Elsewhere fans end.
class FanPlan {
 public:
  /// `turn` in radians. `blunt_verts`, ascending, get no fans. Refers to `edges`.
  FanPlan(const WallEdges& edges, double turn, std::span<const std::uint32_t> blunt_verts);

  /// Whether the triangles on both sides of an edge have different curves at its start.
  bool parts_at_start(std::uint32_t edge) const;
  /// Adds elements, and curves without wall triangles. Pre: the wall triangles have their curves.
  void add_to(Walls& walls) const;

 private:
  struct Ring {
    std::vector<std::uint32_t> corners;    // counter-clockwise; of one vertex
    std::vector<std::uint32_t> crossings;  // sharp edges that lead to the vertex, counter-clockwise
    bool is_closed = false, is_fan = false;
    std::vector<std::array<std::uint32_t, 3>> closure;  // triangles of nodes, where three or more sharp edges meet
  };
  using Chains = std::vector<std::vector<std::uint32_t>>;  // per edge, curves at its end, from its triangle's side on

  void find_turns();
  void find_rings();
  void walk(std::uint32_t corner);
  void find_steps();
  void judge(Ring& ring);
  std::vector<Vec3> directions_between(std::uint32_t crossing) const;
  std::vector<std::vector<Vec3>> middle_directions(const Ring& ring) const;
  void drop_short_runs();
  bool find_closure(Ring& ring, const std::vector<Vec3>& groups);
  bool is_sharp(std::uint32_t edge) const { return turns_[edge] >= turn_; }
  void add_curves(const Ring& ring, Walls& walls, Chains& chains) const;
  void add_corners(const Ring& ring, Walls& walls, const Chains& chains) const;
  void add_elements(std::uint32_t edge, Walls& walls, const Chains& chains) const;
  std::uint32_t vertex(std::uint32_t corner) const { return edges_.triangles[corner / 3].verts[corner % 3]; }

  WallEdges edges_;
  double turn_;
  std::vector<Vec3> normals_;        // per wall triangle
  std::vector<double> turns_;        // per edge, radians
  std::vector<std::uint8_t> steps_;  // per sharp edge: elements between its sides
  std::vector<Ring> rings_;          // of vertices of sharp edges
  std::vector<std::uint32_t> corner_to_ring_;
};

}  // namespace tetloom::layers
