#include "mesher/tets/surface_swap.hpp"

#include <algorithm>

#include "core/spatial/triangle_shape.hpp"
#include "core/tets/ring_in_space.hpp"

namespace tetloom::tets {

namespace {

constexpr double kSwapFloor = 0.5;  // mean ratio that triangles may fall to
constexpr double kFlat = 1e-6;      // distance of the two diagonals, in their lengths

struct RingPlace {
  std::uint32_t tet, first, second;  // the tet is (a, b, first, second)
};

bool stays(const TetMesh& mesh, FaceCode face) { return !mesh.behind(face).valid() || mesh.is_fixed(face); }

// Turns around the edge, against the ring's sense, up to a face that stays. False when there is none.
bool rewind(const WorkingMesh& mesh, RingPlace& place) {
  const TetMesh& m = mesh.mesh();
  for (std::size_t i = 0; i < WorkingMesh::kMostTets; ++i) {
    const FaceCode face(place.tet, mesh.corner_of(place.tet, place.second));
    if (stays(m, face)) return true;
    const FaceCode behind = m.behind(face);
    place = {behind.tet(), m.apex(behind), place.first};
  }
  return false;
}

// The tets from `place` to the next face that stays, which is returned; not valid when there are too many.
FaceCode collect(const WorkingMesh& mesh, RingPlace place, EdgeRing& ring) {
  const TetMesh& m = mesh.mesh();
  ring.verts[0] = place.first;
  for (ring.count = 1; ring.count < kMostRingVerts;) {
    ring.tets[static_cast<std::size_t>(ring.count) - 1] = place.tet;
    ring.verts[static_cast<std::size_t>(ring.count++)] = place.second;
    const FaceCode face(place.tet, mesh.corner_of(place.tet, place.first));
    if (stays(m, face)) return face;
    const FaceCode behind = m.behind(face);
    place = {behind.tet(), place.second, m.apex(behind)};
  }
  return {};
}

std::span<const std::uint32_t> tets_of(const EdgeRing& ring) {
  return {ring.tets.data(), static_cast<std::size_t>(std::max(ring.count - 1, 0))};
}

}  // namespace

SwapVerdict SurfaceSwapper::check_diamond(std::uint32_t a, std::uint32_t b) {
  SurfaceTriangles::Diamond& d = now_.diamond;
  if (!triangles_.has_edge(a, b)) return SwapVerdict::NotOnSurface;
  if (!triangles_.find_diamond(a, b, d) || surface_.tri_to_face[d.left] != surface_.tri_to_face[d.right] ||
      (surface_.is_kept && surface_.is_kept(a, b)))
    return SwapVerdict::OnModelEdge;
  return triangles_.has_edge(d.p, d.q) ? SwapVerdict::EdgeExists : SwapVerdict::Swapped;
}

// Both open rings, the one that `tet` is in first.
bool SurfaceSwapper::collect_rings(std::uint32_t tet, std::size_t edge) {
  const auto& corners = kEdgeCorners[edge];
  const auto verts = mesh_.verts(tet);
  RingPlace place{tet, verts[corners[2]], verts[corners[3]]};
  auto& [near, far] = now_.rings;
  near.a = far.a = verts[corners[0]], near.b = far.b = verts[corners[1]];
  far.count = 0;
  if (!rewind(mesh_, place)) return false;
  const TetMesh& m = mesh_.mesh();
  const FaceCode first(place.tet, mesh_.corner_of(place.tet, place.second));
  const FaceCode last = collect(mesh_, place, near);
  if (!last.valid()) return false;
  const std::uint32_t from = near.verts[0], to = near.verts[static_cast<std::size_t>(near.count) - 1];
  const auto& [p, q] = std::pair(now_.diamond.p, now_.diamond.q);
  if (!((from == p && to == q) || (from == q && to == p))) return false;
  const FaceCode beyond = m.behind(last);
  if (beyond.valid() != m.behind(first).valid()) return false;
  if (!beyond.valid()) return true;
  const FaceCode back = collect(mesh_, {beyond.tet(), to, m.apex(beyond)}, far);
  return back.valid() && m.behind(back) == first;
}

SwapVerdict SurfaceSwapper::triangulate(double goal) {
  double least = 1;
  int poor = 0;
  for (const EdgeRing& ring : now_.rings)
    for (const std::uint32_t tet : tets_of(ring))
      least = std::min<double>(least, mesh_.quality(tet)), poor += mesh_.quality(tet) < limit_;
  goal = std::max({goal, least * kGain, kSurelyPositive});
  now_.value = 2;
  for (std::size_t side = 0; side < 2; ++side) {
    now_.made_counts[side] = 0;
    if (now_.rings[side].count == 0) continue;
    const RingInSpace qualities(mesh_, now_.rings[side]);
    RingTriangulation triangulation(qualities, now_.rings[side].count);
    now_.value = std::min(now_.value, triangulation.maximize(goal));
    if (now_.value <= goal) return SwapVerdict::NoGain;
    const RingTriangles triangles = triangulation.triangles();
    for (const RingTriangle& triangle : triangles.list())
      for (const NewTet& tet : qualities.tets(triangle)) now_.made[side][now_.made_counts[side]++] = tet;
    for (const NewTet& tet : std::span(now_.made[side]).first(now_.made_counts[side])) poor -= tet.quality < limit_;
  }
  return poor < 0 ? SwapVerdict::NoGain : SwapVerdict::Swapped;
}

SwapVerdict SurfaceSwapper::check_shape() const {
  const auto worst = [&](const std::array<TriangleVerts, 2>& triangles) {
    double least = 1;
    for (const auto& [a, b, c] : triangles)
      least = std::min(least, triangle_mean_ratio(mesh_.point(a), mesh_.point(b), mesh_.point(c)));
    return least;
  };
  if (worst(now_.diamond.after()) < std::min(kSwapFloor, worst(now_.diamond.before())))
    return SwapVerdict::PoorTriangles;
  return (surface_.project ? is_true_to_model() : lies_in_plane()) ? SwapVerdict::Swapped : SwapVerdict::OffModel;
}

bool SurfaceSwapper::lies_in_plane() const {
  const SurfaceTriangles::Diamond& d = now_.diamond;
  const Vec3 &a = mesh_.point(d.a), &p = mesh_.point(d.p);
  const Vec3 ab = mesh_.point(d.b) - a, pq = mesh_.point(d.q) - p, normal = cross(ab, pq);
  if (!(std::abs(dot(normal, p - a)) <= kFlat * norm(normal) * (norm(ab) + norm(pq)))) return false;
  // Seen from the tip of the normal, ab then turns clockwise to pq: the diamond is convex when p lies to its left.
  return std::ranges::all_of(d.after(), [&](const TriangleVerts& t) {
    return dot(triangle_normal(mesh_.point(t[0]), mesh_.point(t[1]), mesh_.point(t[2])), normal) < 0;
  });
}

bool SurfaceSwapper::is_true_to_model() const {
  const SurfaceTriangles::Diamond& d = now_.diamond;
  const ModelEntity face = ModelFaceId(surface_.tri_to_face[d.left]);
  const Vec3 old_middle = 0.5 * (mesh_.point(d.a) + mesh_.point(d.b));
  const Vec3 middle = 0.5 * (mesh_.point(d.p) + mesh_.point(d.q));
  const std::optional<SurfaceSpot> spot = surface_.project(face, middle), old_spot = surface_.project(face, old_middle);
  if (!spot || !old_spot) return false;
  const double sag = kLargestSag * distance(mesh_.point(d.p), mesh_.point(d.q));
  if (distance(spot->point, middle) > std::max(sag, distance(old_spot->point, old_middle))) return false;
  const auto least_cosine = [&](const std::array<TriangleVerts, 2>& triangles) {
    double least = 1;
    for (const auto& [i, j, k] : triangles)
      least = std::min(least, dot(triangle_normal(mesh_.point(i), mesh_.point(j), mesh_.point(k)), spot->direction));
    return least;
  };
  const double cosine = least_cosine(d.after());
  return cosine > 0 && cosine >= std::min(kLeastCosine, least_cosine(d.before()));
}

SwapVerdict SurfaceSwapper::check_edge(std::uint32_t tet, std::size_t edge, double goal) {
  const auto verts = mesh_.verts(tet);
  const std::uint32_t a = verts[kEdgeCorners[edge][0]], b = verts[kEdgeCorners[edge][1]];
  if (const SwapVerdict verdict = check_diamond(a, b); verdict != SwapVerdict::Swapped) return verdict;
  if (!collect_rings(tet, edge)) return SwapVerdict::LongRing;
  if (const SwapVerdict verdict = triangulate(goal); verdict != SwapVerdict::Swapped) return verdict;
  return check_shape();
}

bool SurfaceSwapper::is_clear() const {
  if (!surface_.is_clear) return true;
  const std::array<std::uint32_t, 2> ids{best_.diamond.left, best_.diamond.right};
  const std::array<TriangleVerts, 2> after = best_.diamond.after();
  return surface_.is_clear({mesh_.mesh().points.span(), ids, after});
}

void SurfaceSwapper::apply() {
  std::array<CavitySide, 2> sides;
  for (std::size_t i = 0; i < 2; ++i)
    sides[i] = {tets_of(best_.rings[i]), std::span(best_.made[i]).first(best_.made_counts[i])};
  mesh_.replace_at_surface({best_.diamond.before(), best_.diamond.after()}, sides);
  triangles_.swap(best_.diamond);
}

SwapVerdict SurfaceSwapper::swap_edge_of(std::uint32_t tet) {
  SwapVerdict farthest = SwapVerdict::NotOnSurface;
  best_.value = 0;
  for (std::size_t edge = 0; edge < 6; ++edge) {
    const SwapVerdict verdict = check_edge(tet, edge, best_.value);
    farthest = std::max(farthest, verdict);
    if (verdict == SwapVerdict::Swapped) best_ = now_;
  }
  if (farthest != SwapVerdict::Swapped) return farthest;
  if (!is_clear()) return SwapVerdict::Blocked;
  apply();
  return SwapVerdict::Swapped;
}

}  // namespace tetloom::tets
