#pragma once
// The topology of a triangulated patch: half-edges in flat arrays, three per triangle.
//
//            c                 half-edge h = 3 t + i runs from vertex i of triangle t to the next one,
//           / ^                counter-clockwise; next(h) and prev(h) stay in the triangle; twin(h) is
//    prev  /   \  next         the same edge seen from the neighbour, or kNone at the rim.
//         v     \              .
//        a ----> b             apex(h) = c
//            h
//
// An edge can be *fixed*: no flip, collapse or cavity passes through it. Rim edges are fixed, and so are the pieces of
// model edges inside the patch. Not thread-safe; one task owns a patch.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tetloom {

/// Triangles by their half-edges.
class Triangulation {
 public:
  static constexpr std::uint32_t kNone = 0xffffffffu;

  static constexpr std::uint32_t next(std::uint32_t h) { return h % 3 == 2 ? h - 2 : h + 1; }
  static constexpr std::uint32_t prev(std::uint32_t h) { return h % 3 == 0 ? h + 2 : h - 1; }

  /// Number of triangle slots, dead ones included.
  std::uint32_t slots() const { return static_cast<std::uint32_t>(vert_.size() / 3); }
  std::uint32_t half_edges() const { return static_cast<std::uint32_t>(vert_.size()); }
  bool alive(std::uint32_t tri) const { return vert_[3 * tri] != kNone; }
  std::uint32_t origin(std::uint32_t h) const { return vert_[h]; }
  std::uint32_t target(std::uint32_t h) const { return vert_[next(h)]; }
  std::uint32_t apex(std::uint32_t h) const { return vert_[prev(h)]; }
  std::uint32_t twin(std::uint32_t h) const { return twin_[h]; }
  std::array<std::uint32_t, 3> triangle(std::uint32_t tri) const {
    return {vert_[3 * tri], vert_[3 * tri + 1], vert_[3 * tri + 2]};
  }
  /// How many constraints lie on the edge; 0 when it is free.
  std::uint8_t fixed(std::uint32_t h) const { return fixed_[h]; }
  void fix(std::uint32_t h, std::uint8_t count);

  /// A half-edge that leaves `vertex`; kNone for a vertex without triangles.
  std::uint32_t outgoing(std::uint32_t vertex) const { return vert_to_half_edge_[vertex]; }
  std::uint32_t vertex_count() const { return static_cast<std::uint32_t>(vert_to_half_edge_.size()); }
  std::uint32_t add_vertex();
  /// Forgets the vertices from `count` on. Pre: no triangle uses them.
  void truncate_vertices(std::uint32_t count) { vert_to_half_edge_.resize(count); }

  /// A triangulation of `vertex_count` vertices. Pre: the triangles are an oriented manifold, with a rim or without.
  static Triangulation from_triangles(std::uint32_t vertex_count,
                                      std::span<const std::array<std::uint32_t, 3>> triangles);

  /// Room for that many vertices and the triangles between them, so that growing up to there copies nothing.
  void reserve(std::size_t vertices);

  /// Adds a triangle without neighbours and returns it.
  std::uint32_t add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  void remove_triangle(std::uint32_t tri);
  /// Makes two half-edges each other's twin (either may be kNone).
  void link(std::uint32_t h, std::uint32_t g);

  /// Calls visit(h) for every half-edge that leaves `vertex`, one per triangle of its ball, counter-clockwise up to the
  /// rim where there is one and then clockwise. `visit` returns false to stop.
  template <class Visit>
  void for_each_outgoing(std::uint32_t vertex, Visit&& visit) const {
    const std::uint32_t start = vert_to_half_edge_[vertex];
    for (std::uint32_t h = start; h != kNone;) {
      if (!visit(h)) return;
      h = twin_[prev(h)];
      if (h == start) return;
    }
    if (start == kNone) return;
    for (std::uint32_t g = twin_[start]; g != kNone; g = twin_[next(g)])
      if (!visit(next(g))) return;
  }
  /// The half-edge from a to b, or kNone. Takes as long as the smaller ball of the two is large, but where the other
  /// lies at a rim.
  std::uint32_t find_half_edge(std::uint32_t a, std::uint32_t b) const;

  /// Replaces the edge ab of the two triangles abc, bad by cd. Pre: h has a twin and is not fixed. The two triangles
  /// keep their slots; h becomes a half-edge of the same slot.
  void flip(std::uint32_t h);
  /// Replaces the triangles of a cavity by the fan of `vertex` over the cavity's rim.
  /// Pre: the cavity is connected and simply connected. Post: `created` holds the triangles of the fan, whose
  /// half-edges 0 are the rim.
  void fill_cavity(std::uint32_t vertex, std::span<const std::uint32_t> cavity, std::vector<std::uint32_t>& created);
  /// Splits the edge of h at `vertex`: two or four triangles replace one or two; a fixed edge gives two fixed ones.
  void split_edge(std::uint32_t h, std::uint32_t vertex);
  /// Moves the origin of h onto its target and removes the one or two triangles at the edge.
  /// Pre: the link condition holds (see `collapse_keeps_topology`).
  void collapse(std::uint32_t h);
  /// The link condition: the ends of h share only this edge and the apexes of the triangles at it, and the origin is
  /// not on a fixed edge.
  bool collapse_keeps_topology(std::uint32_t h) const;

  /// Drops dead slots. Half-edge and triangle numbers change, vertex numbers do not.
  void compact();
  /// Gives vertex v the number `vertex_numbers[v]` and makes the triangles those of `triangle_order`, in that order.
  /// Pre: the order lists every triangle alive once; the numbers are a permutation.
  void renumber(std::span<const std::uint32_t> vertex_numbers, std::span<const std::uint32_t> triangle_order);
  /// True when twins, origins and outgoing half-edges agree everywhere.
  bool validate() const;

 private:
  class Fan;
  std::uint32_t take_slot();

  std::vector<std::uint32_t> vert_;  // 3 per triangle
  std::vector<std::uint32_t> twin_;  // 3 per triangle
  std::vector<std::uint8_t> fixed_;  // 3 per triangle
  std::vector<std::uint32_t> vert_to_half_edge_;
  std::vector<std::uint32_t> free_;    // dead slots
  std::vector<std::uint32_t> fan_at_;  // scratch of fill_cavity: vertex → rim half-edge that starts there
};

}  // namespace tetloom
