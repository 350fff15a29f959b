#include "mesher/second_order/patch_mender.hpp"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include "core/tets/newton_step.hpp"
#include "core/tets/ring_in_space.hpp"
#include "core/tets/ring_triangulation.hpp"
#include "core/tets/triangle_verts.hpp"
#include "mesher/tets/edge_removal.hpp"

namespace tetloom::second_order {
namespace {

using tets::EdgeRing;
using tets::FaceCode;
using tets::NewTet;
using tets::TetMesh;

constexpr std::size_t kMostGrowth = 8;  // tets that join a cavity after its start
constexpr int kSteps = 4;               // of Newton's method, for one cavity

// Faces are listed counter-clockwise from outside; turned, they are seen from inside.
std::array<std::uint32_t, 3> inward_face(const TetMesh& mesh, FaceCode face) {
  const auto [a, b, c] = tets::verts_of(mesh, face);
  return {a, c, b};
}

// Qualities of tets over a ring, 0 for those that are not good.
class GoodInSpace {
 public:
  GoodInSpace(const tets::WorkingMesh& mesh, const EdgeRing& ring, const CurvedJudge& judge, double floor)
      : space_(mesh, ring), ring_(ring), judge_(judge), floor_(floor) {}

  double worse_over(int i, int j, int k) const {
    const double quality = space_.worse_over(i, j, k);
    if (!(quality > floor_)) return 0;
    for (const auto& verts : tets_over(ring_, triangle(i, j, k)))
      if (!judge_.is_good(verts)) return 0;
    return quality;
  }

  std::array<NewTet, 2> tets(const tets::RingTriangle& triangle) const { return space_.tets(triangle); }

 private:
  static tets::RingTriangle triangle(int i, int j, int k) {
    return {static_cast<std::uint8_t>(i), static_cast<std::uint8_t>(j), static_cast<std::uint8_t>(k)};
  }

  tets::RingInSpace space_;
  const EdgeRing& ring_;
  const CurvedJudge& judge_;
  double floor_;
};

}  // namespace

CurvedJudge::Verts PatchMender::verts_of(std::uint32_t tet) const {
  CurvedJudge::Verts verts;
  std::ranges::copy(mesh_.verts(tet), verts.begin());
  return verts;
}

bool PatchMender::mend(std::uint32_t tet) {
  best_ = {};
  best_.value = floor_;
  EdgeRing ring;
  for (int edge = 0; edge < 6; ++edge) {
    if (!find_any_ring(mesh_, tet, edge, ring)) continue;
    try_removal(ring);
    try_cavity(ring.old());
  }
  try_cavity(std::array{tet});
  if (best_.made.empty()) return false;
  apply();
  return true;
}

void PatchMender::try_removal(const EdgeRing& ring) {
  const GoodInSpace qualities(mesh_, ring, judge_, best_.value);
  tets::RingTriangulation triangulation(qualities, ring.count);
  const double value = triangulation.maximize(best_.value);
  if (!(value > best_.value)) return;
  Change change;
  change.value = value;
  change.old.assign(ring.old().begin(), ring.old().end());
  const tets::RingTriangles triangles = triangulation.triangles();
  for (const tets::RingTriangle& triangle : triangles.list())
    for (const NewTet& made : qualities.tets(triangle)) change.made.push_back(made);
  best_ = std::move(change);
}

// The point starts where the Jacobians around it are largest, and goes on towards the best mean ratio. As long as the
// worst tet gets better, the one behind its facet joins the cavity.
void PatchMender::try_cavity(std::span<const std::uint32_t> tets) {
  cavity_.tets.clear(), cavity_.facets.clear();
  if (!std::ranges::all_of(tets, [&](std::uint32_t tet) { return add_tet(tet); })) return;
  Vec3 point = middle();
  if (!go_deep(point)) return;
  Change kept = lead(point);
  if (kept.made.empty()) return;
  for (std::size_t i = 0; i < kMostGrowth; ++i) {
    const FaceCode behind = cavity_.facets[worst_facet(kept)].behind;
    if (!behind.valid() || !add_tet(behind.tet())) break;
    Change grown = lead(kept.point);
    if (!(grown.value > kept.value)) break;
    kept = std::move(grown);
  }
  keep_better(std::move(kept));
}

// False when there is no room for the tet, or it is there already.
bool PatchMender::add_tet(std::uint32_t tet) {
  const TetMesh& m = mesh_.mesh();
  auto& [tets, facets] = cavity_;
  if (facets.size() + 3 > tets::WorkingMesh::kMostTets || std::ranges::count(tets, tet) > 0) return false;
  for (std::uint32_t i = 0; i < 4; ++i) {
    const FaceCode face(tet, i), behind = m.is_fixed(face) ? FaceCode() : m.behind(face);
    if (!behind.valid() || std::ranges::count(tets, behind.tet()) == 0) {
      facets.push_back({inward_face(m, face), behind});
      continue;
    }
    const auto at = std::ranges::find(facets, face, &Facet::behind);
    *at = facets.back();
    facets.pop_back();
  }
  tets.push_back(tet);
  return true;
}

Vec3 PatchMender::middle() const {
  Vec3 sum{};
  for (const Facet& facet : cavity_.facets)
    for (const std::uint32_t v : facet.verts) sum += mesh_.point(v);
  return (1.0 / (3.0 * static_cast<double>(cavity_.facets.size()))) * sum;
}

// To where the least determinant over the area of its facet is largest; false where none is positive all over. The
// edges at the point are straight, so all coefficients are affine in its place.
bool PatchMender::go_deep(Vec3& point) {
  const std::uint32_t some = cavity_.facets.front().verts[0];
  const double step = distance(mesh_.point(some), point);
  if (!(step > 0)) return false;
  functions_.clear();
  for (const Facet& facet : cavity_.facets) add_functions(facet, point, step);
  const std::optional<tets::DeepPoint> deep = tets::maximize_least(functions_);
  if (!deep || !(deep->depth > 0) || !is_finite(deep->point)) return false;
  point += deep->point;
  return true;
}

void PatchMender::add_functions(const Facet& facet, const Vec3& point, double step) {
  const auto& [a, b, c] = facet.verts;
  const double area = norm(cross(mesh_.point(b) - mesh_.point(a), mesh_.point(c) - mesh_.point(a)));
  const auto at = [&](const Vec3& place) {
    mesh_.mesh().points[probe_] = place;
    return tet_determinant(judge_.nodes_of({a, b, c, probe_}));
  };
  const TetJacobian base = at(point);
  std::array<TetJacobian, 3> moved;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 place = point;
    place[axis] += step;
    moved[static_cast<std::size_t>(axis)] = at(place);
  }
  const double unit = 1 / (area * step);
  for (std::size_t i = 0; i < base.size(); ++i) {
    const Vec3 slope{moved[0][i] - base[i], moved[1][i] - base[i], moved[2][i] - base[i]};
    functions_.push_back({unit * slope, base[i] / area});
  }
}

