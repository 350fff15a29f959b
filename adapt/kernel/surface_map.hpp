#pragma once
// The triangles and the pieces of model edges that tets of a part have as faces and edges, by their vertices.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>

#include "core/base/mix_bits.hpp"
#include "core/tets/triangle_verts.hpp"
#include "tetloom/ids.hpp"

namespace tetloom::adapt {

/// Bit of a model edge, in pieces at which tets touch that do not hang together there: they stay as they are.
/// Numbers of entities have room for it.
inline constexpr std::uint32_t kTouching = std::uint32_t{1} << 29;

using Triangle = std::array<std::uint32_t, 3>;

/// A triangle of the surface: its vertices, counter-clockwise seen from the tip of the model face's normal.
struct SurfaceTriangle {
  Triangle verts;
  std::uint32_t face = kNone;  ///< model face
};

/// The triangles of the surface by their vertices.
class SurfaceMap {
 public:
  void add(const SurfaceTriangle& triangle) { triangles_.emplace(key_of(triangle.verts), triangle); }
  void remove(const Triangle& verts) { triangles_.erase(key_of(verts)); }
  const SurfaceTriangle* find(const Triangle& verts) const {
    const auto at = triangles_.find(key_of(verts));
    return at == triangles_.end() ? nullptr : &at->second;
  }

  void add_edge(std::uint32_t a, std::uint32_t b, std::uint32_t model_edge) {
    edges_.emplace(key_of(a, b), model_edge);
  }
  void remove_edge(std::uint32_t a, std::uint32_t b) { edges_.erase(key_of(a, b)); }
  /// The model edge that the edge is a piece of; kNone where it is of none.
  std::uint32_t find_edge(std::uint32_t a, std::uint32_t b) const {
    const auto at = edges_.find(key_of(a, b));
    return at == edges_.end() ? kNone : at->second;
  }

  /// In no order.
  template <class Visit>
  void for_each_triangle(Visit&& visit) const {
    for (const auto& [key, triangle] : triangles_) visit(triangle);
  }
  template <class Visit>
  void for_each_edge(Visit&& visit) const {
    for (const auto& [key, edge] : edges_)
      visit(static_cast<std::uint32_t>(key >> 32), static_cast<std::uint32_t>(key), edge);
  }
  /// Gives every vertex its new number.
  void renumber(std::span<const std::uint32_t> to_new) {
    SurfaceMap old = std::move(*this);
    *this = SurfaceMap();
    triangles_.reserve(old.triangles_.size());
    old.for_each_triangle([&](SurfaceTriangle triangle) {
      for (std::uint32_t& v : triangle.verts) v = to_new[v];
      add(triangle);
    });
    old.for_each_edge(
        [&](std::uint32_t a, std::uint32_t b, std::uint32_t edge) { add_edge(to_new[a], to_new[b], edge); });
  }
  std::size_t triangle_count() const { return triangles_.size(); }
  std::size_t edge_count() const { return edges_.size(); }

 private:
  struct Hash {
    std::size_t operator()(const Triangle& key) const {
      return mix_bits((std::uint64_t{key[0]} << 32 | key[1]) * 0x9e3779b97f4a7c15u + key[2]);
    }
    std::size_t operator()(std::uint64_t key) const { return mix_bits(key); }
  };
  static Triangle key_of(Triangle verts) {
    std::sort(verts.begin(), verts.end());
    return verts;
  }
  static std::uint64_t key_of(std::uint32_t a, std::uint32_t b) {
    return a < b ? std::uint64_t{a} << 32 | b : std::uint64_t{b} << 32 | a;
  }

  std::unordered_map<Triangle, SurfaceTriangle, Hash> triangles_;
  std::unordered_map<std::uint64_t, std::uint32_t, Hash> edges_;
};

}  // namespace tetloom::adapt
