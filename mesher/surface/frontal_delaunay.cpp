#include "mesher/surface/frontal_delaunay.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <queue>

#include "core/predicates/predicates.hpp"

namespace tetloom {
namespace {

constexpr double kTargetRadius = 0.5773502691896258;  // of the unit equilateral triangle
constexpr double kFinishedRadius = 0.75;              // triangles below need no more points
constexpr double kLeastDistance = 0.62;               // of a new point to its neighbours, in units of the size

/// A symmetric 2×2 matrix; lengths in it are in units of the target size.
struct Metric {
  double uu = 0, uv = 0, vv = 0;

  double dot(const Vec2& a, const Vec2& b) const {
    return uu * a.u * b.u + uv * (a.u * b.v + a.v * b.u) + vv * a.v * b.v;
  }
  double length(const Vec2& a) const { return std::sqrt(std::max(0.0, dot(a, a))); }
  double determinant() const { return uu * vv - uv * uv; }
};

Metric operator+(const Metric& a, const Metric& b) { return {a.uu + b.uu, a.uv + b.uv, a.vv + b.vv}; }
Metric operator*(double s, const Metric& a) { return {s * a.uu, s * a.uv, s * a.vv}; }

Metric metric_of(const PatchVertex& vertex) {
  const double scale = 1 / (vertex.size * vertex.size);
  const auto& [plane, point, du, dv, normal] = vertex.place;
  return scale * Metric{dot(du, du), dot(du, dv), dot(dv, dv)};
}

double circumradius(const Metric& m, const Vec2& a, const Vec2& b, const Vec2& c) {
  const double area2 = cross(b - a, c - a) * std::sqrt(std::max(0.0, m.determinant()));
  const double product = m.length(b - a) * m.length(c - b) * m.length(a - c);
  if (product == 0) return 0;
  return area2 > 1e-12 * product ? product / (2 * area2) : std::numeric_limits<double>::max();
}

class FrontalRefiner {
 public:
  FrontalRefiner(Patch& patch, const PatchSurface& surface, const std::function<bool()>& keep_going,
                 const Coarsening& coarsening)
      : patch_(patch), mesh_(patch.topology), surface_(surface), keep_going_(keep_going), coarsening_(coarsening) {
    metrics_.reserve(patch.vertices.capacity());
    for (const PatchVertex& vertex : patch.vertices) metrics_.push_back(metric_of(vertex));
  }

  void run() {
    stamp_.reserve(2 * patch_.vertices.capacity());
    radius_.reserve(2 * patch_.vertices.capacity());
    mark_.reserve(2 * patch_.vertices.capacity());
    radius_.resize(mesh_.slots());
    stamp_.assign(mesh_.slots(), 0);
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri) radius_[tri] = compute_radius(tri);
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri) push_if_active(tri);
    advance_front();
    insert_circumcenters();
  }

 private:
  struct Entry {
    double radius;
    std::uint32_t tri, stamp;
    bool operator<(const Entry& other) const {
      return radius != other.radius ? radius < other.radius : tri > other.tri;
    }
  };

  const Vec2& plane(std::uint32_t v) const { return patch_.vertices[v].place.plane; }

  double compute_radius(std::uint32_t tri) const {
    const auto [a, b, c] = mesh_.triangle(tri);
    const Metric m = (1.0 / 3) * (metrics_[a] + metrics_[b] + metrics_[c]);
    return circumradius(m, plane(a), plane(b), plane(c));
  }

  bool finished(std::uint32_t tri) const { return radius_[tri] <= kFinishedRadius; }

  bool on_front(std::uint32_t h) const {
    return mesh_.twin(h) == kNone || mesh_.fixed(h) || finished(mesh_.twin(h) / 3);
  }

  void push_if_active(std::uint32_t tri) {
    if (finished(tri)) return;
    if (on_front(3 * tri) || on_front(3 * tri + 1) || on_front(3 * tri + 2))
      queue_.push({radius_[tri], tri, stamp_[tri]});
  }

