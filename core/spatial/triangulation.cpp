#include "core/spatial/triangulation.hpp"

#include <algorithm>
#include <compare>

namespace tetloom {

void Triangulation::fix(std::uint32_t h, std::uint8_t count) {
  fixed_[h] = count;
  if (twin_[h] != kNone) fixed_[twin_[h]] = count;
}

std::uint32_t Triangulation::add_vertex() {
  vert_to_half_edge_.push_back(kNone);
  return vertex_count() - 1;
}

Triangulation Triangulation::from_triangles(std::uint32_t vertex_count,
                                            std::span<const std::array<std::uint32_t, 3>> triangles) {
  Triangulation result;
  result.vert_to_half_edge_.assign(vertex_count, kNone);
  struct Side {
    std::uint32_t low, high, half_edge;
    auto operator<=>(const Side&) const = default;
  };
  std::vector<Side> sides;
  for (const auto& corners : triangles) {
    const std::uint32_t first = 3 * result.add_triangle(corners[0], corners[1], corners[2]);
    for (std::uint32_t h = first; h < first + 3; ++h) {
      const std::uint32_t a = result.origin(h), b = result.target(h);
      sides.push_back({std::min(a, b), std::max(a, b), h});
    }
  }
  std::sort(sides.begin(), sides.end());
  for (std::size_t i = 0; i + 1 < sides.size(); ++i)
    if (sides[i].low == sides[i + 1].low && sides[i].high == sides[i + 1].high)
      result.link(sides[i].half_edge, sides[i + 1].half_edge);
  return result;
}

void Triangulation::reserve(std::size_t vertices) {
  const std::size_t half_edges = 3 * 2 * vertices;
  vert_.reserve(half_edges);
  twin_.reserve(half_edges);
  fixed_.reserve(half_edges);
  vert_to_half_edge_.reserve(vertices);
  fan_at_.reserve(vertices);
}

std::uint32_t Triangulation::take_slot() {
  if (!free_.empty()) {
    const std::uint32_t tri = free_.back();
    free_.pop_back();
    return tri;
  }
  const std::uint32_t tri = slots();
  vert_.resize(vert_.size() + 3, kNone);
  twin_.resize(vert_.size(), kNone);
  fixed_.resize(vert_.size(), 0);
  return tri;
}

std::uint32_t Triangulation::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  const std::uint32_t tri = take_slot();
  const std::array corner{a, b, c};
  for (std::uint32_t i = 0; i < 3; ++i) {
    vert_[3 * tri + i] = corner[i];
    twin_[3 * tri + i] = kNone;
    fixed_[3 * tri + i] = 0;
    vert_to_half_edge_[corner[i]] = 3 * tri + i;
  }
  return tri;
}

void Triangulation::remove_triangle(std::uint32_t tri) {
  for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
    const std::uint32_t vertex = vert_[h];
    if (vert_to_half_edge_[vertex] == h) {
      const std::uint32_t ccw = twin_[prev(h)];
      vert_to_half_edge_[vertex] = ccw != kNone ? ccw : twin_[h] != kNone ? next(twin_[h]) : kNone;
    }
  }
  for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
    if (twin_[h] != kNone) twin_[twin_[h]] = kNone;
    twin_[h] = vert_[h] = kNone;
    fixed_[h] = 0;
  }
  free_.push_back(tri);
}

void Triangulation::link(std::uint32_t h, std::uint32_t g) {
  if (h != kNone) twin_[h] = g;
  if (g != kNone) twin_[g] = h;
}

// The half-edges that leave a vertex, as for_each_outgoing visits them.
class Triangulation::Fan {
 public:
  Fan(const Triangulation& mesh, std::uint32_t vertex) : mesh_(mesh), start_(mesh.outgoing(vertex)), at_(start_) {}
  /// kNone after the last.
  std::uint32_t at() const { return at_; }
  /// Whether the walk is over, and the vertex has triangles all around.
  bool is_closed() const { return is_closed_; }
  void advance() {
    if (!is_backwards_) {
      at_ = mesh_.twin(prev(at_));
      is_closed_ = at_ == start_;
      if (is_closed_) at_ = kNone;
      if (at_ != kNone || is_closed_) return;
      is_backwards_ = true, at_ = start_;
    }
    const std::uint32_t twin = mesh_.twin(at_);
    at_ = twin == kNone ? kNone : next(twin);
  }

 private:
  const Triangulation& mesh_;
  std::uint32_t start_, at_;
  bool is_backwards_ = false, is_closed_ = false;
};

