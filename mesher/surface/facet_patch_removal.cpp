// Vertices out of a triangulation, one at a time.
#include <algorithm>
#include <cmath>
#include <utility>

#include "mesher/surface/facet_patch_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kLargestRing = 160;  // filling takes cubic time: tens of milliseconds for so many

}  // namespace

PatchVertexRemover::PatchVertexRemover(Triangulation& mesh, PatchVertices& vertices)
    : mesh_(mesh), vertices_(vertices) {
  for (std::uint32_t v = 0; v < vertices.size(); ++v) {
    if (vertices.node[v] != FacetPatch::kNoNode) node_to_copies_[vertices.node[v]].push_back(v);
  }
}

const PatchCavity& PatchVertexRemover::collect_ball(std::uint32_t v) {
  cavity_.ring.clear(), cavity_.outer.clear(), cavity_.tris.clear();
  const std::uint32_t first = mesh_.outgoing(v);
  std::uint32_t start = first;
  while (mesh_.twin(start) != kNone) {
    start = Triangulation::next(mesh_.twin(start));
    if (start == first) break;
  }
  cavity_.closed = mesh_.twin(start) != kNone;
  for (std::uint32_t h = start;;) {
    cavity_.ring.push_back(mesh_.target(h)), cavity_.tris.push_back(h / 3);
    cavity_.outer.push_back(mesh_.twin(Triangulation::next(h)));
    const std::uint32_t next = mesh_.twin(Triangulation::prev(h));
    if (next == kNone) cavity_.ring.push_back(mesh_.apex(h));
    if (next == kNone || next == start) break;
    h = next;
  }
  return cavity_;
}

bool PatchVertexRemover::remove(std::uint32_t v, double level, Reach reach) {
  collect_ball(v);
  removed_ = v;
  const std::size_t n = cavity_.ring.size();
  if (n == 2 && !cavity_.closed) {  // an ear
    if (cavity_.outer[0] == kNone) return false;
    mesh_.remove_triangle(cavity_.tris[0]);
    return true;
  }
  return n >= 3 && refill(level, reach);
}

bool PatchVertexRemover::reshape(std::uint32_t tri, double level, Reach reach) {
  const auto corners = mesh_.triangle(tri);
  cavity_.ring.assign(corners.begin(), corners.end());
  cavity_.outer = {mesh_.twin(3 * tri), mesh_.twin(3 * tri + 1), mesh_.twin(3 * tri + 2)};
  cavity_.tris = {tri};
  cavity_.closed = true;
  removed_ = kNone;
  return grow() && refill(level, reach);
}

bool PatchVertexRemover::refill(double level, Reach reach) {
  for (int layer = 0;; ++layer) {
    if (cavity_.ring.size() > kLargestRing) return false;
    if (fill_once(level)) return true;
    if (layer >= static_cast<int>(reach) || !grow()) return false;
  }
}

bool PatchVertexRemover::grow() {
  const auto in_ring = [&](std::uint32_t v) {
    return v == removed_ || std::find(cavity_.ring.begin(), cavity_.ring.end(), v) != cavity_.ring.end();
  };
  bool grown = false;
  // Edges appear behind the place looked at, so that one call adds one layer.
  for (std::size_t i = 0; i < cavity_.outer.size() && cavity_.ring.size() <= kLargestRing; ++i) {
    const std::uint32_t half = cavity_.outer[i];
    if (half == kNone || in_ring(mesh_.apex(half))) continue;
    const auto after = static_cast<std::ptrdiff_t>(i + 1);
    cavity_.ring.insert(cavity_.ring.begin() + after, mesh_.apex(half));
    cavity_.outer[i] = mesh_.twin(Triangulation::next(half));
    cavity_.outer.insert(cavity_.outer.begin() + after, mesh_.twin(Triangulation::prev(half)));
    cavity_.tris.push_back(half / 3);
    grown = true, ++i;
  }
  return grown;
}

bool PatchVertexRemover::fill_once(double level) {
  const std::size_t n = cavity_.ring.size();
  if (n == 3 && cavity_.closed && cavity_.outer[0] / 3 == cavity_.outer[1] / 3) return false;  // a tetrahedron
  std::sort(cavity_.tris.begin(), cavity_.tris.end());
  if (!cavity_.closed && connected_outside(cavity_.ring.front(), cavity_.ring.back())) return false;
  if (!plan(level)) return false;
  apply_plan();
  return true;
}

void PatchVertexRemover::apply_plan() {
  const std::size_t n = cavity_.ring.size();
  for (const std::uint32_t tri : cavity_.tris) mesh_.remove_triangle(tri);
  const std::uint32_t base = fill(0, n - 1);
  if (cavity_.closed) mesh_.link(base, cavity_.outer[n - 1]);
}

