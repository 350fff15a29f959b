#include "mesher/surface/patch_optimizer.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

namespace tetloom {
namespace {

constexpr double kLongest = 1.42, kShortest = 0.68;  // edge lengths kept, in units of the size
constexpr double kLargestBend = 1.5;                 // of a flipped edge: length along the surface / through space
constexpr double kGoodEnough = 0.985;                // balls whose worst triangle is better are left alone

double distance_of_lines(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 across = cross(b - a, d - c);
  const double length = norm(across);
  return length > 0 ? std::abs(dot(across, c - a)) / length : 0;
}

class PatchOptimizer {
 public:
  PatchOptimizer(Patch& patch, const PatchSurface& surface, const std::function<bool()>& keep_going)
      : patch_(patch), mesh_(patch.topology), surface_(surface), keep_going_(keep_going) {}

  void run(const PatchOptimizerOptions& options) {
    to_smooth_.assign(mesh_.vertex_count(), 1);
    to_flip_.assign(mesh_.vertex_count(), 1);
    if (options.adapt_density) adapt_density();
    flip_all();
    for (int round = 0; round < options.rounds && keep_going_(); ++round) {
      smooth_all();
      flip_all();
      if (round == 0) {
        fit_lengths();
        flip_all();
        smooth_all();
        flip_all();
      }
    }
    remove_low_valence();
    smooth_all();
    flip_all();
    smooth_all();
  }

 private:
  const PatchPlace& place(std::uint32_t v) const { return patch_.vertices[v].place; }
  bool movable(std::uint32_t v) const { return patch_.vertices[v].node == kNone; }

  // Two corners at one pole: the triangle has no area and is dropped when the patch is done.
  bool collapsed(std::uint32_t tri) const {
    if (!patch_.has_poles) return false;
    const auto [a, b, c] = mesh_.triangle(tri);
    const std::uint32_t na = patch_.vertices[a].node, nb = patch_.vertices[b].node, nc = patch_.vertices[c].node;
    return (na != kNone && (na == nb || na == nc)) || (nb != kNone && nb == nc);
  }

  double quality(std::uint32_t tri) const {
    const auto [a, b, c] = mesh_.triangle(tri);
    return signed_quality(place(a), place(b), place(c));
  }

  double relative_length(std::uint32_t a, std::uint32_t b) const {
    return 2 * surface_.edge_length(place(a), place(b)) / (patch_.vertices[a].size + patch_.vertices[b].size);
  }

  // ---- flips -------------------------------------------------------------------------------------------------------
  bool flip_improves(std::uint32_t h) const {
    const std::uint32_t g = mesh_.twin(h);
    if (g == kNone || mesh_.fixed(h) || collapsed(h / 3) || collapsed(g / 3)) return false;
    const PatchPlace &a = place(mesh_.origin(h)), &b = place(mesh_.target(h));
    const PatchPlace &c = place(mesh_.apex(h)), &d = place(mesh_.apex(g));
    const double before = std::min(signed_quality(a, b, c), signed_quality(b, a, d));
    const double after = std::min(signed_quality(a, d, c), signed_quality(b, c, d));
    // A share of the quality among slivers, whose chains of flips gain little at first.
    if (!(after > before + std::min(1e-6, 1e-2 * std::abs(before)))) return false;
    if (!surface_.oriented(a, d, c) || !surface_.oriented(b, c, d)) return false;
    if (bend(c, d) > std::max(kLargestBend, bend(a, b)) || !flip_keeps_shape(h)) return false;
    return mesh_.find_half_edge(mesh_.apex(h), mesh_.apex(g)) == kNone &&
           mesh_.find_half_edge(mesh_.apex(g), mesh_.apex(h)) == kNone && !same_node(mesh_.apex(h), mesh_.apex(g));
  }

