#pragma once
// A triangulated surface that changes locally: triangles and pieces of model edges at every vertex. The surface may be
// of any topology: closed or open, and more than two triangles may share an edge.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "tetloom/mesh_data.hpp"

namespace tetloom::features {

/// A triangle of the surface by its points.
using Triangle = std::array<std::uint32_t, 3>;
/// A mesh edge on a model edge, by its points.
using Piece = std::array<std::uint32_t, 2>;

/// Which items (triangles, pieces) are at each vertex. Built at once; afterwards lists change one by one.
class VertexItems {
 public:
  VertexItems() = default;
  /// `item_to_verts[i]` are the vertices of item i.
  template <std::size_t N>
  VertexItems(std::size_t vertex_count, const std::vector<std::array<std::uint32_t, N>>& item_to_verts)
      : first_(vertex_count + 2, 0), changed_(vertex_count, kNone) {
    for (const auto& verts : item_to_verts)
      for (const std::uint32_t v : verts) ++first_[v + 2];
    for (std::size_t v = 0; v + 2 < first_.size(); ++v) first_[v + 2] += first_[v + 1];
    items_.resize(first_.back());
    for (std::uint32_t i = 0; i < item_to_verts.size(); ++i)
      for (const std::uint32_t v : item_to_verts[i]) items_[first_[v + 1]++] = i;
  }

  std::span<const std::uint32_t> at(std::uint32_t v) const {
    if (changed_[v] != kNone) return lists_[changed_[v]];
    return {items_.data() + first_[v], items_.data() + first_[v + 1]};
  }
  void add(std::uint32_t v, std::uint32_t item) { list(v).push_back(item); }
  void remove(std::uint32_t v, std::uint32_t item) { std::erase(list(v), item); }

 private:
  std::vector<std::uint32_t>& list(std::uint32_t v);

  std::vector<std::uint32_t> first_, items_;
  std::vector<std::uint32_t> changed_;  // per vertex, an index into `lists_` once its list has changed
  std::vector<std::vector<std::uint32_t>> lists_;
};

/// Points, triangles and pieces of a mesh without cells, with the model entities that they lie on.
struct SurfaceItems {
  std::vector<Vec3> points;
  std::vector<ModelEntity> point_to_entity;
  std::vector<Triangle> triangles;
  std::vector<std::uint32_t> tri_to_face;
  std::vector<Piece> pieces;
  std::vector<std::uint32_t> piece_to_edge;
  bool operator==(const SurfaceItems&) const = default;
};

/// A surface on the way to another one. Complexity of the queries: the
/// number of triangles at a vertex.
class SurfaceComplex {
 public:
  /// `sides` are those of the model's faces, and outlive the surface.
  SurfaceComplex(SurfaceItems items, std::span<const FaceSides> sides);

  std::size_t point_count() const { return items_.points.size(); }
  std::size_t triangle_count() const { return items_.triangles.size(); }
  const Vec3& point(std::uint32_t v) const { return items_.points[v]; }
  ModelEntity entity(std::uint32_t v) const { return items_.point_to_entity[v]; }
  const Triangle& triangle(std::uint32_t t) const { return items_.triangles[t]; }
  std::uint32_t face(std::uint32_t t) const { return items_.tri_to_face[t]; }
  FaceSides sides(std::uint32_t t) const { return sides_[face(t)]; }
  bool is_alive(std::uint32_t t) const { return alive_[t] != 0; }
  std::span<const std::uint32_t> triangles_at(std::uint32_t v) const { return triangles_.at(v); }
  /// Pieces of model edges that end at `v`.
  std::span<const std::uint32_t> pieces_at(std::uint32_t v) const { return pieces_.at(v); }
  const Piece& piece(std::uint32_t p) const { return items_.pieces[p]; }
  std::uint32_t piece_edge(std::uint32_t p) const { return items_.piece_to_edge[p]; }

  /// The piece between two vertices, or kNone.
  std::uint32_t find_piece(std::uint32_t a, std::uint32_t b) const;
  /// Triangles that have both vertices, in the order of those at `a`.
  std::vector<std::uint32_t> triangles_of_edge(std::uint32_t a, std::uint32_t b) const;
  /// All vertices that share a triangle with `v`, ascending.
  std::vector<std::uint32_t> neighbours(std::uint32_t v) const;
  /// Whether an edge at `v` has fewer or more than two triangles: the rim of a sheet, or where several surfaces meet.
  bool is_singular(std::uint32_t v) const;

  void remove_triangle(std::uint32_t t);
  /// A new triangle of the same face as `source`; its place in the result is beside it.
  std::uint32_t add_triangle(const Triangle& verts, std::uint32_t source);
  void remove_piece(std::uint32_t p);
  void move_piece_end(std::uint32_t p, std::uint32_t from, std::uint32_t to);
  void add_piece(const Piece& verts, std::uint32_t source);
  void move_point(std::uint32_t v, const Vec3& to, ModelEntity entity);

  /// The triangles and pieces that are there, in the order of the given ones beside which they stand: those.
  std::vector<std::uint32_t> triangles_left() const;
  std::vector<std::uint32_t> pieces_left() const;
  std::uint32_t source(std::uint32_t t) const { return source_[t]; }
  std::uint32_t piece_source(std::uint32_t p) const { return piece_source_[p]; }
  /// Points that had triangles or pieces and have none any more.
  bool is_gone(std::uint32_t v) const { return was_used_[v] && triangles_at(v).empty() && pieces_at(v).empty(); }

 private:
  SurfaceItems items_;
  std::span<const FaceSides> sides_;
  VertexItems triangles_, pieces_;
  std::vector<std::uint8_t> alive_, piece_alive_, was_used_;
  std::vector<std::uint32_t> source_, piece_source_;  // the item of the input beside which each one stands
};

}  // namespace tetloom::features
