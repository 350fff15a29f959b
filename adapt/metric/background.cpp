#include "adapt/metric/background.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/mix_bits.hpp"
#include "tetloom/assert.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {
namespace {

constexpr std::size_t kGrain = 1 << 12;
constexpr double kInside = -1e-12;         // a weight that counts as 0
constexpr std::size_t kSteepSteps = 64;    // of a walk, before it turns at random
constexpr std::size_t kMostVisited = 256;  // tets of a search around one
constexpr std::size_t kTetsPerCell = 4;

double volume6(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return dot(cross(b - a, c - a), d - a); }

/// Negative weights become 0, and the sum 1.
void clamp(std::array<double, 4>& weights) {
  double sum = 0;
  for (double& w : weights) sum += w = std::max(w, 0.0);
  const bool fine = sum > 0 && std::isfinite(sum);  // a tet without volume says nothing
  for (double& w : weights) w = fine ? w / sum : 0.25;
}

}  // namespace

BackgroundMesh::BackgroundMesh(const TetView& mesh, MetricField metric, const TaskRunner& runner)
    : BackgroundMesh(mesh, link_tets(mesh, runner), std::move(metric), runner) {}

BackgroundMesh::BackgroundMesh(const TetView& mesh, std::vector<std::uint32_t> links, MetricField metric,
                               const TaskRunner& runner)
    : BackgroundMesh(std::vector<Vec3>(mesh.points.begin(), mesh.points.end()),
                     std::vector<TetVerts>(mesh.tets.begin(), mesh.tets.end()), std::move(links), std::move(metric),
                     runner) {}

BackgroundMesh::BackgroundMesh(std::vector<Vec3>&& points, std::vector<TetVerts>&& tets,
                               std::vector<std::uint32_t>&& links, MetricField&& metric, const TaskRunner& runner)
    : points_(std::move(points)), tets_(std::move(tets)), links_(std::move(links)), metric_(std::move(metric)) {
  TETLOOM_ASSERT(!tets_.empty() && (metric_.size() == points_.size() || metric_.size() == 0));
  std::vector<std::uint32_t> open;
  for (std::size_t face = 0; face < links_.size(); ++face)
    if (links_[face] == kNone) open.push_back(static_cast<std::uint32_t>(face));
  boundary_ = BoundaryTree(this->mesh(), std::move(open), runner);
  build_grid();
}

/// Barycentric coordinates: the volumes of the tets that x makes with the faces, over their sum.
BackgroundMesh::Weights BackgroundMesh::weights_in(std::uint32_t tet, const Vec3& x) const {
  const TetVerts& v = tets_[tet];
  const Vec3 a = points_[v[0]] - x, b = points_[v[1]] - x, c = points_[v[2]] - x, d = points_[v[3]] - x;
  const Vec3 ab = cross(a, b), cd = cross(c, d);
  const double wa = dot(b, cd), wb = -dot(a, cd), wc = dot(ab, d), wd = -dot(ab, c);
  const double scale = 1 / volume6(points_[v[0]], points_[v[1]], points_[v[2]], points_[v[3]]);
  return {wa * scale, wb * scale, wc * scale, wd * scale};
}

/// True with the tet that holds x; false, with the last tet, where the walk leaves the mesh or gets nowhere.
bool BackgroundMesh::walk(const Vec3& x, std::uint32_t start, BackgroundPlace& place) const {
  const std::size_t most = 1000 + 16 * static_cast<std::size_t>(std::cbrt(static_cast<double>(tets_.size())));
  std::uint32_t tet = start;
  std::size_t came_through = 4;
  for (std::size_t step = 0; step < most; ++step) {
    place.tet = tet;
    place.weights = weights_in(tet, x);
    // Through the face behind which x lies farthest. Such walks may turn in circles; choosing at random ends that
    // (Devillers, Pion & Teillaud 2002), and the numbers depend on the place alone.
    const bool random = step >= kSteepSteps;
    const std::uint64_t noise = random ? mix_bits(step * 0x9e3779b97f4a7c15u ^ tet) : 0;
    std::size_t leave = 4;
    double steepest = kInside;
    bool outside = false;
    for (std::size_t k = 0; k < 4; ++k) {
      const std::size_t i = random ? (k + noise) & 3 : k;
      if (i == came_through || !(place.weights[i] < steepest)) continue;
      outside = true;
      if (links_[std::size_t{tet} * 4 + i] == kNone) continue;
      leave = i;
      if (random) break;
      steepest = place.weights[i];
    }
    if (leave == 4) return !outside;
    const std::uint32_t next = links_[std::size_t{tet} * 4 + leave];
    tet = next / 4, came_through = next % 4;
  }
  return false;
}

/// Looks at the tets around one, those in which x lies least far outside first.
bool BackgroundMesh::search_around(const Vec3& x, std::uint32_t start, BackgroundPlace& place) const {
  struct Candidate {
    double least;  // weight
    std::uint32_t tet;
    bool operator<(const Candidate& b) const { return least != b.least ? least < b.least : tet > b.tet; }
  };
  const auto candidate = [&](std::uint32_t tet) {
    const Weights w = weights_in(tet, x);
    return Candidate{*std::min_element(w.begin(), w.end()), tet};
  };
  std::vector<Candidate> queue{candidate(start)};
  std::vector<std::uint32_t> seen{start};
  while (!queue.empty()) {
    std::pop_heap(queue.begin(), queue.end());
    const Candidate best = queue.back();
    queue.pop_back();
    if (best.least >= kInside) {
      place = {best.tet, weights_in(best.tet, x)};
      return true;
    }
    if (seen.size() >= kMostVisited) return false;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t link = links_[std::size_t{best.tet} * 4 + i];
      if (link == kNone || std::find(seen.begin(), seen.end(), link / 4) != seen.end()) continue;
      seen.push_back(link / 4);
      queue.push_back(candidate(link / 4));
      std::push_heap(queue.begin(), queue.end());
    }
  }
  return false;
}