  // In space, a flip over a bend cuts it off: the new edge must lie near the surface, or nearer than the old one.
  bool flip_keeps_shape(std::uint32_t h) const {
    if (surface_.smooth()) return true;
    constexpr double kTolerance = 0.1;  // of the size
    const PatchPlace &a = place(mesh_.origin(h)), &b = place(mesh_.target(h));
    const PatchPlace &c = place(mesh_.apex(h)), &d = place(mesh_.apex(mesh_.twin(h)));
    const double tolerance =
        kTolerance * std::min(patch_.vertices[mesh_.origin(h)].size, patch_.vertices[mesh_.target(h)].size);
    if (distance_of_lines(a.point, b.point, c.point, d.point) <= tolerance) return true;
    const auto sag = [&](const PatchPlace& p, const PatchPlace& q) {
      const Vec3 middle = 0.5 * (p.point + q.point);
      return distance(surface_.nearest(middle, p.plane).point, middle);
    };
    const double after = sag(c, d);
    return after <= tolerance || after < sag(a, b);
  }

  // How much longer an edge is along the surface than through space: triangles may look good in space and yet cut
  // through a face that winds.
  double bend(const PatchPlace& a, const PatchPlace& b) const {
    return surface_.edge_length(a, b) / std::max(distance(a.point, b.point), 1e-300);
  }

  bool same_node(std::uint32_t a, std::uint32_t b) const {
    return patch_.vertices[a].node != kNone && patch_.vertices[a].node == patch_.vertices[b].node;
  }

  void flip_from(std::vector<std::uint32_t>& queue) {
    while (!queue.empty()) {
      const std::uint32_t h = queue.back();
      queue.pop_back();
      if (!mesh_.alive(h / 3) || !flip_improves(h)) continue;
      const std::uint32_t t = h / 3, s = mesh_.twin(h) / 3;
      for (const std::uint32_t v : {mesh_.origin(h), mesh_.target(h), mesh_.apex(h), mesh_.apex(mesh_.twin(h))})
        to_smooth_[v] = 1;
      mesh_.flip(h);
      for (const std::uint32_t k : {3 * t, 3 * t + 2, 3 * s, 3 * s + 2}) queue.push_back(k);
    }
  }

  void flip_all() {
    queue_.clear();
    for (std::uint32_t h = mesh_.half_edges(); h-- > 0;) {
      const std::uint32_t g = mesh_.alive(h / 3) ? mesh_.twin(h) : kNone;
      if (g == kNone || h > g) continue;
      if (to_flip_[mesh_.origin(h)] || to_flip_[mesh_.target(h)] || to_flip_[mesh_.apex(h)] || to_flip_[mesh_.apex(g)])
        queue_.push_back(h);
    }
    std::fill(to_flip_.begin(), to_flip_.end(), std::uint8_t{0});
    flip_from(queue_);
  }

  void flip_around(std::uint32_t v) {
    queue_.clear();
    mesh_.for_each_outgoing(v, [&](std::uint32_t h) {
      queue_.push_back(h);
      queue_.push_back(Triangulation::next(h));
      return true;
    });
    flip_from(queue_);
  }

  // ---- vertex moves ------------------------------------------------------------------------------------------------
  // Opposite edges of the ball of v, in order.
  void collect_link(std::uint32_t v) {
    link_.clear();
    mesh_.for_each_outgoing(v, [&](std::uint32_t h) {
      if (!collapsed(h / 3)) link_.push_back({mesh_.target(h), mesh_.apex(h)});
      return true;
    });
  }

  struct BallQuality {
    double worst, energy;
  };
  BallQuality ball_quality(const PatchPlace& at) const {
    BallQuality result{1, 0};
    for (const auto& [p, q] : link_) {
      const double quality = signed_quality(at, place(p), place(q));
      result.worst = std::min(result.worst, quality);
      result.energy += quality > 1e-9 ? 1 / (quality * quality) : 1e18;
    }
    return result;
  }

  bool ball_oriented(const PatchPlace& at) const {
    for (const auto& [p, q] : link_)
      if (!surface_.oriented(at, place(p), place(q))) return false;
    return true;
  }

