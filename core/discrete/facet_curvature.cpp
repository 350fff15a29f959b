#include "core/discrete/facet_curvature.hpp"

#include <algorithm>
#include <cmath>

#include "core/discrete/facet_edges.hpp"

namespace tetloom::detail {
namespace {

struct TangentFrame {
  Vec3 u, v, normal;
};

/// An orthonormal frame around a unit normal (Duff et al. 2017).
TangentFrame make_frame(const Vec3& n) {
  const double sign = std::copysign(1.0, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
  return {{1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}, n};
}

/// Points joined by a facet edge, in one array.
class Neighbours {
 public:
  Neighbours(std::size_t point_count, std::span<const Triangle> tri_to_vert) : offset_(point_count + 1, 0) {
    for (const Triangle& t : tri_to_vert) {
      for (const std::uint32_t v : t) offset_[v + 1] += 2;
    }
    for (std::size_t v = 0; v < point_count; ++v) offset_[v + 1] += offset_[v];
    list_.resize(offset_.back());
    std::vector<std::uint32_t> fill(offset_.begin(), offset_.end() - 1);
    for (const Triangle& t : tri_to_vert) {
      for (int i = 0; i < 3; ++i) list_[fill[t[i]]++] = t[(i + 1) % 3], list_[fill[t[i]]++] = t[(i + 2) % 3];
    }
  }

  /// Neighbours of v; those inside of the surface appear twice.
  std::span<const std::uint32_t> of(std::uint32_t v) const {
    return std::span(list_).subspan(offset_[v], offset_[v + 1] - offset_[v]);
  }

 private:
  std::vector<std::uint32_t> offset_, list_;
};

/// Collects the points around a point, each once.
class RingCollector {
 public:
  RingCollector(std::size_t point_count, const Neighbours& neighbours)
      : neighbours_(neighbours), mark_(point_count, kNone) {}

  const std::vector<std::uint32_t>& collect(std::uint32_t center, bool on_rim) {
    constexpr std::size_t kEnough = 6;
    ring_.clear();
    mark_[center] = center;
    add_around(center, center);
    if (on_rim || ring_.size() < kEnough) {
      const std::size_t first_ring = ring_.size();
      for (std::size_t i = 0; i < first_ring && ring_.size() < kMost; ++i) add_around(ring_[i], center);
    }
    return ring_;
  }

 private:
  static constexpr std::size_t kMost = 48;  // the hub of a large fan would bring in all of its spokes
  void add_around(std::uint32_t v, std::uint32_t center) {
    for (const std::uint32_t other : neighbours_.of(v)) {
      if (mark_[other] == center || ring_.size() >= kMost) continue;
      mark_[other] = center;
      ring_.push_back(other);
    }
  }

  const Neighbours& neighbours_;
  std::vector<std::uint32_t> mark_, ring_;
};

/// Least squares in five unknowns, row by row: an upper triangle R with its right-hand side, kept by Givens rotations,
/// which is as accurate as the rows allow where normal equations would square their condition.
class LeastSquares {
 public:
  static constexpr int kUnknowns = 5;
  using Row = std::array<double, kUnknowns>;

  /// `pull` is how strongly each unknown is drawn towards zero. Pre: all > 0.
  explicit LeastSquares(const Row& pull) {
    for (int i = 0; i < kUnknowns; ++i) triangle_[i][i] = pull[i];
  }

  void add(Row row, double value) {
    for (int i = 0; i < kUnknowns; ++i) {
      if (row[i] == 0) continue;
      const double length = std::sqrt(triangle_[i][i] * triangle_[i][i] + row[i] * row[i]);
      const double c = triangle_[i][i] / length, s = row[i] / length;
      for (int j = i; j < kUnknowns; ++j) rotate(triangle_[i][j], row[j], c, s);
      rotate(right_[i], value, c, s);
    }
  }

  Row solve() const {
    Row x = right_;
    for (int i = kUnknowns - 1; i >= 0; --i) {
      for (int j = i + 1; j < kUnknowns; ++j) x[i] -= triangle_[i][j] * x[j];
      x[i] /= triangle_[i][i];
    }
    return x;
  }

 private:
  static void rotate(double& a, double& b, double c, double s) {
    const double old = a;
    a = c * old + s * b, b = c * b - s * old;
  }

  std::array<Row, kUnknowns> triangle_{};
  Row right_{};
};

/// z = a·x + b·y + (p·x² + 2q·x·y + r·y²) / 2 over the tangent plane of a frame.
struct Jet {
  double a = 0, b = 0, p = 0, q = 0, r = 0;
};

Jet fit_jet(std::span<const Vec3> points, const Vec3& center, const std::vector<std::uint32_t>& ring,
            const TangentFrame& frame) {
  // Where the ring leaves terms open, the weak pull towards zero decides: slopes are pulled least, so that points in
  // two rows are a slope and not a bend.
  constexpr double kSlope = 1e-9, kBend = 1e-6;
  double radius2 = 0;
  for (const std::uint32_t v : ring) radius2 = std::max(radius2, norm2(points[v] - center));
  if (!(radius2 > 0)) return {};
  const double scale = 1 / std::sqrt(radius2);
  // The mixed term counts twice, or the pull would depend on the frame's axes.
  LeastSquares fit({kSlope, kSlope, kBend, M_SQRT2 * kBend, kBend});
  for (const std::uint32_t v : ring) {
    const Vec3 d = scale * (points[v] - center);
    const double length = norm(d);
    if (!(length > 1e-9)) continue;
    const double x = dot(d, frame.u), y = dot(d, frame.v), z = dot(d, frame.normal), w = 1 / length;
    fit.add({w * x, w * y, w * x * x / 2, w * x * y, w * y * y / 2}, w * z);
  }
  const auto x = fit.solve();
  return {x[0], x[1], scale * x[2], scale * x[3], scale * x[4]};
}

SymmetricTensor to_tensor(const Jet& jet, const TangentFrame& frame) {
  SymmetricTensor tensor;
  int entry = 0;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      tensor[entry++] = jet.p * frame.u[i] * frame.u[j] + jet.q * (frame.u[i] * frame.v[j] + frame.v[i] * frame.u[j]) +
                        jet.r * frame.v[i] * frame.v[j];
    }
  }
  return tensor;
}

Vec3 multiply(const SymmetricTensor& m, const Vec3& x) {
  return {m[0] * x.x + m[1] * x.y + m[2] * x.z, m[1] * x.x + m[3] * x.y + m[4] * x.z,
          m[2] * x.x + m[4] * x.y + m[5] * x.z};
}

double magnitude(const SymmetricTensor& m) {
  return std::sqrt(m[0] * m[0] + m[3] * m[3] + m[5] * m[5] + 2 * (m[1] * m[1] + m[2] * m[2] + m[4] * m[4]));
}

/// Means over a point and its neighbours.
template <class Value, class Add>
std::vector<Value> mean_around(const std::vector<Value>& values, const Neighbours& neighbours, Add&& add) {
  std::vector<Value> means(values.size());
  for (std::uint32_t v = 0; v < values.size(); ++v) {
    const auto around = neighbours.of(v);
    const double share = 1 / (2.0 + static_cast<double>(around.size()));  // neighbours inside count twice
    Value sum{};
    add(sum, values[v], 2 * share);
    for (const std::uint32_t other : around) add(sum, values[other], share);
    means[v] = sum;
  }
  return means;
}

/// Takes the noise out of bending tensors. Noise of the points bends the surface to and fro from one point to the next,
/// so that the mean over a point's neighbours is small against the mean of the magnitudes; a feature as wide as three
/// facets is not. Where noise prevails, the mean over a few rings takes the place of the value.
void filter_noise(std::vector<SymmetricTensor>& bending, const Neighbours& neighbours) {
  constexpr int kRings = 8;                      // of averaging: a radius of about three facets
  constexpr double kNoise = 0.45, kClean = 0.7;  // mean / mean magnitude
  const auto add_tensor = [](SymmetricTensor& sum, const SymmetricTensor& m, double weight) {
    for (std::size_t i = 0; i < m.size(); ++i) sum[i] += weight * m[i];
  };
  const auto add_number = [](double& sum, double value, double weight) { sum += weight * value; };
  const auto magnitudes = [](const std::vector<SymmetricTensor>& tensors) {
    std::vector<double> result;
    for (const SymmetricTensor& m : tensors) result.push_back(magnitude(m));
    return result;
  };
  std::vector<SymmetricTensor> mean = mean_around(bending, neighbours, add_tensor);
  const std::vector<double> joint = mean_around(magnitudes(mean), neighbours, add_number);
  std::vector<double> single = mean_around(magnitudes(bending), neighbours, add_number);
  single = mean_around(single, neighbours, add_number);
  for (int ring = 1; ring < kRings; ++ring) mean = mean_around(mean, neighbours, add_tensor);
  for (std::size_t v = 0; v < bending.size(); ++v) {
    if (!(single[v] > 0)) continue;
    const double keep = std::clamp((joint[v] / single[v] - kNoise) / (kClean - kNoise), 0.0, 1.0);
    for (std::size_t i = 0; i < mean[v].size(); ++i) bending[v][i] = keep * bending[v][i] + (1 - keep) * mean[v][i];
  }
}

}  // namespace