bool PatchVertexRemover::force(std::uint32_t v) {
  forbidden_.clear();
  removed_ = v;
  while (true) {
    collect_ball(v);
    const std::uint32_t first = cavity_.ring.front(), last = cavity_.ring.back();
    if (!cavity_.closed && cavity_.ring.size() == 2) return remove(v, -1, Reach::Ball);
    if (cavity_.ring.size() < 3 || (!cavity_.closed && first == last)) return false;
    std::sort(cavity_.tris.begin(), cavity_.tris.end());
    if (!plan(-1, Facing::Any)) return false;
    const auto obstacles = find_obstacles();
    if (obstacles.empty()) break;
    // Each round either halves an edge for good or forbids a pair of the ring, so this ends.
    for (const auto& [a, b] : obstacles) {
      const std::uint32_t half = mesh_.find_half_edge(a, b);
      if (half == kNone) continue;  // the ring passes its ends twice, and it is halved
      if (mesh_.twin(half) != kNone) {
        halve_edge(mesh_, vertices_, half);
      } else if (!forbidden_.insert({std::min(a, b), std::max(a, b)}).second) {
        return false;  // the rim that would be left is one already
      }
    }
  }
  apply_plan();
  return true;
}

std::vector<std::array<std::uint32_t, 2>> PatchVertexRemover::find_obstacles() const {
  std::vector<std::array<std::size_t, 2>> planned;
  list_planned(0, cavity_.ring.size() - 1, planned);
  if (!cavity_.closed) planned.push_back({0, cavity_.ring.size() - 1});
  std::vector<std::array<std::uint32_t, 2>> obstacles;
  for (const auto& [i, j] : planned) {
    const std::uint32_t a = cavity_.ring[i], b = cavity_.ring[j];
    if (!connected_outside(a, b)) continue;
    const bool forward = mesh_.find_half_edge(a, b) != kNone;
    obstacles.push_back(forward ? std::array{a, b} : std::array{b, a});
  }
  return obstacles;
}

void PatchVertexRemover::list_planned(std::size_t i, std::size_t j,
                                      std::vector<std::array<std::size_t, 2>>& edges) const {
  std::vector<std::array<std::size_t, 2>> parts{{i, j}};
  while (!parts.empty()) {
    const auto [from, to] = parts.back();
    parts.pop_back();
    const std::size_t m = split_[from * cavity_.ring.size() + to];
    if (m != from + 1) edges.push_back({from, m}), parts.push_back({from, m});
    if (to != m + 1) edges.push_back({m, to}), parts.push_back({m, to});
  }
}

bool PatchVertexRemover::improve(std::uint32_t half, double level, double tolerance) {
  constexpr double kWorthwhile = 1.05;
  if (mesh_.twin(half) == kNone) return false;
  const std::uint32_t a = mesh_.origin(half), b = mesh_.target(half), c = mesh_.apex(half);
  const std::uint32_t d = mesh_.apex(mesh_.twin(half));
  const double now = std::min(score(a, b, c, level), score(b, a, d, level));
  const double then = std::min(score(a, d, c, level), score(b, c, d, level));
  if (!(then > 0 && then > kWorthwhile * now)) return false;
  const auto& points = vertices_.points;
  const Vec3 across = normalized(cross(points[b] - points[a], points[d] - points[c]));
  if (std::abs(dot(across, points[c] - points[a])) > tolerance) return false;
  cavity_.tris.clear();
  if (c == d || !may_join(c, d)) return false;
  mesh_.flip(half);
  return true;
}

double PatchVertexRemover::score(std::uint32_t a, std::uint32_t b, std::uint32_t c, double level) const {
  constexpr double kFlat = 1e-9;
  const Vec3 ab = vertices_.points[b] - vertices_.points[a], ac = vertices_.points[c] - vertices_.points[a];
  const Vec3 n = cross(ab, ac), mean = vertices_.normals[a] + vertices_.normals[b] + vertices_.normals[c];
  const double area = norm(n), quality = 2 * std::sqrt(3.0) * area / (norm2(ab) + norm2(ac) + norm2(ac - ab));
  if (!(quality > kFlat)) return -1;
  return dot(n, mean) >= level * area * norm(mean) ? quality : -1;
}

double PatchVertexRemover::score_any(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
  const Vec3 ab = vertices_.points[b] - vertices_.points[a], ac = vertices_.points[c] - vertices_.points[a];
  const Vec3 n = cross(ab, ac), mean = vertices_.normals[a] + vertices_.normals[b] + vertices_.normals[c];
  const double squares = norm2(ab) + norm2(ac) + norm2(ac - ab);
  return 2 + (squares > 0 ? 2 * std::sqrt(3.0) * dot(n, normalized(mean)) / squares : 0);
}

bool PatchVertexRemover::connected(std::uint32_t a, std::uint32_t b) const {
  return mesh_.find_half_edge(a, b) != kNone || mesh_.find_half_edge(b, a) != kNone;
}