  // Newton's step for Σ 1/q² in the tangent plane, as components along two orthonormal tangents.
  bool newton_step(const PatchPlace& at, const Vec3& e1, const Vec3& e2, Vec2& step) const {
    double g1 = 0, g2 = 0, h11 = 0, h12 = 0, h22 = 0;
    for (const auto& [p, q] : link_) {
      const Vec3 rp = place(p).point - at.point, rq = place(q).point - at.point;
      const Vec2 a{dot(rp, e1), dot(rp, e2)}, b{dot(rq, e1), dot(rq, e2)};
      const double area2 = cross(a, b);
      const Vec2 edge = b - a;
      const double squares = dot(a, a) + dot(b, b) + dot(edge, edge);
      if (!(area2 > 1e-3 * squares)) return false;
      // f = (S/D)² up to a constant, S = Σl², D = 2·area: D is linear in the position, S quadratic.
      const double r = squares / area2;
      const Vec2 ds = -2.0 * (a + b), dd{-edge.v, edge.u};
      const Vec2 dr{(ds.u - r * dd.u) / area2, (ds.v - r * dd.v) / area2};
      g1 += 2 * r * dr.u;
      g2 += 2 * r * dr.v;
      // r'' = (4·I - dr⊗dd - dd⊗dr) / D ; f'' = 2 dr⊗dr + 2 r r''
      h11 += 2 * dr.u * dr.u + 2 * r * (4 - 2 * dr.u * dd.u) / area2;
      h22 += 2 * dr.v * dr.v + 2 * r * (4 - 2 * dr.v * dd.v) / area2;
      h12 += 2 * dr.u * dr.v - 2 * r * (dr.u * dd.v + dr.v * dd.u) / area2;
    }
    const double determinant = h11 * h22 - h12 * h12;
    if (!(determinant > 1e-12 * h11 * h22) || !(h11 > 0)) return false;
    step = {-(h22 * g1 - h12 * g2) / determinant, -(h11 * g2 - h12 * g1) / determinant};
    return true;
  }

  // Towards the centroid of the link: for balls that are not valid yet.
  Vec2 centering_step(const PatchPlace& at, const Vec3& e1, const Vec3& e2) const {
    Vec3 sum;
    for (const auto& [p, q] : link_) sum += place(p).point + place(q).point;
    const Vec3 move = sum / (2.0 * static_cast<double>(link_.size())) - at.point;
    return {dot(move, e1), dot(move, e2)};
  }

  bool smooth(std::uint32_t v) {
    collect_link(v);
    if (link_.size() < 3) return false;
    const PatchPlace& at = place(v);
    const BallQuality before = ball_quality(at);
    if (before.worst > kGoodEnough || at.normal == Vec3{}) return false;
    const Vec3 e1 = normalized(at.du), e2 = cross(at.normal, e1);
    Vec2 step;
    if (!newton_step(at, e1, e2, step)) step = centering_step(at, e1, e2);
    const double reach = 0.5 * patch_.vertices[v].size, length = norm(step);
    if (length > reach) step = (reach / length) * step;
    if (length < 1e-4 * patch_.vertices[v].size) return false;
    for (int halving = 0; halving < 3; ++halving, step = 0.4 * step) {
      const PatchPlace moved = surface_.displaced(at, along_axes(at, e1, e2, step));
      if (!ball_oriented(moved)) continue;
      const BallQuality after = ball_quality(moved);
      const bool better =
          before.worst > 0.05 ? after.energy < before.energy && after.worst > 0.05 : after.worst > before.worst;
      if (!better) continue;
      PatchVertex& vertex = patch_.vertices[v];
      vertex.place = moved;
      return true;
    }
    return false;
  }

  // Components along du and dv of a step given along e1 ∥ du and e2.
  static Vec2 along_axes(const PatchPlace& at, const Vec3& e1, const Vec3& e2, const Vec2& step) {
    const double u1 = dot(at.du, e1), v1 = dot(at.dv, e1), v2 = dot(at.dv, e2);
    const double v = v2 != 0 ? step.v / v2 : 0;
    return {u1 != 0 ? (step.u - v * v1) / u1 : 0, v};
  }

