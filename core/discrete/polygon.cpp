#include "core/discrete/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tetloom::detail {
namespace {

Vec3 newell_normal(std::span<const Vec3> corners) {
  Vec3 normal;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = corners[i] - corners[0], b = corners[(i + 1) % corners.size()] - corners[0];
    normal += cross(a, b);
  }
  return normalized(normal);
}

/// Clips ears from a ring of corners projected along the normal.
class EarClipper {
 public:
  explicit EarClipper(std::span<const Vec3> corners) : corners_(corners), normal_(newell_normal(corners)) {
    ring_.resize(corners.size());
    std::iota(ring_.begin(), ring_.end(), 0u);
  }

  std::vector<std::array<std::uint32_t, 3>> run() {
    std::vector<std::array<std::uint32_t, 3>> triangles;
    triangles.reserve(corners_.size() - 2);
    while (ring_.size() > 3) {
      const std::size_t ear = ring_.size() > kManyCorners ? find_next_ear() : find_best_ear();
      triangles.push_back(triangle_at(ear));
      ring_.erase(ring_.begin() + static_cast<std::ptrdiff_t>(ear));
    }
    triangles.push_back({ring_[0], ring_[1], ring_[2]});
    return triangles;
  }

 private:
  std::array<std::uint32_t, 3> triangle_at(std::size_t i) const {
    const std::size_t n = ring_.size();
    return {ring_[(i + n - 1) % n], ring_[i], ring_[(i + 1) % n]};
  }

  double signed_area(std::uint32_t a, std::uint32_t b, std::uint32_t c) const {
    return dot(normal_, cross(corners_[b] - corners_[a], corners_[c] - corners_[a]));
  }

  bool is_ear(const std::array<std::uint32_t, 3>& t) const {
    return std::none_of(ring_.begin(), ring_.end(), [&](std::uint32_t p) {
      if (p == t[0] || p == t[1] || p == t[2]) return false;
      return signed_area(t[0], t[1], p) >= 0 && signed_area(t[1], t[2], p) >= 0 && signed_area(t[2], t[0], p) >= 0;
    });
  }

  /// The first ear from where the last one was clipped.
  std::size_t find_next_ear() {
    for (std::size_t step = 0; step < ring_.size(); ++step) {
      const std::size_t i = (last_ + step) % ring_.size();
      const auto t = triangle_at(i);
      if (signed_area(t[0], t[1], t[2]) > 0 && is_ear(t)) return last_ = i;
    }
    return last_ = 0;
  }

  /// The convex ear with the best ratio of area to squared perimeter; of a polygon without ears, the first corner.
  std::size_t find_best_ear() const {
    std::size_t best = 0;
    double best_shape = 0;
    for (std::size_t i = 0; i < ring_.size(); ++i) {
      const auto t = triangle_at(i);
      const double area = signed_area(t[0], t[1], t[2]);
      if (!(area > 0)) continue;
      const double perimeter = distance(corners_[t[0]], corners_[t[1]]) + distance(corners_[t[1]], corners_[t[2]]) +
                               distance(corners_[t[2]], corners_[t[0]]);
      const double shape = area / (perimeter * perimeter);
      if (shape > best_shape && is_ear(t)) best = i, best_shape = shape;
    }
    return best;
  }

  static constexpr std::size_t kManyCorners = 128;  // more would make the search for the best ear too slow
  std::span<const Vec3> corners_;
  Vec3 normal_;
  std::vector<std::uint32_t> ring_;
  std::size_t last_ = 0;
};

bool is_convex(std::span<const Vec3> corners) {
  const Vec3 normal = newell_normal(corners);
  const std::size_t n = corners.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 turn = cross(corners[(i + 1) % n] - corners[i], corners[(i + 2) % n] - corners[(i + 1) % n]);
    if (dot(turn, normal) < 0) return false;
  }
  return true;
}

/// Halves the ring again and again, which gives fatter triangles than a fan. For convex polygons.
std::vector<std::array<std::uint32_t, 3>> halve_convex(std::size_t corners) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<std::uint32_t> ring(corners);
  std::iota(ring.begin(), ring.end(), 0u);
  while (ring.size() > 2) {
    std::vector<std::uint32_t> inner;
    for (std::size_t i = 0; i < ring.size(); i += 2) {
      inner.push_back(ring[i]);
      if (i + 1 < ring.size() && ring.size() > 2) {
        triangles.push_back({ring[i], ring[i + 1], ring[(i + 2) % ring.size()]});
      }
    }
    if (ring.size() == 3) break;
    ring = std::move(inner);
  }
  return triangles;
}

}  // namespace

std::vector<std::array<std::uint32_t, 3>> triangulate_polygon(std::span<const Vec3> corners) {
  constexpr std::size_t kFewCorners = 64;
  if (corners.size() == 3) return {{0, 1, 2}};
  if (corners.size() > kFewCorners && is_convex(corners)) return halve_convex(corners.size());
  return EarClipper(corners).run();
}

}  // namespace tetloom::detail
