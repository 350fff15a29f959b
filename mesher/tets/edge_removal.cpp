#include "mesher/tets/edge_removal.hpp"

#include <algorithm>

#include "core/tets/ring_in_space.hpp"
#include "core/tets/ring_triangulation.hpp"
#include "mesher/tets/bad_tets.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

// In Delaunay meshes of points at good distances, no ring of 6 or more of some 200,000 tried could be bettered, and 1
// of 1,000 of 5: only what is very poor tries its luck.
constexpr int kUsualRing = 5;
constexpr float kVeryPoor = 0.13f;  // cubed quality

}  // namespace

namespace {

struct RingLimits {
  int longest;
  bool may_have_worse;  // tets than the one that is asked
};

EdgeVerdict walk_ring(const WorkingMesh& mesh, std::uint32_t tet, int edge, const RingLimits& limits, EdgeRing& ring) {
  const auto& corners = kEdgeCorners[static_cast<std::size_t>(edge)];
  const TetMesh& m = mesh.mesh();
  const auto verts = mesh.verts(tet);
  const float quality = mesh.quality(tet);
  ring.a = verts[corners[0]], ring.b = verts[corners[1]];
  ring.count = 0;
  // A face that has to stay has no other vertices than such that stay: most edges need no look at their faces.
  const bool may_be_on_surface = mesh.is_fixed_point(ring.a) && mesh.is_fixed_point(ring.b);
  std::uint32_t here = tet, leaving = corners[2], ahead = verts[corners[3]];
  ring.verts[0] = verts[corners[2]];
  for (;;) {
    ring.tets[ring.count++] = here;
    const FaceCode face(here, leaving), behind = m.behind(face);
    if (may_be_on_surface && (!behind.valid() || m.is_fixed(face))) return EdgeVerdict::OnSurface;
    here = behind.tet();
    if (here == tet) return EdgeVerdict::Removed;
    if (ring.count == limits.longest) return EdgeVerdict::LongRing;
    const float other = mesh.quality(here);
    if (!limits.may_have_worse && (other < quality || (other == quality && here < tet)))
      return EdgeVerdict::WorseBeside;
    ring.verts[ring.count] = ahead;
    leaving = mesh.corner_of(here, ahead);
    ahead = m.apex(behind);
  }
}

}  // namespace

EdgeVerdict find_ring(const WorkingMesh& mesh, std::uint32_t tet, int edge, EdgeRing& ring) {
  return walk_ring(mesh, tet, edge, {mesh.quality(tet) < kVeryPoor ? kLongestRing : kUsualRing, false}, ring);
}

bool find_any_ring(const WorkingMesh& mesh, std::uint32_t tet, int edge, EdgeRing& ring) {
  return walk_ring(mesh, tet, edge, {kMostRingVerts, true}, ring) == EdgeVerdict::Removed;
}

EdgeVerdict remove_edge_of(WorkingMesh& mesh, std::uint32_t tet) {
  double goal = std::max(double{mesh.quality(tet)} * kGain, kSurelyPositive);
  EdgeVerdict verdict = EdgeVerdict::OnSurface;
  EdgeRing ring, best;
  RingTriangles made;
  for (int edge = 0; edge < 6; ++edge) {
    const EdgeVerdict found = find_ring(mesh, tet, edge, ring);
    if (found != EdgeVerdict::Removed) {
      if (best.count == 0) verdict = std::max(verdict, found);
      continue;
    }
    const RingInSpace qualities(mesh, ring);
    RingTriangulation triangulation(qualities, ring.count);
    const double value = triangulation.maximize(goal);
    if (value <= goal) {
      if (best.count == 0) verdict = EdgeVerdict::NoGain;
      continue;
    }
    goal = value;
    made = triangulation.triangles();
    best = ring;
  }
  if (best.count == 0) return verdict;
  mesh.replace_ring(best, made.list());
  return EdgeVerdict::Removed;
}

std::size_t remove_edges(WorkingMesh& mesh, double limit, const TaskRunner& runner) {
  std::size_t count = 0;
  for_each_bad_tet(mesh, limit, runner,
                   [&](std::uint32_t tet) { count += remove_edge_of(mesh, tet) == EdgeVerdict::Removed; });
  return count;
}

}  // namespace tetloom::tets
