#include "core/spatial/constrained_delaunay.hpp"

#include <algorithm>
#include <deque>
#include <optional>
#include <unordered_map>

#include "core/predicates/predicates.hpp"
#include "tetloom/ids.hpp"

namespace tetloom {
namespace {

class PolygonTriangulator {
 public:
  PolygonTriangulator(std::span<const Vec2> points, std::span<const std::array<std::uint32_t, 2>> segments)
      : points_(points.begin(), points.end()), segments_(segments), given_(static_cast<std::uint32_t>(points.size())) {}

  PolygonTriangulation run() {
    for (std::uint32_t i = 0; i < given_; ++i) mesh_.add_vertex();
    add_frame();
    if (!insert_points() || !recover_segments()) return std::move(result_);
    restore_delaunay();
    if (!remove_outside()) return std::move(result_);
    result_.triangulation = std::move(mesh_);
    return std::move(result_);
  }

 private:
  bool fail(PolygonVerdict verdict, std::uint32_t first = 0, std::uint32_t second = 0) {
    result_.verdict = verdict;
    result_.first = first;
    result_.second = second;
    return false;
  }

  // Two triangles over a square well outside all points.
  void add_frame() {
    Vec2 lo = points_.empty() ? Vec2{} : points_[0], hi = lo;
    for (const Vec2& p : points_) {
      lo = {std::min(lo.u, p.u), std::min(lo.v, p.v)};
      hi = {std::max(hi.u, p.u), std::max(hi.v, p.v)};
    }
    const double reach = 10 * std::max({hi.u - lo.u, hi.v - lo.v, 1e-300});
    const Vec2 center = 0.5 * (lo + hi);
    for (const Vec2 corner : {Vec2{-1, -1}, Vec2{1, -1}, Vec2{1, 1}, Vec2{-1, 1}}) {
      points_.push_back(center + reach * corner);
      mesh_.add_vertex();
    }
    const std::uint32_t first = mesh_.add_triangle(given_, given_ + 1, given_ + 2);
    const std::uint32_t second = mesh_.add_triangle(given_, given_ + 2, given_ + 3);
    mesh_.link(3 * first + 2, 3 * second);
  }

  int side(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return orient2d(points_[a], points_[b], points_[c]);
  }

  // The triangle that contains p; in a Delaunay triangulation the visibility walk ends.
  std::uint32_t locate(std::uint32_t p, std::uint32_t start) const {
    std::uint32_t tri = start;
    for (std::uint32_t i = 0; i < 3;) {
      const std::uint32_t h = 3 * tri + i;
      if (side(mesh_.origin(h), mesh_.target(h), p) < 0 && mesh_.twin(h) != kNone) {
        tri = mesh_.twin(h) / 3;
        i = 0;
      } else {
        ++i;
      }
    }
    return tri;
  }

  bool in_circle(std::uint32_t tri, std::uint32_t p) const {
    const auto [a, b, c] = mesh_.triangle(tri);
    return incircle(points_[a], points_[b], points_[c], points_[p]) > 0;
  }

  bool insert_points() {
    std::uint32_t hint = 0;
    std::vector<std::uint32_t> cavity, created;
    for (std::uint32_t p = 0; p < given_; ++p) {
      const std::uint32_t tri = locate(p, hint);
      for (const std::uint32_t v : mesh_.triangle(tri))
        if (points_[v] == points_[p]) return fail(PolygonVerdict::DuplicatePoint, v, p);
      collect_cavity(tri, p, cavity);
      mesh_.fill_cavity(p, cavity, created);
      hint = created.front();
    }
    return true;
  }

  void collect_cavity(std::uint32_t start, std::uint32_t p, std::vector<std::uint32_t>& cavity) {
    in_cavity_.resize(mesh_.slots(), 0);
    cavity.assign(1, start);
    in_cavity_[start] = 1;
    for (std::size_t k = 0; k < cavity.size(); ++k) {
      for (std::uint32_t h = 3 * cavity[k]; h < 3 * cavity[k] + 3; ++h) {
        const std::uint32_t g = mesh_.twin(h);
        if (g == kNone || in_cavity_[g / 3]) continue;
        // A point on the rim of the cavity would give a flat triangle: the neighbour behind it belongs to the cavity.
        if (in_circle(g / 3, p) || side(mesh_.origin(h), mesh_.target(h), p) <= 0) {
          in_cavity_[g / 3] = 1;
          cavity.push_back(g / 3);
        }
      }
    }
    for (const std::uint32_t tri : cavity) in_cavity_[tri] = 0;
  }

  bool recover_segments() {
    for (std::uint32_t s = 0; s < segments_.size(); ++s) {
      const auto [a, b] = segments_[s];
      if (a == b) return fail(PolygonVerdict::DuplicatePoint, a, b);
      if (mesh_.find_half_edge(a, b) == kNone && !recover(s)) return false;
      const std::uint32_t h = mesh_.find_half_edge(a, b);
      mesh_.fix(h, static_cast<std::uint8_t>(mesh_.fixed(h) + 1));
      segment_at_.try_emplace(key(a, b), s);
    }
    return true;
  }

