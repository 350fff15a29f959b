#include "mesher/tets/point_insertion.hpp"

#include <algorithm>
#include <optional>

#include "core/tets/deep_point.hpp"
#include "core/tets/newton_step.hpp"
#include "mesher/tets/bad_tets.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

constexpr std::size_t kMostGrowth = 12;  // tets that join a cavity after its start
constexpr int kNewtonSteps = 4;          // of Newton's method, for one cavity
constexpr double kMuchBetter = 1.3;      // in cubed quality, where as many tets stay poor, or one is nearly flat
constexpr double kTwiceAsGood = 2;       // the same, where more tets become poor
constexpr double kNearlyFlatCavity = 0.15 * 0.15 * 0.15;  // what tets with an angle below two degrees have at most

// Faces are listed counter-clockwise from outside; turned, they are seen from inside.
std::array<std::uint32_t, 3> inward_face(const TetMesh& mesh, FaceCode face) {
  const auto& [a, c, b] = kFaceVerts[face.side()];
  const std::uint32_t* verts = &mesh.to_vert[std::size_t{face.tet()} * 4];
  return {verts[a], verts[b], verts[c]};
}

}  // namespace

// False when the tet does not fit in, or is there already.
bool PointInserter::add_tet(std::uint32_t tet) {
  const TetMesh& m = mesh_.mesh();
  const auto tets = now_.old();
  if (now_.tet_count == now_.tets.size() || now_.facet_count + 3 > now_.facets.size()) return false;
  if (std::find(tets.begin(), tets.end(), tet) != tets.end()) return false;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const FaceCode face(tet, i), behind = m.is_fixed(face) ? FaceCode() : m.behind(face);
    const bool inner = behind.valid() && std::find(tets.begin(), tets.end(), behind.tet()) != tets.end();
    if (!inner) {
      now_.facets[now_.facet_count++] = {inward_face(m, face), behind};
      continue;
    }
    std::size_t at = 0;
    while (now_.facets[at].behind != face) ++at;
    now_.facets[at] = now_.facets[--now_.facet_count];
  }
  now_.tets[now_.tet_count++] = tet;
  now_.least_before = std::min(now_.least_before, double{mesh_.quality(tet)});
  now_.poor_before += mesh_.quality(tet) < limit_;
  return true;
}

bool PointInserter::set_cavity(std::span<const std::uint32_t> tets) {
  now_.tet_count = now_.facet_count = 0;
  now_.least_before = 1;
  now_.poor_before = 0;
  return std::all_of(tets.begin(), tets.end(), [&](std::uint32_t tet) { return add_tet(tet); });
}

Vec3 PointInserter::middle() const {
  Vec3 sum{};
  for (std::size_t i = 0; i < now_.facet_count; ++i)
    for (const std::uint32_t v : now_.facets[i].verts) sum += mesh_.point(v);
  return (1.0 / (3.0 * static_cast<double>(now_.facet_count))) * sum;
}

// The star of the cavity's boundary, seen from the point.
void PointInserter::measure() {
  for (std::size_t i = 0; i < now_.facet_count; ++i) {
    const auto& [a, b, c] = now_.facets[i].verts;
    star_[i] = star_tet(mesh_.point(a) - now_.point, mesh_.point(b) - now_.point, mesh_.point(c) - now_.point);
  }
}

int PointInserter::count_poor() const {
  int count = 0;
  for (std::size_t i = 0; i < now_.facet_count; ++i) count += cubed_quality(star_[i].volume, star_[i].squares) < limit_;
  return count;
}

std::size_t PointInserter::worst_facet() const {
  std::size_t worst = 0;
  double least = 2;
  for (std::size_t i = 0; i < now_.facet_count; ++i) {
    const double quality = cubed_quality(star_[i].volume, star_[i].squares);
    if (quality < least) least = quality, worst = i;
  }
  return worst;
}

