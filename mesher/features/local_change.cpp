#include "mesher/features/local_change.hpp"

#include <algorithm>
#include <iterator>

#include "core/base/lists.hpp"

namespace tetloom::features {
namespace {

Triangle with(Triangle verts, std::uint32_t from, std::uint32_t to) {
  std::ranges::replace(verts, from, to);
  return verts;
}

std::uint32_t third(const Triangle& verts, std::uint32_t a, std::uint32_t b) {
  for (const std::uint32_t v : verts)
    if (v != a && v != b) return v;
  return kNone;
}

// A vertex may be merged into one on an entity of the same or a lower dimension, in a face only within that face.
bool keeps_classification(ModelEntity gone, ModelEntity kept) {
  return kept.dim < gone.dim || (kept.dim == gone.dim && (gone.dim < 2 || kept == gone));
}

// Common neighbours are exactly the third corners of the triangles at the edge, and none of these has a triangle with
// two of the others that would then be there twice.
bool meets_link_condition(const SurfaceComplex& surface, std::uint32_t a, std::uint32_t b,
                          const std::vector<std::uint32_t>& at_edge) {
  std::vector<std::uint32_t> common, thirds;
  std::ranges::set_intersection(surface.neighbours(a), surface.neighbours(b), std::back_inserter(common));
  for (const std::uint32_t t : at_edge) thirds.push_back(third(surface.triangle(t), a, b));
  std::ranges::sort(thirds);
  if (common != thirds) return false;
  for (const std::uint32_t t : surface.triangles_at(a)) {
    const Triangle& verts = surface.triangle(t);
    if (has(verts, b)) continue;
    const Triangle moved = with(verts, a, b);
    for (const std::uint32_t other : surface.triangles_at(b))
      if (std::ranges::all_of(surface.triangle(other), [&](std::uint32_t v) { return has(moved, v); })) return false;
  }
  return true;
}

void move_pieces(std::uint32_t gone, std::uint32_t kept, SurfaceComplex& surface) {
  const std::vector<std::uint32_t> pieces(surface.pieces_at(gone).begin(), surface.pieces_at(gone).end());
  for (const std::uint32_t p : pieces) {
    const auto [a, b] = surface.piece(p);
    const std::uint32_t other = a == gone ? b : a;
    if (other == kept || surface.find_piece(kept, other) != kNone)
      surface.remove_piece(p);
    else
      surface.move_piece_end(p, gone, kept);
  }
}

void split_piece(const Piece& edge, std::uint32_t middle, SurfaceComplex& surface) {
  const std::uint32_t p = surface.find_piece(edge[0], edge[1]);
  if (p == kNone) return;
  const auto [a, b] = surface.piece(p);
  if (surface.find_piece(a, middle) == kNone) surface.add_piece({a, middle}, p);
  if (surface.find_piece(middle, b) == kNone) surface.add_piece({middle, b}, p);
  surface.remove_piece(p);
}

}  // namespace

std::optional<LocalChange> plan_collapse(const SurfaceComplex& surface, std::uint32_t gone, std::uint32_t kept) {
  if (!keeps_classification(surface.entity(gone), surface.entity(kept))) return {};
  const std::vector<std::uint32_t> at_edge = surface.triangles_of_edge(gone, kept);
  if (at_edge.empty() || !meets_link_condition(surface, gone, kept, at_edge)) return {};
  if (at_edge.size() == 2 && surface.is_singular(gone) && surface.is_singular(kept)) return {};
  LocalChange change;
  change.gone = gone;
  change.kept = kept;
  change.place = surface.point(kept);
  change.entity = surface.entity(kept);
  for (const std::uint32_t t : surface.triangles_at(gone)) {
    change.removed.push_back(t);
    const Triangle& verts = surface.triangle(t);
    if (!has(verts, kept)) change.added.push_back({with(verts, gone, kept), t});
  }
  return change;
}

std::optional<LocalChange> plan_snap(const SurfaceComplex& surface, std::uint32_t triangle, int i) {
  const Triangle verts = surface.triangle(triangle);
  const auto at = static_cast<std::size_t>(i);
  const std::uint32_t apex = verts[at], u = verts[(at + 1) % 3], v = verts[(at + 2) % 3];
  const std::vector<std::uint32_t> at_edge = surface.triangles_of_edge(u, v);
  if (at_edge.size() != 2 && surface.is_singular(apex)) return {};
  const std::vector<std::uint32_t> near = surface.neighbours(apex);
  LocalChange change;
  change.kept = apex;
  change.split = {u, v};
  change.place = surface.point(apex);
  change.entity = surface.entity(apex);
  for (const std::uint32_t t : at_edge) {
    change.removed.push_back(t);
    if (t == triangle) continue;
    const Triangle& other = surface.triangle(t);
    if (std::ranges::binary_search(near, third(other, u, v))) return {};
    change.added.push_back({with(other, v, apex), t});
    change.added.push_back({with(other, u, apex), t});
  }
  const std::uint32_t piece = surface.find_piece(u, v);
  if (piece == kNone || change.entity.dim < 2) return change;
  const Vec3 &a = surface.point(u), ab = surface.point(v) - a;
  if (!(norm2(ab) > 0)) return {};
  change.place = a + (dot(change.place - a, ab) / norm2(ab)) * ab;
  change.entity = ModelEdgeId(surface.piece_edge(piece));
  for (const std::uint32_t t : surface.triangles_at(apex)) {
    if (t == triangle) continue;
    change.removed.push_back(t);
    change.added.push_back({surface.triangle(t), t});
  }
  return change;
}

void apply(const LocalChange& change, SurfaceComplex& surface) {
  for (const std::uint32_t t : change.removed) surface.remove_triangle(t);
  for (const AddedTriangle& added : change.added) surface.add_triangle(added.verts, added.source);
  if (change.gone != kNone) move_pieces(change.gone, change.kept, surface);
  if (change.split[0] != kNone) split_piece(change.split, change.kept, surface);
  surface.move_point(change.kept, change.place, change.entity);
}

}  // namespace tetloom::features