  void smooth_all() {
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
      if (v % 4096 == 4095 && !keep_going_()) return;
      if (!to_smooth_[v] || !movable(v) || mesh_.outgoing(v) == kNone) continue;
      to_smooth_[v] = 0;
      if (!smooth(v)) continue;
      refresh_size(v);
      touch(v);
    }
  }

  // The ball of v has changed: its edges may want to flip, and its vertices to move.
  void touch(std::uint32_t v) {
    to_smooth_[v] = to_flip_[v] = 1;
    for (const auto& [p, q] : link_) to_smooth_[p] = to_smooth_[q] = 1;
  }

  void refresh_size(std::uint32_t v) { patch_.vertices[v].size = surface_.size_at(place(v).point); }

  // ---- splits and collapses ----------------------------------------------------------------------------------------
  // Whether `middle` may become the middle of the edge of h.
  bool split_fits(std::uint32_t h, const PatchPlace& middle) const {
    const PatchPlace &a = place(mesh_.origin(h)), &b = place(mesh_.target(h));
    const PatchPlace &c = place(mesh_.apex(h)), &d = place(mesh_.apex(mesh_.twin(h)));
    // A projection that lands elsewhere would leave the edges as long as they were.
    constexpr double kLongestHalf = 0.8;
    const double longest = kLongestHalf * surface_.edge_length(a, b);
    if (!same_node(mesh_.origin(h), mesh_.target(h)) &&
        (surface_.edge_length(a, middle) > longest || surface_.edge_length(middle, b) > longest))
      return false;
    return surface_.oriented(a, middle, c) && surface_.oriented(middle, b, c) && surface_.oriented(b, middle, d) &&
           surface_.oriented(middle, a, d);
  }

  // The middle of the edge itself, which turns no triangle: later moves bring it to the surface.
  PatchPlace on_chord(std::uint32_t h, const PatchPlace& near) const {
    const Vec3 &a = place(mesh_.origin(h)).point, &b = place(mesh_.target(h)).point;
    const Vec3 &c = place(mesh_.apex(h)).point, &d = place(mesh_.apex(mesh_.twin(h))).point;
    const Vec3 normal = normalized(normalized(cross(b - a, c - a)) + normalized(cross(a - b, d - b)));
    return place_in_space(near.plane, 0.5 * (a + b), normal == Vec3{} ? near.normal : normal);
  }

  bool split(std::uint32_t h) {
    const std::uint32_t g = mesh_.twin(h);
    if (g == kNone || mesh_.fixed(h) || collapsed(h / 3) || collapsed(g / 3)) return false;
    const PatchPlace &a = place(mesh_.origin(h)), &b = place(mesh_.target(h));
    PatchPlace middle = surface_.midpoint(a, b);
    if (!split_fits(h, middle)) {
      if (!adapting_ || surface_.smooth()) return false;
      middle = on_chord(h, middle);
    }
    const std::uint32_t v = mesh_.add_vertex();
    patch_.vertices.push_back({middle, surface_.size_at(middle.point), kNone});
    to_smooth_.push_back(1);
    to_flip_.push_back(1);
    mesh_.split_edge(h, v);
    flip_around(v);
    return true;
  }

  // Moves v onto the neighbour `to` where that leaves a valid ball no worse than `floor`.
  bool collapse(std::uint32_t h, double floor) {
    const std::uint32_t v = mesh_.origin(h), to = mesh_.target(h);
    if (!movable(v) || !mesh_.collapse_keeps_topology(h)) return false;
    bool allowed = true;
    mesh_.for_each_outgoing(v, [&](std::uint32_t spoke) {
      if (collapsed(spoke / 3)) return allowed = false;
      const std::uint32_t p = mesh_.target(spoke), q = mesh_.apex(spoke);
      if (p == to || q == to) return true;
      allowed = !same_node(p, to) && !same_node(q, to) && surface_.oriented(place(to), place(p), place(q)) &&
                signed_quality(place(to), place(p), place(q)) > floor && relative_length(to, p) < kLongest &&
                relative_length(to, q) < kLongest;
      return allowed;
    });
    if (!allowed) return false;
    mesh_.collapse(h);
    mesh_.for_each_outgoing(to,
                            [&](std::uint32_t spoke) { return to_smooth_[mesh_.target(spoke)] = to_flip_[to] = 1; });
    flip_around(to);
    return true;
  }