// False when the cavity is not star-shaped around the point.
bool PointInserter::lead_point() {
  for (int i = 0; i < kNewtonSteps; ++i) {
    measure();
    const std::span<const StarTet> star = std::span(star_).first(now_.facet_count);
    const auto is_positive = [](const StarTet& tet) { return tet.is_surely_positive_at({}); };
    if (!std::all_of(star.begin(), star.end(), is_positive)) return false;
    const Vec3 step = find_newton_step(star, now_.point, kSurelyPositive);
    if (step == Vec3{}) break;
    now_.point += step;
  }
  measure();
  const StarTet& worst = star_[worst_facet()];
  now_.least = cubed_quality(worst.volume, worst.squares);
  now_.gain = now_.poor_before - count_poor();
  return now_.least > kSurelyPositive;
}

// False when the cavity is not star-shaped around any point.
bool PointInserter::go_deep() {
  now_.point = middle();
  measure();
  const auto deep = find_deep_point(std::span(star_).first(now_.facet_count));
  if (!deep || !(deep->depth > 0)) return false;
  now_.point += deep->point;
  return lead_point();
}

// From `point`, or, where that lies in the plane of a flat tet, say, from the middle of the cavity. Newton's method
// does not come far from a place that is next to a facet: where a tet is nearly flat, it starts from the deepest then.
bool PointInserter::place_point(const Vec3& point) {
  now_.point = point;
  bool is_placed = lead_point();
  if (!is_placed) {
    now_.point = middle();
    is_placed = lead_point();
  }
  if (now_.least_before >= kNearlyFlatCavity || (is_placed && now_.least >= kNearlyFlatCavity)) return is_placed;
  return go_deep();
}

void PointInserter::try_cavity(std::span<const std::uint32_t> tets, const Vec3& point) {
  if (!set_cavity(tets) || !place_point(point)) return;
  kept_ = now_;
  for (std::size_t i = 0; i < kMostGrowth; ++i) {
    const FaceCode behind = now_.facets[worst_facet()].behind;
    if (!behind.valid() || !add_tet(behind.tet()) || !lead_point() || now_.least <= kept_.least) break;
    kept_ = now_;
  }
  const bool was_flat = kept_.least_before < kNearlyFlatCavity;
  const double gain = kept_.gain > 0 ? kGain : kept_.gain == 0 || was_flat ? kMuchBetter : kTwiceAsGood;
  if (kept_.least <= kept_.least_before * gain) return;
  if (best_.tet_count == 0 || kept_.least > best_.least) best_ = kept_;
}

bool PointInserter::insert(std::uint32_t tet) {
  best_.tet_count = 0;
  const auto v = mesh_.verts(tet);
  const Vec3 center = 0.25 * (mesh_.point(v[0]) + mesh_.point(v[1]) + mesh_.point(v[2]) + mesh_.point(v[3]));
  try_cavity(std::span(&tet, 1), center);
  EdgeRing ring;
  for (int edge = 0; edge < 6; ++edge) {
    const bool is_flat = double{mesh_.quality(tet)} < kNearlyFlatCavity;
    if (is_flat ? !find_any_ring(mesh_, tet, edge, ring) : find_ring(mesh_, tet, edge, ring) != EdgeVerdict::Removed)
      continue;
    try_cavity(ring.old(), 0.5 * (mesh_.point(ring.a) + mesh_.point(ring.b)));
  }
  if (best_.tet_count == 0) return false;
  const std::uint32_t vertex = mesh_.add_point(best_.point);
  std::array<NewTet, WorkingMesh::kMostTets> made;
  for (std::size_t i = 0; i < best_.facet_count; ++i) {
    const auto& [a, b, c] = best_.facets[i].verts;
    made[i] = {{a, b, c, vertex}, cubed_quality(mesh_.point(a), mesh_.point(b), mesh_.point(c), best_.point)};
  }
  mesh_.replace(best_.old(), std::span(made).first(best_.facet_count));
  return true;
}

std::size_t insert_points(WorkingMesh& mesh, double limit, const TaskRunner& runner) {
  PointInserter inserter(mesh, limit);
  std::size_t count = 0;
  for_each_bad_tet(mesh, limit, runner, [&](std::uint32_t tet) { count += inserter.insert(tet); });
  return count;
}

}  // namespace tetloom::tets