BackgroundPlace BackgroundMesh::on_boundary(const BoundaryTree::Nearest& nearest) const {
  BackgroundPlace place{nearest.face / 4, {}};
  for (std::size_t i = 0; i < 3; ++i) place.weights[kFaceVerts[nearest.face % 4][i]] = nearest.point.weights[i];
  return place;
}

/// The segment from x to the nearest point of the boundary meets the boundary nowhere else, so the tet at that point is
/// where to start looking for x, if x is inside at all.
BackgroundPlace BackgroundMesh::locate_from_boundary(const Vec3& x, std::uint32_t last) const {
  const BoundaryTree::Nearest nearest = boundary_.find_nearest(mesh(), x, HUGE_VAL);
  BackgroundPlace place;
  if (nearest.face == kNone) return {last, weights_in(last, x)};  // so far away that squares overflow
  const std::uint32_t tet = nearest.face / 4;
  const auto& p = nearest.point.weights;
  const bool beside = p[0] > 0 && p[1] > 0 && p[2] > 0;  // beside the face, not one of its edges
  if (beside && weights_in(tet, x)[nearest.face % 4] < 0) return on_boundary(nearest);
  if (walk(x, tet, place) || search_around(x, tet, place)) return place;
  return on_boundary(nearest);
}

BackgroundPlace BackgroundMesh::locate(const Vec3& x, std::uint32_t hint) const {
  TETLOOM_DEBUG_ASSERT(is_finite(x) && (hint == kNone || hint < tets_.size()));
  BackgroundPlace place;
  if (!walk(x, hint == kNone ? start_near(x) : hint, place)) place = locate_from_boundary(x, place.tet);
  clamp(place.weights);
  return place;
}

std::vector<BackgroundPlace> BackgroundMesh::locate(std::span<const Vec3> points, const BlockLoop& loop) const {
  std::vector<BackgroundPlace> places(points.size());
  loop.for_blocks(points.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    std::uint32_t hint = kNone;
    for (std::size_t i = begin; i < end; ++i) {
      places[i] = locate(points[i], hint);
      hint = places[i].tet;
    }
  });
  return places;
}

MeshField BackgroundMesh::interpolate(const MeshField& field, std::span<const BackgroundPlace> places,
                                      const BlockLoop& loop) const {
  TETLOOM_ASSERT(field.values.size() == points_.size() * static_cast<std::size_t>(field.components));
  const auto n = static_cast<std::size_t>(field.components);
  MeshField result{field.name, field.components, std::vector<double>(places.size() * n)};
  loop.for_blocks(places.size(), kGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      for (int c = 0; c < field.components; ++c)
        result.values[i * n + static_cast<std::size_t>(c)] = value_at(field, c, places[i]);
  });
  return result;
}

std::size_t BackgroundMesh::cell_of(const Vec3& x) const {
  std::size_t cell = 0;
  for (int axis = 2; axis >= 0; --axis) {
    const std::size_t n = cells_[static_cast<std::size_t>(axis)];
    const double extent = box_.hi[axis] - box_.lo[axis];
    const double at = extent > 0 ? (x[axis] - box_.lo[axis]) / extent * static_cast<double>(n) : 0;
    const double last = static_cast<double>(n - 1);
    cell = cell * n + static_cast<std::size_t>(std::clamp(at, 0.0, last));
  }
  return cell;
}

std::uint32_t BackgroundMesh::start_near(const Vec3& x) const { return cell_to_tet_[cell_of(x)]; }

/// Cells name the first tet whose centre lies in them; cells without one take over that of the cell before or behind.
void BackgroundMesh::build_grid() {
  for (const TetVerts& tet : tets_)
    for (const std::uint32_t v : tet) box_.add(points_[v]);
  const Vec3 extent = box_.hi - box_.lo;
  // Cubic cells, but no more than wanted of them where the box is flat or thin.
  const double wanted = std::max(1.0, static_cast<double>(tets_.size()) / kTetsPerCell);
  double edge = std::max({extent.x, extent.y, extent.z}) / wanted;
  const auto count_along = [&](int axis) { return edge > 0 ? std::max(1.0, std::floor(extent[axis] / edge)) : 1.0; };
  while (count_along(0) * count_along(1) * count_along(2) > wanted) edge *= 1.2;
  for (int axis = 0; axis < 3; ++axis)
    cells_[static_cast<std::size_t>(axis)] = static_cast<std::size_t>(count_along(axis));
  cell_to_tet_.assign(cells_[0] * cells_[1] * cells_[2], kNone);
  for (std::size_t t = 0; t < tets_.size(); ++t) {
    const TetVerts& v = tets_[t];
    const Vec3 center = 0.25 * ((points_[v[0]] + points_[v[1]]) + (points_[v[2]] + points_[v[3]]));
    std::uint32_t& tet = cell_to_tet_[cell_of(center)];
    if (tet == kNone) tet = static_cast<std::uint32_t>(t);
  }
  // Along x, then y, then z, so that the tet is near.
  std::size_t stride = 1;
  for (const std::size_t n : cells_) {
    for (std::size_t i = 0; i < cell_to_tet_.size(); ++i)
      if (cell_to_tet_[i] == kNone && i / stride % n > 0) cell_to_tet_[i] = cell_to_tet_[i - stride];
    for (std::size_t i = cell_to_tet_.size(); i-- > 0;)
      if (cell_to_tet_[i] == kNone && i / stride % n + 1 < n) cell_to_tet_[i] = cell_to_tet_[i + stride];
    stride *= n;
  }
}

}  // namespace tetloom::adapt
