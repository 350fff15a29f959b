#include "mesher/tets/edge_removal.hpp"

#include <algorithm>

#include "mesher/tets/bad_tets.hpp"

namespace tetloom::tets {

namespace {

// In Delaunay meshes of points at good distances, no ring of 6 or more of some 200,000 tried could be bettered, and 1
// of 1,000 of 5: only what is very poor tries its luck.
constexpr int kUsualRing = 5;
constexpr float kVeryPoor = 0.13f;  // cubed quality

// The six edges of a tet with the other two corners, in even permutations.
constexpr std::array<std::array<std::uint8_t, 4>, 6> kEdgeCorners{
    {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 2, 0, 3}, {1, 3, 2, 0}, {2, 3, 0, 1}}};

// Chooses the triangulation of one ring.
class RingTriangulation {
 public:
  RingTriangulation(const WorkingMesh& mesh, const EdgeRing& ring) : ring_(ring), origin_(mesh.point(ring.a)) {
    b_ = mesh.point(ring.b) - origin_;
    for (int i = 0; i < ring.count; ++i) {
      points_[i] = mesh.point(ring.verts[i]) - origin_;
      to_a_[i] = norm2(points_[i]);
      to_b_[i] = norm2(points_[i] - b_);
    }
  }

  // The largest minimum, or something not above `goal` when there is none above it.
  double maximize(double goal) {
    const int n = ring_.count;
    for (int i = 0; i + 1 < n; ++i) best_[i][i + 1] = 2;
    for (int width = 2; width < n; ++width) {
      for (int i = 0; i + width < n; ++i) best_[i][i + width] = best_of(i, i + width, goal);
    }
    return best_[0][n - 1];
  }

  // The tets of the triangulation that `maximize` found.
  int build(std::array<NewTet, 2 * kLongestRing>& made) const {
    int count = 0;
    build(0, ring_.count - 1, made, count);
    return count;
  }

 private:
  double best_of(int i, int j, double goal) {
    double best = 0;
    for (int k = i + 1; k < j; ++k) {
      const double bound = std::min(best_[i][k], best_[k][j]);
      if (bound <= std::max(best, goal)) continue;
      const double value = std::min(bound, quality_of(i, k, j));
      if (value > best) best = value, apex_[i][j] = static_cast<std::uint8_t>(k);
    }
    return best;
  }

  // Of the worse of the two tets over one triangle.
  double quality_of(int i, int j, int k) const {
    const Vec3 &p = points_[i], &q = points_[j], &r = points_[k];
    const Vec3 normal = cross(q - p, r - p);
    const double below = dot(normal, p), above = dot(normal, b_ - p);
    if (!(below > 0 && above > 0)) return 0;
    const double sides = norm2(q - p) + norm2(r - q) + norm2(p - r);
    return std::min(cubed_quality(below, sides + to_a_[i] + to_a_[j] + to_a_[k]),
                    cubed_quality(above, sides + to_b_[i] + to_b_[j] + to_b_[k]));
  }

  void build(int i, int j, std::array<NewTet, 2 * kLongestRing>& made, int& count) const {
    if (j - i < 2) return;
    const int k = apex_[i][j];
    const std::uint32_t p = ring_.verts[i], q = ring_.verts[k], r = ring_.verts[j];
    const Vec3 zero;
    made[count++] = {{p, q, r, ring_.b}, cubed_quality(points_[i], points_[k], points_[j], b_)};
    made[count++] = {{p, r, q, ring_.a}, cubed_quality(points_[i], points_[j], points_[k], zero)};
    build(i, k, made, count);
    build(k, j, made, count);
  }

  const EdgeRing& ring_;
  Vec3 origin_, b_;
  std::array<Vec3, kLongestRing> points_;
  std::array<double, kLongestRing> to_a_, to_b_;
  double best_[kLongestRing][kLongestRing];
  std::uint8_t apex_[kLongestRing][kLongestRing];
};

}  // namespace

EdgeVerdict find_ring(const WorkingMesh& mesh, std::uint32_t tet, int edge, EdgeRing& ring) {
  const auto& corners = kEdgeCorners[static_cast<std::size_t>(edge)];
  const TetMesh& m = mesh.mesh();
  const auto verts = mesh.verts(tet);
  const float quality = mesh.quality(tet);
  ring.a = verts[corners[0]], ring.b = verts[corners[1]];
  ring.count = 0;
  const int longest = quality < kVeryPoor ? kLongestRing : kUsualRing;
  // A face that has to stay has no other vertices than such that stay: most edges need no look at their faces.
  const bool may_be_on_surface = mesh.is_fixed_point(ring.a) && mesh.is_fixed_point(ring.b);
  std::uint32_t here = tet, leaving = corners[2], ahead = verts[corners[3]];
  ring.verts[0] = verts[corners[2]];
  for (;;) {
    ring.tets[ring.count++] = here;
    const FaceCode face = here * 4 + leaving, behind = m.to_neighbor[face];
    if (may_be_on_surface && (behind == kNone || m.is_fixed(face))) return EdgeVerdict::OnSurface;
    here = behind / 4;
    if (here == tet) return EdgeVerdict::Removed;
    if (ring.count == longest) return EdgeVerdict::LongRing;
    const float other = mesh.quality(here);
    if (other < quality || (other == quality && here < tet)) return EdgeVerdict::WorseBeside;
    ring.verts[ring.count] = ahead;
    leaving = mesh.corner_of(here, ahead);
    ahead = m.to_vert[behind];
  }
}

EdgeVerdict remove_edge_of(WorkingMesh& mesh, std::uint32_t tet) {
  double goal = std::max(double{mesh.quality(tet)} * kGain, kSurelyPositive);
  EdgeVerdict verdict = EdgeVerdict::OnSurface;
  EdgeRing ring;
  std::array<NewTet, 2 * kLongestRing> made;
  std::array<std::uint32_t, kLongestRing> old;
  int made_count = 0, old_count = 0;
  for (int edge = 0; edge < 6; ++edge) {
    const EdgeVerdict found = find_ring(mesh, tet, edge, ring);
    if (found != EdgeVerdict::Removed) {
      if (made_count == 0) verdict = std::max(verdict, found);
      continue;
    }
    RingTriangulation triangulation(mesh, ring);
    const double value = triangulation.maximize(goal);
    if (value <= goal) {
      if (made_count == 0) verdict = EdgeVerdict::NoGain;
      continue;
    }
    goal = value;
    made_count = triangulation.build(made);
    old = ring.tets, old_count = ring.count;
  }
  if (made_count == 0) return verdict;
  mesh.replace(std::span(old).first(static_cast<std::size_t>(old_count)),
               std::span(made).first(static_cast<std::size_t>(made_count)));
  return EdgeVerdict::Removed;
}

std::size_t remove_edges(WorkingMesh& mesh, double limit, const TaskRunner& runner) {
  std::size_t count = 0;
  for_each_bad_tet(mesh, limit, runner,
                   [&](std::uint32_t tet) { count += remove_edge_of(mesh, tet) == EdgeVerdict::Removed; });
  return count;
}

}  // namespace tetloom::tets
