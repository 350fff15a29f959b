#include "adapt/transfer/clip_tet.hpp"

#include <cmath>

#include "adapt/metric/tet_links.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::adapt {
namespace {

constexpr double kRoundOff = 1e-15;  // of a determinant, as a share of the sum of its products' magnitudes

/// A convex polyhedron in barycentric coordinates, with three edges at every vertex.
class Polyhedron {
 public:
  /// The whole tet.
  Polyhedron() : count_(4) {
    // Other ends of edges, as vertex · 4 + slot. Who comes in through one slot goes on through the next, and so goes
    // around a face counter-clockwise, seen from outside.
    constexpr std::array<std::array<std::uint16_t, 3>, 4> kEnds{{{1 * 4 + 0, 2 * 4 + 1, 3 * 4 + 2},
                                                                 {0 * 4 + 0, 3 * 4 + 1, 2 * 4 + 2},
                                                                 {3 * 4 + 0, 0 * 4 + 1, 1 * 4 + 2},
                                                                 {2 * 4 + 0, 1 * 4 + 1, 0 * 4 + 2}}};
    for (std::size_t v = 0; v < 4; ++v) {
      verts_[v].at = {};
      verts_[v].at[v] = 1;
      verts_[v].ends = kEnds[v];
      verts_[v].planes = 0;
    }
  }

  bool empty() const { return count_ == 0; }
  /// Planes that vertices were made on, as bits.
  unsigned planes() const {
    unsigned all = 0;
    for (std::size_t v = 0; v < count_; ++v) all |= verts_[v].planes;
    return all;
  }

  /// Keeps what lies on the positive side of the plane with those values at the corners of the tet.
  void clip(const std::array<double, 4>& values, unsigned plane) {
    std::array<double, kMost> heights;
    bool above = false, below = false;
    for (std::size_t v = 0; v < count_; ++v) {
      heights[v] = 0;
      for (std::size_t i = 0; i < 4; ++i) heights[v] += verts_[v].at[i] * values[i];
      above |= heights[v] > 0, below |= heights[v] < 0;
    }
    if (!above) count_ = 0;
    if (!above || !below) return;
    const std::size_t given = count_;
    cut_edges(heights, plane);
    close_faces(heights, given);
    remove_below(heights, given);
  }

  void integrate(ClippedTet& result) const {
    std::array<std::array<bool, 3>, kMost> seen{};
    const auto& origin = verts_[0].at;
    for (std::size_t v = 0; v < count_; ++v) {
      for (std::size_t slot = 0; slot < 3; ++slot) {
        if (seen[v][slot]) continue;
        // A fan of triangles from the first vertex of the face, each with the origin a tet.
        std::size_t last = v, last_slot = slot;
        const auto go_on = [&] {
          seen[last][last_slot] = true;
          const std::uint16_t end = verts_[last].ends[last_slot];
          last = end / 4, last_slot = (end % 4 + 1) % 3;
        };
        go_on();
        for (std::size_t before = last; last != v || last_slot != slot; before = last) {
          go_on();
          add_tet(origin, verts_[v].at, verts_[before].at, verts_[last].at, result);
        }
      }
    }
  }

 private:
  static constexpr std::size_t kMost = 96;  // each clip at most doubles the vertices that stay, of 4
  struct Vertex {
    std::array<double, 4> at;
    std::array<std::uint16_t, 3> ends;
    std::uint16_t planes;
  };

  // New vertices on edges that go down; their first slot leads to the upper end.
  void cut_edges(const std::array<double, kMost>& heights, unsigned plane) {
    const std::size_t given = count_;
    for (std::size_t v = 0; v < given; ++v) {
      for (std::size_t slot = 0; slot < 3; ++slot) {
        const std::size_t end = verts_[v].ends[slot] / 4u;
        if (heights[v] < 0 || !(heights[end] < 0)) continue;
        TETLOOM_DEBUG_ASSERT(count_ < kMost);
        const double share = heights[v] / (heights[v] - heights[end]);
        Vertex& made = verts_[count_];
        for (std::size_t i = 0; i < 4; ++i)
          made.at[i] = verts_[v].at[i] + share * (verts_[end].at[i] - verts_[v].at[i]);
        made.ends[0] = static_cast<std::uint16_t>(v * 4 + slot);
        made.planes = static_cast<std::uint16_t>((verts_[v].planes & verts_[end].planes) | plane);
        to_new_[v][slot] = static_cast<std::uint16_t>(count_++);
      }
    }
  }

