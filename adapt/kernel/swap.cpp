#include <algorithm>

#include "adapt/kernel/passes.hpp"
#include "adapt/kernel/ring_in_metric.hpp"
#include "core/tets/ring_triangulation.hpp"

namespace tetloom::adapt {

namespace {

using tets::verts_of;

constexpr double kGain = 1.0001;
constexpr std::size_t kMostTets = 8;  // at an edge that is swapped
constexpr std::size_t kEdges = 3;     // of a tet that are tried

// What it pays to swap at a tet: of 40,000 swaps in two meshes, the best was at its longest three edges or at the face
// with the longest ones in 98 % (the longest edge alone: 62 %).
struct Longest {
  std::array<std::array<std::uint8_t, 2>, kEdges> edges;  // corners
  std::uint32_t face;                                     // opposite corner
};

Longest find_longest(const CavityMesh& mesh, const std::array<std::uint32_t, 4>& v) {
  const Tensor& metric = densest_metric(mesh.to_metric, v).tensor;
  std::array<std::pair<double, std::size_t>, 6> edges;
  std::array<double, 4> at_corner{};
  for (std::size_t k = 0; k < 6; ++k) {
    const auto& [i, j] = tets::kEdgeVerts[k];
    const double squared = dot(metric, mesh.point(v[j]) - mesh.point(v[i]));
    edges[k] = {-squared, k};
    at_corner[i] += squared, at_corner[j] += squared;
  }
  std::partial_sort(edges.begin(), edges.begin() + kEdges, edges.end());
  Longest longest{};
  for (std::size_t k = 0; k < kEdges; ++k) longest.edges[k] = tets::kEdgeVerts[edges[k].second];
  longest.face = static_cast<std::uint32_t>(std::min_element(at_corner.begin(), at_corner.end()) - at_corner.begin());
  return longest;
}

}  // namespace

// Fills ends_ with the vertices of the surface that may take the place of an edge of it. False: the edge has to stay.
// Pre: cavity_ is that of the edge.
bool Passes::find_ends(const std::array<std::uint32_t, 2>& edge) {
  ends_.clear();
  if (cavity_.surface.size() != 2 || is_frozen(cavity_) || mesh_.surface.find_edge(edge[0], edge[1]) != kNone)
    return false;
  const Triangle s = verts_of(mesh_.mesh, cavity_.surface[0]), t = verts_of(mesh_.mesh, cavity_.surface[1]);
  if (mesh_.surface.find(s)->face != mesh_.surface.find(t)->face) return false;
  for (const Triangle& triangle : {s, t})
    for (const std::uint32_t v : triangle)
      if (v != edge[0] && v != edge[1]) ends_.push_back(v);
  return true;
}

// Only where `tet` is the worst of those at the edge, which is where it will be asked.
void Passes::try_edge_swaps(std::uint32_t tet, const std::array<std::uint32_t, 2>& edge, Choice& best) {
  if (!mesh_.collect_around_worst(edge, tet, kMostTets, cavity_)) return;
  if (cavity_.surface.empty()) {
    tets::EdgeRing ring;
    if (mesh_.find_ring(cavity_, ring)) try_ring(ring, best);
    return;
  }
  if (!find_ends(edge)) return;
  for (const std::uint32_t v : ends_) {
    const double least = mesh_.evaluate(cavity_, v, best.least, made_);
    if (!(least > best.least) || !keeps_surface(cavity_, v)) continue;
    best = {least, {edge[0], edge[1], kNone}, 2, v, {}};
  }
}

// The best triangulation of the ring of an edge inside.
void Passes::try_ring(const tets::EdgeRing& ring, Choice& best) {
  if (ring.count < 3) return;
  const RingInMetric qualities(mesh_, ring);
  tets::RingTriangulation triangulation(qualities, ring.count);
  const double least = triangulation.maximize(best.least);
  if (!(least > best.least)) return;
  best = {least, {}, 0, kNone, triangulation.triangles()};
  ring_ = ring;
}

// The face opposite to `corner` gives way to an edge between the vertices on both sides.
void Passes::try_face_swap(std::uint32_t tet, std::uint32_t corner, Choice& best) {
  const FaceCode face(tet, corner), behind = mesh_.mesh.behind(face);
  if (!behind.valid() || mesh_.mesh.is_fixed(face)) return;
  if (mesh_.to_quality[behind.tet()] < mesh_.to_quality[tet]) return;
  const Triangle core = verts_of(mesh_.mesh, face);
  if (!mesh_.collect(core, tet, cavity_)) return;
  const std::uint32_t apex = mesh_.mesh.apex(behind);
  const double least = mesh_.evaluate(cavity_, apex, best.least, made_);
  if (least > best.least) best = {least, core, 3, apex, {}};
}

Verdict Passes::swap_at(std::uint32_t tet) {
  Choice best{std::max(double{mesh_.to_quality[tet]} * kGain, tets::kSurelyPositive)};
  std::array<std::uint32_t, 4> v;
  std::copy_n(mesh_.verts(tet), 4, v.begin());
  const Longest longest = find_longest(mesh_, v);
  for (const auto& [i, j] : longest.edges) try_edge_swaps(tet, {v[i], v[j]}, best);
  try_face_swap(tet, longest.face, best);
  if (best.triangles.count > 0) {
    mesh_.replace_ring(ring_, best.triangles.list());
    return Verdict::Done;
  }
  if (best.target == kNone) return Verdict::NoGain;
  mesh_.collect(std::span(best.core).first(best.core_size), tet, cavity_);
  mesh_.evaluate(cavity_, best.target, -1, made_);
  mesh_.reconnect(cavity_, best.target, made_);
  return Verdict::Done;
}

}  // namespace tetloom::adapt