  void advance_front() {
    while (!queue_.empty() && may_go_on()) {
      const Entry entry = queue_.top();
      queue_.pop();
      if (entry.stamp != stamp_[entry.tri]) continue;
      const std::uint32_t h = choose_edge(entry.tri);
      if (h == kNone) continue;
      if (const auto place = front_point(h)) insert(*place, entry.tri);
    }
  }

  // The shortest edge of the triangle that lies on the front.
  std::uint32_t choose_edge(std::uint32_t tri) const {
    std::uint32_t best = kNone;
    double shortest = std::numeric_limits<double>::max();
    for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
      if (!on_front(h)) continue;
      const std::uint32_t a = mesh_.origin(h), b = mesh_.target(h);
      const double length = (0.5 * (metrics_[a] + metrics_[b])).length(plane(b) - plane(a));
      if (length < shortest) {
        shortest = length;
        best = h;
      }
    }
    return best;
  }

  // Rebay's point, found first with the metric at the edge and then with the metric halfway to it.
  std::optional<PatchPlace> front_point(std::uint32_t h) const {
    const std::uint32_t a = mesh_.origin(h), b = mesh_.target(h);
    Metric m = 0.5 * (metrics_[a] + metrics_[b]);
    PatchPlace place;
    for (int round = 0; round < 2; ++round) {
      const auto candidate = perpendicular_point(h, m);
      if (!candidate) return {};
      place = surface_.at_plane(*candidate);
      if (round == 0) m = (1.0 / 3) * (metrics_[a] + metrics_[b] + metric_of({place, size_between(a, b), kNone}));
    }
    return place;
  }

  double size_between(std::uint32_t a, std::uint32_t b) const {
    return 0.5 * (patch_.vertices[a].size + patch_.vertices[b].size);
  }

  std::optional<Vec2> perpendicular_point(std::uint32_t h, const Metric& m) const {
    const Vec2 a = plane(mesh_.origin(h)), b = plane(mesh_.target(h)), c = plane(mesh_.apex(h));
    const double root = std::sqrt(std::max(0.0, m.determinant()));
    const Vec2 edge = b - a;
    const double length = m.length(edge);
    if (!(root > 0) || !(length > 0)) return {};
    // M⁻¹ · (edge turned by 90°) · √det M is perpendicular to the edge in the metric and as long as the edge.
    const Vec2 turned{-(m.uv * edge.u + m.vv * edge.v) / root, (m.uu * edge.u + m.uv * edge.v) / root};
    const double half = 0.5 * length;
    const Vec2 to_apex = c - 0.5 * (a + b);
    const double height = m.dot(to_apex, turned) / length;
    // Distance of the circumcentre from the edge's midpoint, towards the apex.
    const double q = (m.dot(to_apex, to_apex) - half * half) / (2 * height);
    if (!(height > 0) || !(q > 0)) return {};
    const double target = std::max(half, std::min(std::max(kTargetRadius, half), (half * half + q * q) / (2 * q)));
    const double distance = target + std::sqrt(std::max(0.0, target * target - half * half));
    return 0.5 * (a + b) + (distance / length) * turned;
  }

  // The triangle that contains p, walking from `start` without crossing fixed edges.
  std::uint32_t locate(const Vec2& p, std::uint32_t start) const {
    std::uint32_t tri = start;
    for (int steps = 0; steps < 400; ++steps) {
      std::uint32_t exit = kNone;
      for (std::uint32_t i = 0; i < 3; ++i) {
        const std::uint32_t h = 3 * tri + (i + static_cast<std::uint32_t>(steps)) % 3;
        if (orient2d(plane(mesh_.origin(h)), plane(mesh_.target(h)), p) < 0) {
          exit = h;
          break;
        }
      }
      if (exit == kNone) return tri;
      if (mesh_.twin(exit) == kNone || mesh_.fixed(exit)) return kNone;
      tri = mesh_.twin(exit) / 3;
    }
    return kNone;
  }

  bool insert(const PatchPlace& place, std::uint32_t start) {
    const std::uint32_t tri = locate(place.plane, start);
    if (tri == kNone) return false;
    const PatchVertex vertex{place, size_for(place.point, tri), kNone};
    const Metric m = metric_of(vertex);
    if (!collect_cavity(place.plane, m, tri) || too_close(place.plane, m)) return false;
    const std::uint32_t v = mesh_.add_vertex();
    patch_.vertices.push_back(vertex);
    metrics_.push_back(m);
    mesh_.fill_cavity(v, cavity_, created_);
    update_after_insertion();
    return true;
  }

  double size_for(const Vec3& x, std::uint32_t tri) const {
    double size = coarsening_.factor * surface_.size_at(x);
    if (coarsening_.factor == 1) return size;
    for (const std::uint32_t v : mesh_.triangle(tri)) {
      const PatchVertex& corner = patch_.vertices[v];
      size = std::min(size, corner.size + coarsening_.growth * distance(x, corner.place.point));
    }
    return size;
  }

  // Delaunay cavity in the metric at the point, reduced until the point sees its whole rim.
  bool collect_cavity(const Vec2& p, const Metric& m, std::uint32_t start) {
    mark_.resize(mesh_.slots(), 0);
    cavity_.assign(1, start);
    mark_[start] = 1;
    for (std::size_t k = 0; k < cavity_.size(); ++k) {
      for (std::uint32_t h = 3 * cavity_[k]; h < 3 * cavity_[k] + 3; ++h) {
        const std::uint32_t g = mesh_.twin(h);
        if (g == kNone || mesh_.fixed(h) || mark_[g / 3] || !in_circle(g / 3, p, m)) continue;
        mark_[g / 3] = 1;
        cavity_.push_back(g / 3);
      }
    }
    const bool visible = make_star_shaped(p, start);
    for (const std::uint32_t tri : cavity_) mark_[tri] = 0;
    return visible;
  }

  bool in_circle(std::uint32_t tri, const Vec2& p, const Metric& m) const {
    const auto [ia, ib, ic] = mesh_.triangle(tri);
    const Vec2 a = plane(ia) - p, b = plane(ib) - p, c = plane(ic) - p;
    const double la = m.dot(a, a), lb = m.dot(b, b), lc = m.dot(c, c);
    return la * cross(b, c) + lb * cross(c, a) + lc * cross(a, b) > 0;
  }

  // Removes triangles behind rim edges that the point does not see, then what is no longer connected to `start`.
  bool make_star_shaped(const Vec2& p, std::uint32_t start) {
    for (bool changed = true; changed;) {
      changed = false;
      for (std::size_t k = 0; k < cavity_.size(); ++k) {
        const std::uint32_t tri = cavity_[k];
        if (sees_rim(p, tri)) continue;
        if (tri == start) {
          for (const std::uint32_t other : cavity_) mark_[other] = 0;
          return false;
        }
        mark_[tri] = 0;
        cavity_[k] = cavity_.back();
        cavity_.pop_back();
        --k;
        changed = true;
      }
    }
    return keep_connected(start);
  }

  bool sees_rim(const Vec2& p, std::uint32_t tri) const {
    for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
      const std::uint32_t g = mesh_.twin(h);
      const bool rim = g == kNone || mesh_.fixed(h) || !mark_[g / 3];
      if (rim && orient2d(plane(mesh_.origin(h)), plane(mesh_.target(h)), p) <= 0) return false;
    }
    return true;
  }

  bool keep_connected(std::uint32_t start) {
    // Mark 2: reached from the start. A cavity cut in two keeps the reached part only.
    std::vector<std::uint32_t>& reached = created_;
    reached.assign(1, start);
    mark_[start] = 2;
    for (std::size_t k = 0; k < reached.size(); ++k)
      for (std::uint32_t h = 3 * reached[k]; h < 3 * reached[k] + 3; ++h) {
        const std::uint32_t g = mesh_.twin(h);
        if (g == kNone || mesh_.fixed(h) || mark_[g / 3] != 1) continue;
        mark_[g / 3] = 2;
        reached.push_back(g / 3);
      }
    const bool whole = reached.size() == cavity_.size();
    for (const std::uint32_t tri : cavity_) mark_[tri] = 0;
    cavity_.swap(reached);
    return whole && simply_connected();
  }

  // A cavity of k triangles without inner vertices has k + 2 rim edges and as many rim vertices, each once.
  bool simply_connected() {
    std::size_t rim = 0;
    for (const std::uint32_t tri : cavity_) mark_[tri] = 1;
    for (const std::uint32_t tri : cavity_)
      for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
        const std::uint32_t g = mesh_.twin(h);
        if (g == kNone || mesh_.fixed(h) || !mark_[g / 3]) ++rim;
      }
    for (const std::uint32_t tri : cavity_) mark_[tri] = 0;
    return rim == cavity_.size() + 2;
  }

  bool too_close(const Vec2& p, const Metric& m) const {
    for (const std::uint32_t tri : cavity_)
      for (const std::uint32_t v : mesh_.triangle(tri))
        if ((0.5 * (m + metrics_[v])).length(plane(v) - p) < kLeastDistance) return true;
    return false;
  }

  void update_after_insertion() {
    radius_.resize(mesh_.slots(), 0);
    stamp_.resize(mesh_.slots(), 0);
    for (const std::uint32_t tri : created_) {
      radius_[tri] = compute_radius(tri);
      ++stamp_[tri];
    }
    for (const std::uint32_t tri : created_) {
      push_if_active(tri);
      const std::uint32_t outer = mesh_.twin(3 * tri);
      if (outer != kNone && finished(tri)) push_if_active(outer / 3);
    }
  }

  // What the front could not reach: circumcentres of the triangles that are still too large, largest first.
  void insert_circumcenters() {
    queue_ = {};
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri)
      if (!finished(tri)) queue_.push({radius_[tri], tri, stamp_[tri]});
    while (!queue_.empty() && may_go_on()) {
      const Entry entry = queue_.top();
      queue_.pop();
      if (entry.stamp != stamp_[entry.tri]) continue;
      const auto center = circumcenter(entry.tri);
      if (!center || !insert(surface_.at_plane(*center), entry.tri)) continue;
      for (const std::uint32_t tri : created_)
        if (!finished(tri)) queue_.push({radius_[tri], tri, stamp_[tri]});
    }
  }

  std::optional<Vec2> circumcenter(std::uint32_t tri) const {
    const auto [ia, ib, ic] = mesh_.triangle(tri);
    const Metric m = (1.0 / 3) * (metrics_[ia] + metrics_[ib] + metrics_[ic]);
    const Vec2 b = plane(ib) - plane(ia), c = plane(ic) - plane(ia);
    // M·b · x = |b|²/2 and M·c · x = |c|²/2
    const Vec2 mb{m.uu * b.u + m.uv * b.v, m.uv * b.u + m.vv * b.v};
    const Vec2 mc{m.uu * c.u + m.uv * c.v, m.uv * c.u + m.vv * c.v};
    const double determinant = cross(mb, mc);
    if (!(determinant > 0)) return {};
    const double rb = 0.5 * m.dot(b, b), rc = 0.5 * m.dot(c, c);
    return plane(ia) + Vec2{(rb * mc.v - rc * mb.v) / determinant, (rc * mb.u - rb * mc.u) / determinant};
  }

  bool may_go_on() {
    if (++steps_ % 4096 == 0 && !keep_going_()) stopped_ = true;
    return !stopped_;
  }

  Patch& patch_;
  Triangulation& mesh_;
  const PatchSurface& surface_;
  const std::function<bool()>& keep_going_;
  Coarsening coarsening_;
  std::vector<Metric> metrics_;       // per vertex
  std::vector<double> radius_;        // per triangle slot, in units of the target size
  std::vector<std::uint32_t> stamp_;  // per triangle slot, counts its reuses
  std::vector<std::uint8_t> mark_;    // per triangle slot, scratch
  std::vector<std::uint32_t> cavity_, created_;
  std::priority_queue<Entry> queue_;
  std::uint64_t steps_ = 0;
  bool stopped_ = false;
};

}  // namespace

void refine_frontal(Patch& patch, const PatchSurface& surface, const std::function<bool()>& keep_going,
                    const Coarsening& coarsening) {
  FrontalRefiner(patch, surface, keep_going, coarsening).run();
}

}  // namespace tetloom