  // Around every face that goes down, to where it comes up again: an edge between the two new vertices there.
  void close_faces(const std::array<double, kMost>& heights, std::size_t given) {
    for (std::size_t made = given; made < count_; ++made) {
      const std::uint16_t start = verts_[made].ends[0];
      std::uint16_t end = verts_[start / 4].ends[start % 4];
      while (heights[end / 4] < 0) end = verts_[end / 4].ends[(end % 4 + 1) % 3];
      const std::uint16_t other = to_new_[end / 4][end % 4];
      verts_[made].ends[1] = static_cast<std::uint16_t>(other * 4 + 2);
      verts_[other].ends[2] = static_cast<std::uint16_t>(made * 4 + 1);
    }
    for (std::size_t made = given; made < count_; ++made) {
      const std::uint16_t start = verts_[made].ends[0];
      verts_[start / 4].ends[start % 4] = static_cast<std::uint16_t>(made * 4);
    }
  }

  void remove_below(const std::array<double, kMost>& heights, std::size_t given) {
    std::array<std::uint16_t, kMost> to_kept;
    std::uint16_t kept = 0;
    for (std::size_t v = 0; v < count_; ++v) {
      if (v < given && heights[v] < 0) continue;
      to_kept[v] = kept;
      verts_[kept++] = verts_[v];
    }
    count_ = kept;
    for (std::size_t v = 0; v < count_; ++v)
      for (std::uint16_t& end : verts_[v].ends) end = static_cast<std::uint16_t>(to_kept[end / 4] * 4 + end % 4);
  }

  using Place = std::array<double, 4>;
  static void add_tet(const Place& o, const Place& a, const Place& b, const Place& c, ClippedTet& result) {
    const Vec3 u{a[1] - o[1], a[2] - o[2], a[3] - o[3]}, v{b[1] - o[1], b[2] - o[2], b[3] - o[3]};
    const double volume = dot(cross(u, v), {c[1] - o[1], c[2] - o[2], c[3] - o[3]});
    result.share += volume;
    for (std::size_t i = 0; i < 4; ++i) result.moment[i] += 0.25 * volume * (o[i] + a[i] + b[i] + c[i]);
  }

  std::size_t count_;
  std::array<Vertex, kMost> verts_;
  std::array<std::array<std::uint16_t, 3>, kMost> to_new_;
};

double abs_dot(const Vec3& a, const Vec3& b) { return std::abs(a.x * b.x) + std::abs(a.y * b.y) + std::abs(a.z * b.z); }

double volume_at(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& x) {
  const Vec3 u = a - x, v = b - x, w = c - x;
  const double value = dot(cross(u, v), w);
  const Vec3 products{std::abs(u.y * v.z) + std::abs(u.z * v.y), std::abs(u.z * v.x) + std::abs(u.x * v.z),
                      std::abs(u.x * v.y) + std::abs(u.y * v.x)};
  return std::abs(value) > kRoundOff * abs_dot(products, w) ? value : 0;
}

}  // namespace

std::array<double, 4> face_values(std::span<const Vec3> points, const TetVerts& verts, std::size_t face,
                                  const Corners& x) {
  std::array<std::uint32_t, 3> v;
  for (std::size_t i = 0; i < 3; ++i) v[i] = verts[kFaceVerts[face][i]];
  double sign = 1;
  const auto order = [&](std::uint32_t& a, std::uint32_t& b) {
    if (a > b) std::swap(a, b), sign = -sign;
  };
  order(v[0], v[1]), order(v[1], v[2]), order(v[0], v[1]);
  std::array<double, 4> values;
  for (std::size_t i = 0; i < 4; ++i) values[i] = sign * volume_at(points[v[0]], points[v[1]], points[v[2]], x[i]);
  return values;
}

ClippedTet clip_tet(const FaceValues& values) {
  ClippedTet result;
  Polyhedron polyhedron;
  for (unsigned face = 0; face < 4 && !polyhedron.empty(); ++face) polyhedron.clip(values[face], 1u << face);
  if (polyhedron.empty()) return result;
  polyhedron.integrate(result);
  const unsigned planes = polyhedron.planes();
  for (unsigned face = 0; face < 4; ++face) result.crossed[face] = (planes >> face & 1) != 0;
  return result;
}

}  // namespace tetloom::adapt