bool PatchVertexRemover::is_outside(std::uint32_t half) const {
  if (half == kNone) return false;
  const auto inside = [&](std::uint32_t h) {
    return h != kNone && std::binary_search(cavity_.tris.begin(), cavity_.tris.end(), h / 3);
  };
  return !inside(half) || !inside(mesh_.twin(half));
}

bool PatchVertexRemover::connected_outside(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t half = mesh_.find_half_edge(a, b);
  return is_outside(half != kNone ? half : mesh_.find_half_edge(b, a));
}

bool PatchVertexRemover::copies_may_join(std::uint32_t a, std::uint32_t b) const {
  const std::uint32_t node_a = vertices_.node[a], node_b = vertices_.node[b];
  if (node_a == FacetPatch::kNoNode || node_b == FacetPatch::kNoNode) return true;
  if (node_a == node_b) return false;
  const auto &copies_a = node_to_copies_.at(node_a), &copies_b = node_to_copies_.at(node_b);
  if (copies_a.size() == 1 && copies_b.size() == 1) return true;
  for (const std::uint32_t i : copies_a) {
    for (const std::uint32_t j : copies_b) {
      if (connected(i, j)) return false;
    }
  }
  return true;
}

bool PatchVertexRemover::may_join(std::uint32_t a, std::uint32_t b) const {
  return !connected_outside(a, b) && copies_may_join(a, b);
}

// Looks once around each vertex of the ring: some have thousands of neighbours.
void PatchVertexRemover::note_edges_of_ring() {
  const std::size_t n = cavity_.ring.size();
  std::vector<std::pair<std::uint32_t, std::size_t>> places(n);
  for (std::size_t i = 0; i < n; ++i) places[i] = {cavity_.ring[i], i};
  std::ranges::sort(places);
  edge_to_.assign(n * n, kNone);
  for (std::size_t i = 0; i < n; ++i)
    mesh_.for_each_outgoing(cavity_.ring[i], [&](std::uint32_t h) {
      const std::uint32_t to = mesh_.target(h);
      auto at = std::ranges::lower_bound(places, std::pair{to, std::size_t{0}});
      for (; at != places.end() && at->first == to; ++at)
        if (std::uint32_t& edge = edge_to_[i * n + at->second]; edge == kNone) edge = h;
      return true;
    });
}

bool PatchVertexRemover::may_join_in_ring(std::size_t i, std::size_t j) const {
  const std::size_t n = cavity_.ring.size();
  const std::uint32_t half = edge_to_[i * n + j] != kNone ? edge_to_[i * n + j] : edge_to_[j * n + i];
  return !is_outside(half) && copies_may_join(cavity_.ring[i], cavity_.ring[j]);
}

bool PatchVertexRemover::plan(double level, Facing facing) {
  if (facing == Facing::Surface) note_edges_of_ring();
  const auto allowed = [&](std::size_t i, std::size_t j) {
    if (facing == Facing::Surface) return may_join_in_ring(i, j);
    const auto [low, high] = std::minmax(cavity_.ring[i], cavity_.ring[j]);
    return !forbidden_.contains({low, high});
  };
  const auto value_of = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    return facing == Facing::Surface ? score(a, b, c, level) : score_any(a, b, c);
  };
  const std::size_t n = cavity_.ring.size();
  best_.assign(n * n, HUGE_VAL), split_.assign(n * n, 0);
  for (std::size_t length = 2; length < n; ++length) {
    for (std::size_t i = 0; i + length < n; ++i) {
      const std::size_t j = i + length;
      best(i, j) = -1;
      const bool base = length == n - 1;
      if (!base && !allowed(i, j)) continue;
      for (std::size_t m = i + 1; m < j; ++m) {
        const double parts = std::min(best(i, m), best(m, j));
        if (parts <= best(i, j)) continue;
        const double value = std::min(parts, value_of(cavity_.ring[i], cavity_.ring[m], cavity_.ring[j]));
        if (value > best(i, j)) best(i, j) = value, split_[i * n + j] = m;
      }
    }
  }
  return best(0, n - 1) > 0;
}

std::uint32_t PatchVertexRemover::fill(std::size_t i, std::size_t j) {
  const std::size_t m = split_[i * cavity_.ring.size() + j];
  const std::uint32_t left = m == i + 1 ? cavity_.outer[i] : fill(i, m);
  const std::uint32_t right = j == m + 1 ? cavity_.outer[m] : fill(m, j);
  const std::uint32_t tri = mesh_.add_triangle(cavity_.ring[i], cavity_.ring[m], cavity_.ring[j]);
  mesh_.link(3 * tri, left), mesh_.link(3 * tri + 1, right);
  return 3 * tri + 2;
}

}  // namespace tetloom::detail