// Walks around both vertices in turn, so that the one with fewer neighbours decides how long it takes.
std::uint32_t Triangulation::find_half_edge(std::uint32_t a, std::uint32_t b) const {
  Fan from(*this, a), to(*this, b);
  while (from.at() != kNone) {
    if (target(from.at()) == b) return from.at();
    from.advance();
    if (to.at() == kNone) continue;
    if (apex(to.at()) == a) return prev(to.at());
    to.advance();
    if (to.is_closed()) return kNone;
  }
  return kNone;
}

void Triangulation::flip(std::uint32_t h) {
  const std::uint32_t g = twin_[h];
  const std::uint32_t t = h - h % 3, s = g - g % 3;
  const std::uint32_t a = vert_[h], b = vert_[g], c = apex(h), d = apex(g);
  const std::array outer{twin_[next(g)], twin_[prev(h)], twin_[next(h)], twin_[prev(g)]};
  const std::array marks{fixed_[next(g)], fixed_[prev(h)], fixed_[next(h)], fixed_[prev(g)]};
  // t = (a, d, c), s = (b, c, d)
  const std::array<std::uint32_t, 3> t_verts{a, d, c}, s_verts{b, c, d};
  for (std::uint32_t i = 0; i < 3; ++i) {
    vert_[t + i] = t_verts[i];
    vert_[s + i] = s_verts[i];
    vert_to_half_edge_[t_verts[i]] = t + i;
  }
  vert_to_half_edge_[b] = s;
  const std::array<std::uint32_t, 4> rim{t, t + 2, s, s + 2};
  for (std::size_t i = 0; i < 4; ++i) {
    link(rim[i], outer[i]);
    fixed_[rim[i]] = marks[i];
  }
  link(t + 1, s + 1);
  fixed_[t + 1] = fixed_[s + 1] = 0;
}

void Triangulation::fill_cavity(std::uint32_t vertex, std::span<const std::uint32_t> cavity,
                                std::vector<std::uint32_t>& created) {
  struct RimEdge {
    std::uint32_t a, b, outer;
    std::uint8_t fixed;
  };
  thread_local std::vector<RimEdge> rim;
  rim.clear();
  for (const std::uint32_t tri : cavity) fixed_[3 * tri] = static_cast<std::uint8_t>(fixed_[3 * tri] | 0x80u);
  for (const std::uint32_t tri : cavity) {
    for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
      const std::uint32_t outer = twin_[h];
      if (outer != kNone && (fixed_[outer - outer % 3] & 0x80u)) continue;
      rim.push_back({vert_[h], target(h), outer, static_cast<std::uint8_t>(fixed_[h] & 0x7fu)});
    }
  }
  fan_at_.resize(vert_to_half_edge_.size(), kNone);
  created.clear();
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const std::uint32_t tri = i < cavity.size() ? cavity[i] : take_slot();
    created.push_back(tri);
    const std::array corner{rim[i].a, rim[i].b, vertex};
    for (std::uint32_t k = 0; k < 3; ++k) {
      vert_[3 * tri + k] = corner[k];
      fixed_[3 * tri + k] = 0;
    }
    link(3 * tri, rim[i].outer);
    fixed_[3 * tri] = rim[i].fixed;
    vert_to_half_edge_[rim[i].a] = 3 * tri;
    fan_at_[rim[i].a] = 3 * tri;
  }
  for (const std::uint32_t tri : created) link(3 * tri + 1, Triangulation::prev(fan_at_[vert_[3 * tri + 1]]));
  vert_to_half_edge_[vertex] = 3 * created.front() + 2;
}

void Triangulation::split_edge(std::uint32_t h, std::uint32_t vertex) {
  const std::uint32_t g = twin_[h];
  const std::uint8_t mark = fixed_[h];
  const auto split_side = [&](std::uint32_t side) {
    // (a, b, c) with the edge ab becomes (a, v, c); the new triangle is (v, b, c).
    const std::uint32_t b = target(side), c = apex(side);
    const std::uint32_t outer = twin_[next(side)];
    const std::uint8_t outer_mark = fixed_[next(side)];
    const std::uint32_t tri = add_triangle(vertex, b, c);
    vert_[next(side)] = vertex;
    link(3 * tri + 1, outer);
    fixed_[3 * tri + 1] = outer_mark;
    link(next(side), 3 * tri + 2);
    fixed_[next(side)] = 0;
    fixed_[3 * tri] = mark;
    vert_to_half_edge_[c] = prev(side);
    return 3 * tri;
  };
  const std::uint32_t h2 = split_side(h);
  twin_[h] = twin_[h2] = kNone;
  if (g != kNone) {
    const std::uint32_t g2 = split_side(g);
    link(h, g2);
    link(h2, g);
  }
  vert_to_half_edge_[vertex] = h2;
}