// The best of the places on the way.
PatchMender::Change PatchMender::lead(Vec3 point) {
  Change best = fan_at(point);
  for (int i = 0; i < kSteps; ++i) {
    const Vec3 step = step_at(point);
    if (step == Vec3{}) break;
    point += step;
    if (Change change = fan_at(point); change.value > best.value) best = std::move(change);
  }
  return best;
}

// Nothing is made where a tet would be poor or not good.
PatchMender::Change PatchMender::fan_at(const Vec3& point) {
  mesh_.mesh().points[probe_] = point;
  Change change;
  change.point = point, change.has_point = true, change.value = 1;
  for (const auto& [verts, behind] : cavity_.facets) {
    const auto& [a, b, c] = verts;
    const double quality =
        tets::cubed_quality(mesh_.point(a) - point, mesh_.point(b) - point, mesh_.point(c) - point, {});
    if (!(quality > floor_) || !judge_.is_good({a, b, c, probe_})) return {};
    change.made.push_back({{a, b, c, probe_}, quality});
    change.value = std::min(change.value, quality);
  }
  change.old = cavity_.tets;
  return change;
}

Vec3 PatchMender::step_at(const Vec3& point) {
  star_.clear();
  for (const auto& [verts, behind] : cavity_.facets)
    star_.push_back(
        tets::star_tet(mesh_.point(verts[0]) - point, mesh_.point(verts[1]) - point, mesh_.point(verts[2]) - point));
  if (!std::ranges::all_of(star_, [](const tets::StarTet& tet) { return tet.is_surely_positive_at({}); })) return {};
  return find_newton_step(star_, point, tets::kSurelyPositive);
}

// Tets are made in the order of the facets.
std::size_t PatchMender::worst_facet(const Change& change) const {
  return static_cast<std::size_t>(std::ranges::min_element(change.made, {}, &NewTet::quality) - change.made.begin());
}

void PatchMender::keep_better(Change&& change) {
  if (change.value > best_.value) best_ = std::move(change);
}

void PatchMender::apply() {
  if (best_.has_point) {
    mesh_.mesh().points[probe_] = best_.point;
    probe_ = mesh_.add_point({});
  }
  for (const NewTet& made : best_.made) std::ranges::copy(made.verts, std::back_inserter(made_verts_));
  mesh_.replace(best_.old, best_.made);
}

void PatchMender::smooth() {
  constexpr int kPasses = 2;
  std::ranges::sort(made_verts_);
  for (int pass = 0; pass < kPasses; ++pass) {
    std::vector<bool> is_left(mesh_.mesh().points.size());
    for (const std::uint32_t v : made_verts_) is_left[v] = true;
    for (std::uint32_t tet = 0; tet < mesh_.mesh().size(); ++tet) {
      if (is_dead(tet)) continue;
      for (std::uint32_t corner = 0; corner < 4; ++corner) {
        const std::uint32_t v = mesh_.verts(tet)[corner];
        if (is_left[v]) smooth(tet, corner);
        is_left[v] = false;
      }
    }
  }
}

bool PatchMender::smooth(std::uint32_t tet, std::uint32_t corner) {
  tets::VertexStar star;
  if (find_star(mesh_, tet, corner, star) != tets::StarVerdict::Found) return false;
  const Vec3 here = mesh_.point(star.vertex);
  star_.clear();
  for (const FaceCode code : star.tets()) {
    const auto [a, b, c] = inward_face(mesh_.mesh(), code);
    star_.push_back(tets::star_tet(mesh_.point(a) - here, mesh_.point(b) - here, mesh_.point(c) - here));
  }
  const Vec3 step = find_newton_step(star_, here, floor_);
  if (step == Vec3{}) return false;
  mesh_.mesh().points[star.vertex] = here + step;
  if (!std::ranges::all_of(star.tets(), [&](FaceCode code) { return is_good(code.tet()); })) {
    mesh_.mesh().points[star.vertex] = here;
    return false;
  }
  for (const FaceCode code : star.tets()) {
    const auto [a, b, c, d] = verts_of(code.tet());
    mesh_.set_quality(code.tet(), tets::cubed_quality(mesh_.point(a), mesh_.point(b), mesh_.point(c), mesh_.point(d)));
  }
  return true;
}

}  // namespace tetloom::second_order