  static std::uint64_t key(std::uint32_t a, std::uint32_t b) {
    return (std::uint64_t{std::min(a, b)} << 32) | std::max(a, b);
  }

  // The edges that the segment s crosses, or a failure.
  bool collect_crossed(std::uint32_t s, std::deque<std::array<std::uint32_t, 2>>& crossed) {
    const auto [a, b] = segments_[s];
    std::uint32_t h = kNone;
    bool blocked = false;
    mesh_.for_each_outgoing(a, [&](std::uint32_t out) {
      const int left = side(a, b, mesh_.apex(out)), right = side(a, b, mesh_.target(out));
      if (right == 0 && dot(points_[mesh_.target(out)] - points_[a], points_[b] - points_[a]) > 0) {
        blocked = true;
        fail(PolygonVerdict::PointOnSegment, s, mesh_.target(out));
      } else if (right < 0 && left > 0) {
        h = Triangulation::next(out);
      }
      return !blocked;
    });
    if (blocked) return false;
    if (h == kNone) return fail(PolygonVerdict::NotClosed, s, s);
    while (true) {
      const std::uint32_t from = mesh_.origin(h), to = mesh_.target(h);
      if (mesh_.fixed(h)) return fail(PolygonVerdict::SegmentsCross, s, segment_at_.at(key(from, to)));
      crossed.push_back({from, to});
      const std::uint32_t g = mesh_.twin(h);
      const std::uint32_t opposite = mesh_.apex(g);
      if (opposite == b) return true;
      const int where = side(a, b, opposite);
      if (where == 0) return fail(PolygonVerdict::PointOnSegment, s, opposite);
      h = where > 0 ? Triangulation::next(g) : Triangulation::prev(g);
    }
  }

  bool recover(std::uint32_t s) {
    std::deque<std::array<std::uint32_t, 2>> crossed;
    if (!collect_crossed(s, crossed)) return false;
    const auto [a, b] = segments_[s];
    while (!crossed.empty()) {
      const auto [from, to] = crossed.front();
      crossed.pop_front();
      const std::uint32_t h = mesh_.find_half_edge(from, to);
      const std::uint32_t c = mesh_.apex(h), d = mesh_.apex(mesh_.twin(h));
      const bool convex = side(c, d, to) > 0 && side(d, c, from) > 0;
      if (!convex) {
        crossed.push_back({from, to});
        continue;
      }
      mesh_.flip(h);
      const bool touches = c == a || c == b || d == a || d == b;
      if (!touches && side(a, b, c) * side(a, b, d) < 0) crossed.push_back({c, d});
    }
    return true;
  }

  void restore_delaunay() {
    std::vector<std::uint32_t> queue;
    for (std::uint32_t h = 0; h < mesh_.half_edges(); ++h)
      if (mesh_.twin(h) != kNone && h < mesh_.twin(h)) queue.push_back(h);
    while (!queue.empty()) {
      const std::uint32_t h = queue.back();
      queue.pop_back();
      const std::uint32_t g = mesh_.twin(h);
      if (g == kNone || mesh_.fixed(h) || !in_circle(h / 3, mesh_.apex(g))) continue;
      const std::uint32_t t = h / 3, s = g / 3;
      mesh_.flip(h);
      for (const std::uint32_t k : {3 * t, 3 * t + 2, 3 * s, 3 * s + 2}) queue.push_back(k);
    }
  }

  bool remove_outside() {
    std::vector<std::int8_t> parity(mesh_.slots(), -1);
    std::vector<std::uint32_t> stack{mesh_.outgoing(given_) / 3};
    parity[stack[0]] = 0;
    while (!stack.empty()) {
      const std::uint32_t tri = stack.back();
      stack.pop_back();
      for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
        if (mesh_.twin(h) == kNone) continue;
        const std::uint32_t other = mesh_.twin(h) / 3;
        const auto expected = static_cast<std::int8_t>(parity[tri] ^ (mesh_.fixed(h) & 1));
        if (parity[other] < 0) {
          parity[other] = expected;
          stack.push_back(other);
        } else if (parity[other] != expected) {
          return fail(PolygonVerdict::NotClosed);
        }
      }
    }
    bool anything = false;
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri) {
      if (!mesh_.alive(tri)) continue;
      if (parity[tri] == 1)
        anything = true;
      else
        mesh_.remove_triangle(tri);
    }
    mesh_.compact();
    mesh_.truncate_vertices(given_);
    return anything || fail(PolygonVerdict::NotClosed);
  }

  std::vector<Vec2> points_;
  std::span<const std::array<std::uint32_t, 2>> segments_;
  std::uint32_t given_;
  Triangulation mesh_;
  PolygonTriangulation result_;
  std::vector<std::uint8_t> in_cavity_;
  std::unordered_map<std::uint64_t, std::uint32_t> segment_at_;  // looked up only, never iterated
};

}  // namespace

PolygonTriangulation triangulate_polygon(std::span<const Vec2> points,
                                         std::span<const std::array<std::uint32_t, 2>> segments) {
  return PolygonTriangulator(points, segments).run();
}

}  // namespace tetloom