bool Triangulation::collapse_keeps_topology(std::uint32_t h) const {
  const std::uint32_t from = origin(h), to = target(h);
  const std::uint32_t g = twin_[h];
  if (g == kNone) return false;
  bool allowed = true;
  std::uint32_t shared = 0;
  for_each_outgoing(from, [&](std::uint32_t spoke) {
    const bool is_second = target(spoke) == to && spoke != h;  // it would become a loop
    if (is_second || fixed_[spoke] || twin_[spoke] == kNone || fixed_[prev(spoke)] || twin_[prev(spoke)] == kNone) {
      allowed = false;
      return false;
    }
    if (target(spoke) != to && find_half_edge(target(spoke), to) != kNone)
      ++shared;
    else if (target(spoke) != to && find_half_edge(to, target(spoke)) != kNone)
      ++shared;
    return true;
  });
  return allowed && shared == 2;
}

void Triangulation::collapse(std::uint32_t h) {
  const std::uint32_t from = origin(h), to = target(h);
  const std::uint32_t g = twin_[h];
  thread_local std::vector<std::uint32_t> spokes;
  spokes.clear();
  for_each_outgoing(from, [&](std::uint32_t spoke) { return spokes.push_back(spoke), true; });
  const auto close = [&](std::uint32_t side) {
    const std::uint32_t left = twin_[next(side)], right = twin_[prev(side)];
    const auto mark = static_cast<std::uint8_t>(fixed_[next(side)] | fixed_[prev(side)]);
    const std::uint32_t c = apex(side);
    link(left, right);
    if (left != kNone) fixed_[left] = mark;
    if (right != kNone) fixed_[right] = mark;
    // left: c → head, right: tail → c, seen from outside the removed triangle
    vert_to_half_edge_[c] = left != kNone ? left : next(right);
    const std::uint32_t tri = side / 3;
    for (std::uint32_t k = 3 * tri; k < 3 * tri + 3; ++k) {
      twin_[k] = vert_[k] = kNone;
      fixed_[k] = 0;
    }
    free_.push_back(tri);
    return left != kNone ? next(left) : kNone;
  };
  for (const std::uint32_t spoke : spokes) vert_[spoke] = to;
  close(h);
  close(g);
  vert_to_half_edge_[from] = kNone;
  for (const std::uint32_t spoke : spokes)
    if (vert_[spoke] == to) {
      vert_to_half_edge_[to] = spoke;
      break;
    }
}

void Triangulation::compact() {
  std::vector<std::uint32_t> numbers(vertex_count()), order;
  for (std::uint32_t v = 0; v < vertex_count(); ++v) numbers[v] = v;
  for (std::uint32_t tri = 0; tri < slots(); ++tri)
    if (alive(tri)) order.push_back(tri);
  renumber(numbers, order);
}

void Triangulation::renumber(std::span<const std::uint32_t> vertex_numbers,
                             std::span<const std::uint32_t> triangle_order) {
  std::vector<std::uint32_t> moved(slots(), kNone);
  for (std::uint32_t i = 0; i < triangle_order.size(); ++i) moved[triangle_order[i]] = i;
  Triangulation result;
  result.vert_to_half_edge_.assign(vertex_count(), kNone);
  result.reserve(triangle_order.size() / 2 + 1);
  for (const std::uint32_t tri : triangle_order) {
    for (std::uint32_t h = 3 * tri; h < 3 * tri + 3; ++h) {
      const std::uint32_t v = vertex_numbers[vert_[h]];
      result.vert_to_half_edge_[v] = static_cast<std::uint32_t>(result.vert_.size());
      result.vert_.push_back(v);
      result.twin_.push_back(twin_[h] == kNone ? kNone : 3 * moved[twin_[h] / 3] + twin_[h] % 3);
      result.fixed_.push_back(fixed_[h]);
    }
  }
  *this = std::move(result);
}

bool Triangulation::validate() const {
  for (std::uint32_t h = 0; h < half_edges(); ++h) {
    if (!alive(h / 3)) continue;
    if (vert_[h] >= vertex_count()) return false;
    const std::uint32_t g = twin_[h];
    if (g == kNone) continue;
    if (g >= half_edges() || !alive(g / 3) || twin_[g] != h || vert_[g] != target(h) || target(g) != vert_[h] ||
        fixed_[g] != fixed_[h])
      return false;
  }
  for (std::uint32_t v = 0; v < vertex_count(); ++v) {
    const std::uint32_t h = vert_to_half_edge_[v];
    if (h != kNone && (h >= half_edges() || vert_[h] != v)) return false;
  }
  return true;
}

}  // namespace tetloom