std::vector<Vec3> compute_vertex_normals(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert) {
  std::vector<Vec3> normals(points.size());
  for (const Triangle& t : tri_to_vert) {
    const Vec3 normal = normalized(facet_normal(points, t));
    for (int i = 0; i < 3; ++i) {
      const Vec3 a = points[t[(i + 1) % 3]] - points[t[i]], b = points[t[(i + 2) % 3]] - points[t[i]];
      normals[t[i]] += std::atan2(norm(cross(a, b)), dot(a, b)) * normal;
    }
  }
  for (Vec3& normal : normals) normal = norm(normal) > 1e-9 ? normalized(normal) : Vec3{};
  return normals;
}

PointJets fit_jets(std::span<const Vec3> points, std::span<const Triangle> tri_to_vert,
                   const std::vector<bool>& on_rim) {
  constexpr double kSteep = 0.02, kTooSteep = 0.7;  // slopes in the frame of the mean normal
  constexpr int kRounds = 3;
  PointJets jets{compute_vertex_normals(points, tri_to_vert), std::vector<SymmetricTensor>(points.size())};
  const Neighbours neighbours(points.size(), tri_to_vert);
  RingCollector collector(points.size(), neighbours);
  for (std::uint32_t v = 0; v < points.size(); ++v) {
    const Vec3 mean = jets.normals[v];
    if (mean == Vec3{}) continue;
    const auto& ring = collector.collect(v, on_rim[v]);
    // The bending is read off where the slope is small, so turn the frame to the jet's own normal.
    for (int round = 0; round < kRounds; ++round) {
      const TangentFrame frame = make_frame(jets.normals[v]);
      const Jet jet = fit_jet(points, points[v], ring, frame);
      jets.bending[v] = to_tensor(jet, frame);
      const Vec3 normal = normalized(frame.normal - jet.a * frame.u - jet.b * frame.v);
      if (norm(normal - mean) > kTooSteep) break;
      jets.normals[v] = normal;
      if (std::hypot(jet.a, jet.b) < kSteep) break;
    }
  }
  filter_noise(jets.bending, neighbours);
  return jets;
}

PrincipalCurvatures principal_curvatures(const SymmetricTensor& bending, const Vec3& normal) {
  if (normal == Vec3{}) return {};
  const TangentFrame frame = make_frame(normal);
  const Vec3 mu = multiply(bending, frame.u), mv = multiply(bending, frame.v);
  const double a = dot(frame.u, mu), b = dot(frame.u, mv), c = dot(frame.v, mv);
  const double mean = (a + c) / 2, radius = std::hypot((a - c) / 2, b);
  PrincipalCurvatures result{mean + radius, mean - radius};
  if (std::abs(result.largest) < std::abs(result.smallest)) std::swap(result.largest, result.smallest);
  return result;
}

}  // namespace tetloom::detail
