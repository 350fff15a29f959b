#include "mesher/features/surface_complex.hpp"

#include <algorithm>
#include <numeric>

#include "core/base/lists.hpp"

namespace tetloom::features {
namespace {

std::vector<std::uint32_t> numbers(std::size_t count) {
  std::vector<std::uint32_t> result(count);
  std::iota(result.begin(), result.end(), 0U);
  return result;
}

/// The items that are alive, in the order of the items of the input beside which they stand.
std::vector<std::uint32_t> survivors(const std::vector<std::uint8_t>& alive, const std::vector<std::uint32_t>& source) {
  std::vector<std::uint32_t> items;
  for (std::uint32_t i = 0; i < alive.size(); ++i)
    if (alive[i]) items.push_back(i);
  std::ranges::stable_sort(items, {}, [&](std::uint32_t i) { return source[i]; });
  return items;
}

}  // namespace

std::vector<std::uint32_t>& VertexItems::list(std::uint32_t v) {
  if (changed_[v] == kNone) {
    const std::span<const std::uint32_t> given = at(v);
    lists_.emplace_back(given.begin(), given.end());
    changed_[v] = static_cast<std::uint32_t>(lists_.size() - 1);
  }
  return lists_[changed_[v]];
}

SurfaceComplex::SurfaceComplex(SurfaceItems items, std::span<const FaceSides> sides)
    : items_(std::move(items)),
      sides_(sides),
      triangles_(items_.points.size(), items_.triangles),
      pieces_(items_.points.size(), items_.pieces),
      alive_(items_.triangles.size(), 1),
      piece_alive_(items_.pieces.size(), 1),
      was_used_(items_.points.size(), 0),
      source_(numbers(items_.triangles.size())),
      piece_source_(numbers(items_.pieces.size())) {
  for (std::uint32_t v = 0; v < point_count(); ++v) was_used_[v] = !triangles_at(v).empty() || !pieces_at(v).empty();
}

std::uint32_t SurfaceComplex::find_piece(std::uint32_t a, std::uint32_t b) const {
  for (const std::uint32_t p : pieces_at(a))
    if (has(piece(p), b)) return p;
  return kNone;
}

std::vector<std::uint32_t> SurfaceComplex::triangles_of_edge(std::uint32_t a, std::uint32_t b) const {
  std::vector<std::uint32_t> found;
  for (const std::uint32_t t : triangles_at(a))
    if (has(triangle(t), b)) found.push_back(t);
  return found;
}

std::vector<std::uint32_t> SurfaceComplex::neighbours(std::uint32_t v) const {
  std::vector<std::uint32_t> found;
  for (const std::uint32_t t : triangles_at(v))
    for (const std::uint32_t w : triangle(t))
      if (w != v) found.push_back(w);
  sort_unique(found);
  return found;
}

bool SurfaceComplex::is_singular(std::uint32_t v) const {
  std::vector<std::uint32_t> ends;
  for (const std::uint32_t t : triangles_at(v))
    for (const std::uint32_t w : triangle(t))
      if (w != v) ends.push_back(w);
  std::ranges::sort(ends);
  for (auto end = ends.begin(); end != ends.end();) {
    const auto next = std::upper_bound(end, ends.end(), *end);
    if (next - end != 2) return true;
    end = next;
  }
  return false;
}

void SurfaceComplex::remove_triangle(std::uint32_t t) {
  alive_[t] = 0;
  for (const std::uint32_t v : triangle(t)) triangles_.remove(v, t);
}

std::uint32_t SurfaceComplex::add_triangle(const Triangle& verts, std::uint32_t source) {
  const auto t = static_cast<std::uint32_t>(triangle_count());
  items_.triangles.push_back(verts);
  items_.tri_to_face.push_back(items_.tri_to_face[source]);
  alive_.push_back(1);
  source_.push_back(source_[source]);
  for (const std::uint32_t v : verts) triangles_.add(v, t);
  return t;
}

void SurfaceComplex::remove_piece(std::uint32_t p) {
  piece_alive_[p] = 0;
  for (const std::uint32_t v : piece(p)) pieces_.remove(v, p);
}

void SurfaceComplex::move_piece_end(std::uint32_t p, std::uint32_t from, std::uint32_t to) {
  for (std::uint32_t& v : items_.pieces[p])
    if (v == from) v = to;
  pieces_.remove(from, p);
  pieces_.add(to, p);
}

void SurfaceComplex::add_piece(const Piece& verts, std::uint32_t source) {
  const auto p = static_cast<std::uint32_t>(items_.pieces.size());
  items_.pieces.push_back(verts);
  items_.piece_to_edge.push_back(items_.piece_to_edge[source]);
  piece_alive_.push_back(1);
  piece_source_.push_back(piece_source_[source]);
  for (const std::uint32_t v : verts) pieces_.add(v, p);
}

void SurfaceComplex::move_point(std::uint32_t v, const Vec3& to, ModelEntity entity) {
  items_.points[v] = to;
  items_.point_to_entity[v] = entity;
}

std::vector<std::uint32_t> SurfaceComplex::triangles_left() const { return survivors(alive_, source_); }

std::vector<std::uint32_t> SurfaceComplex::pieces_left() const { return survivors(piece_alive_, piece_source_); }

}  // namespace tetloom::features
