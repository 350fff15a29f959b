#include "mesher/volume/smoothing.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/predicates/predicates.hpp"

namespace tetloom::volume {

namespace {

constexpr int kHalvings = 4;                  // of a Newton step that goes too far
constexpr std::size_t kBetweenChecks = 4096;  // vertices between two looks at the cancellation

// The face of a tetrahedron opposite to the vertex that moves, seen so that the volume is positive on its inner side.
struct Facet {
  Vec3 a, b, c;
};

// S is the sum of squared edges, V the volume times 6; the term is S^3 / V^2, which is 1/q^3 up to a factor.
struct Term {
  double squares, volume;
};

Term term_at(const Facet& f, const Vec3& x) {
  const double squares =
      norm2(f.b - f.a) + norm2(f.c - f.b) + norm2(f.a - f.c) + norm2(x - f.a) + norm2(x - f.b) + norm2(x - f.c);
  return {squares, dot(cross(f.b - f.a, f.c - f.a), x - f.a)};
}

double cube(double x) { return x * x * x; }

// Mean ratio cubed; comparing it needs no root.
double quality3(const Term& t) { return t.volume > 0 ? 432 * t.volume * t.volume / cube(t.squares) : 0; }

double objective(const std::vector<Facet>& star, const Vec3& x) {
  double sum = 0;
  for (const Facet& facet : star) {
    const Term t = term_at(facet, x);
    if (!(t.volume > 0)) return std::numeric_limits<double>::infinity();
    sum += cube(t.squares) / (t.volume * t.volume);
  }
  return sum;
}

struct Symmetric3 {
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;

  void add_identity(double s) { xx += s, yy += s, zz += s; }
  // s * (a b^T + b a^T) / 2
  void add_product(double s, const Vec3& a, const Vec3& b) {
    xx += s * a.x * b.x, yy += s * a.y * b.y, zz += s * a.z * b.z;
    xy += s * 0.5 * (a.x * b.y + a.y * b.x);
    xz += s * 0.5 * (a.x * b.z + a.z * b.x);
    yz += s * 0.5 * (a.y * b.z + a.z * b.y);
  }
  std::optional<Vec3> solve(const Vec3& r) const {
    const Vec3 c0{xx, xy, xz}, c1{xy, yy, yz}, c2{xz, yz, zz};
    const Vec3 n = cross(c1, c2);
    const double determinant = dot(c0, n);
    if (!(determinant > 0)) return std::nullopt;
    return Vec3{dot(r, n), dot(c0, cross(r, c2)), dot(c0, cross(c1, r))} / determinant;
  }
};

// -H^-1 g of the objective.
std::optional<Vec3> newton_step(const std::vector<Facet>& star, const Vec3& x) {
  Vec3 gradient;
  Symmetric3 hessian;
  for (const Facet& f : star) {
    const auto [s, v] = term_at(f, x);
    const Vec3 ds = 2 * (3 * x - f.a - f.b - f.c), dv = cross(f.b - f.a, f.c - f.a);
    const double s2 = s * s, i = 1 / v, i2 = i * i;
    gradient += (3 * s2 * i2) * ds - (2 * s2 * s * i2 * i) * dv;
    hessian.add_identity(18 * s2 * i2);
    hessian.add_product(6 * s * i2, ds, ds);
    hessian.add_product(-12 * s2 * i2 * i, ds, dv);
    hessian.add_product(6 * s2 * s * i2 * i2, dv, dv);
  }
  return hessian.solve(-gradient);
}

class Smoother {
 public:
  Smoother(Filling& filling, const SmoothingOptions& options) : filling_(filling), options_(options) {
    first_.assign(filling.points.size() + 2, 0);
    for (const TetVertices& tet : filling.tet_to_vert) {
      for (const std::uint32_t v : tet) ++first_[v + 2];
    }
    for (std::size_t v = 2; v < first_.size(); ++v) first_[v] += first_[v - 1];
    tets_.resize(filling.tet_to_vert.size() * 4);
    for (std::uint32_t t = 0; t < filling.tet_to_vert.size(); ++t) {
      for (const std::uint32_t v : filling.tet_to_vert[t]) tets_[first_[v + 1]++] = t;
    }
  }

  void sweep(const TaskRunner& runner) {
    const double limit = cube(options_.threshold);
    for (std::size_t v = options_.fixed_points; v < filling_.points.size(); ++v) {
      if (v % kBetweenChecks == 0) runner.check_cancelled();
      collect_star(static_cast<std::uint32_t>(v));
      const Vec3& x = filling_.points[v];
      bool poor = false;
      for (const Facet& facet : star_) poor = poor || quality3(term_at(facet, x)) < limit;
      if (poor) move(static_cast<std::uint32_t>(v));
    }
  }

 private:
  void collect_star(std::uint32_t v) {
    star_.clear();
    for (std::uint32_t i = first_[v]; i < first_[v + 1]; ++i) {
      const TetVertices& tet = filling_.tet_to_vert[tets_[i]];
      int corner = 0;
      while (tet[corner] != v) ++corner;
      // Face `corner` is counter-clockwise from outside; swapped, its volume with the vertex is positive.
      const auto& [i0, i1, i2] = kFaceToCorner[corner];
      star_.push_back({filling_.points[tet[i0]], filling_.points[tet[i2]], filling_.points[tet[i1]]});
    }
  }

  void move(std::uint32_t v) {
    Vec3& x = filling_.points[v];
    const double before = objective(star_, x);
    const std::optional<Vec3> step = newton_step(star_, x);
    if (!step || !is_finite(*step)) return;
    double share = 1;
    for (int i = 0; i < kHalvings; ++i, share *= 0.5) {
      const Vec3 y = x + share * *step;
      if (!(objective(star_, y) < before) || !keeps_orientation(y)) continue;
      x = y;
      return;
    }
  }

  bool keeps_orientation(const Vec3& y) const {
    for (const Facet& f : star_) {
      if (orient3d(f.a, f.b, f.c, y) <= 0) return false;
    }
    return true;
  }

  Filling& filling_;
  const SmoothingOptions& options_;
  std::vector<std::uint32_t> first_, tets_;  // tets at each vertex
  std::vector<Facet> star_;
};

}  // namespace

void smooth_interior(Filling& filling, const SmoothingOptions& options, const TaskRunner& runner) {
  Smoother smoother(filling, options);
  for (int i = 0; i < options.sweeps; ++i) smoother.sweep(runner);
}

}  // namespace tetloom::volume