  // Whether no edge of the two triangles is longer. Splitting only such edges leaves no triangle thinner than half of
  // what it was, also where the longest edge refuses or lies on the rim (Rivara 1984).
  bool longest_around(std::uint32_t h) const {
    constexpr double kAlike = 1.01;
    const double length = kAlike * relative_length(mesh_.origin(h), mesh_.target(h));
    const auto is_longer = [&](std::uint32_t other) {
      return relative_length(mesh_.origin(other), mesh_.target(other)) > length;
    };
    const std::uint32_t g = mesh_.twin(h);
    return !is_longer(Triangulation::next(h)) && !is_longer(Triangulation::prev(h)) &&
           !is_longer(Triangulation::next(g)) && !is_longer(Triangulation::prev(g));
  }

  bool split_long(double longest) {
    bool any = false;
    const std::uint32_t end = mesh_.half_edges();
    for (std::uint32_t h = 0; h < end; ++h) {
      if (!mesh_.alive(h / 3) || mesh_.twin(h) == kNone) continue;
      const std::uint32_t a = mesh_.origin(h), b = mesh_.target(h);
      if (!same_node(a, b) && (relative_length(a, b) <= longest || (adapting_ && !longest_around(h)))) continue;
      if (split(h)) any = true;
    }
    return any;
  }

  bool collapse_short(double shortest, double floor) {
    bool any = false;
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
      if (!movable(v) || mesh_.outgoing(v) == kNone) continue;
      std::uint32_t best = kNone;
      double least = shortest;
      mesh_.for_each_outgoing(v, [&](std::uint32_t h) {
        const double length = relative_length(v, mesh_.target(h));
        if (length < least) {
          least = length;
          best = h;
        }
        return true;
      });
      if (best != kNone && collapse(best, floor)) any = true;
    }
    return any;
  }

  void fit_lengths() {
    split_long(kLongest);
    collapse_short(kShortest, 0.3);
  }

  void adapt_density() {
    constexpr int kMostPasses = 12;
    adapting_ = true;
    for (int pass = 0; pass < kMostPasses && keep_going_(); ++pass) {
      const bool split_some = split_long(kLongest);
      const bool collapsed_some = collapse_short(kShortest, 0.02);
      flip_all();
      smooth_all();
      if (!split_some && !collapsed_some) break;
    }
    adapting_ = false;
  }

  // Inner vertices with three or four triangles spoil their neighbours: collapse them where the result is better.
  void remove_low_valence() {
    for (std::uint32_t v = 0; v < mesh_.vertex_count(); ++v) {
      if (!movable(v) || mesh_.outgoing(v) == kNone) continue;
      collect_link(v);
      if (link_.size() > 4) continue;
      const double worst = ball_quality(place(v)).worst;
      std::array<std::uint32_t, 4> spokes{};
      std::size_t count = 0;
      mesh_.for_each_outgoing(v, [&](std::uint32_t h) { return spokes[count++] = h, count < 4; });
      for (std::size_t i = 0; i < count; ++i)
        if (collapse(spokes[i], std::max(0.55, std::min(worst, 0.75)))) break;
    }
  }

  Patch& patch_;
  Triangulation& mesh_;
  const PatchSurface& surface_;
  const std::function<bool()>& keep_going_;
  std::vector<std::array<std::uint32_t, 2>> link_;
  std::vector<std::uint32_t> queue_;
  bool adapting_ = false;
  std::vector<std::uint8_t> to_smooth_, to_flip_;  // per vertex: something near it has changed
};

}  // namespace

void optimize_patch(Patch& patch, const PatchSurface& surface, const PatchOptimizerOptions& options,
                    const std::function<bool()>& keep_going) {
  PatchOptimizer(patch, surface, keep_going).run(options);
}

}  // namespace tetloom
