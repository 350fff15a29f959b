#include "mesher/tets/newton_smoothing.hpp"

#include <algorithm>

#include "mesher/tets/bad_tets.hpp"

namespace tetloom::tets {

namespace {

constexpr int kHalvings = 3;  // of a step that goes too far
constexpr double kFloor = 0.6 * 0.6 * 0.6;

double least_quality(WorkingMesh& mesh) {
  float least = 1;
  for (const float quality : mesh.qualities()) least = std::min(least, quality);
  return least;
}

// Up to the factor 432: the sum of 1/q^3, and the largest of 1/q^3.
struct Badness {
  double sum = 0, worst = 0;
};

// False when a tet is not surely positive.
bool badness_at(std::span<const StarTet> star, const Vec3& d, Badness& badness) {
  badness = {};
  bool positive = true;
  for (const StarTet& tet : star) {
    const double v = tet.volume_at(d), s = tet.squares_at(d), s3 = cube(s), v2 = v * v;
    positive &= v > 0 && 432 * v2 > kSurelyPositive * cube(std::max(s, tet.squares));
    const double term = s3 / v2;
    badness.sum += term;
    badness.worst = std::max(badness.worst, term);
  }
  return positive;
}

// Gradient, and the upper triangle of the Hessian.
struct Quadratic {  // of the sum
  Vec3 gradient;
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
  Badness badness;

  // f = s^3 / v^2 with ds = -2 middle, d2s = 6 and dv = normal.
  void add(const StarTet& tet) {
    const double s = tet.squares, i = 1 / tet.volume, r = s * i, r2 = r * r;
    const Vec3 &m = tet.middle, &n = tet.normal;
    const double term = s * r2;
    badness.sum += term;
    badness.worst = std::max(badness.worst, term);
    const double gm = -6 * r2, gn = -2 * r2 * r;
    gradient += gm * m + gn * n;
    const double identity = 18 * r2, mm = 24 * r * i, mn = 12 * r2 * i, nn = 6 * r2 * r * i;
    const Vec3 a = mm * m + mn * n, b = mn * m + nn * n;
    xx += identity + a.x * m.x + b.x * n.x;
    yy += identity + a.y * m.y + b.y * n.y;
    zz += identity + a.z * m.z + b.z * n.z;
    xy += a.x * m.y + b.x * n.y;
    xz += a.x * m.z + b.x * n.z;
    yz += a.y * m.z + b.y * n.z;
  }

  // -H^-1 g; not finite when H is singular.
  Vec3 step() const {
    const Vec3 c0{xx, xy, xz}, c1{xy, yy, yz}, c2{xz, yz, zz}, r = -gradient;
    const Vec3 n = cross(c1, c2);
    return Vec3{dot(r, n), dot(c0, cross(r, c2)), dot(c0, cross(c1, r))} / dot(c0, n);
  }
};

// The star's tets measured from its vertex.
void measure(const WorkingMesh& mesh, const VertexStar& star, std::span<StarTet> tets) {
  const Vec3 x = mesh.point(star.vertex);
  for (std::size_t i = 0; i < star.count; ++i) {
    const auto verts = mesh.verts(star.codes[i] / 4);
    const auto& [a, c, b] = kFaceVerts[star.codes[i] % 4];  // turned, so that it is seen from the vertex
    tets[i] = star_tet(mesh.point(verts[a]) - x, mesh.point(verts[b]) - x, mesh.point(verts[c]) - x);
  }
}

}  // namespace

Vec3 find_newton_step(std::span<const StarTet> star, const Vec3& x, double floor) {
  const double bearable = 432 / floor;
  Quadratic quadratic;
  for (const StarTet& tet : star) quadratic.add(tet);
  Vec3 step = quadratic.step();
  if (!is_finite(step)) return {};
  for (int i = 0; i <= kHalvings; ++i, step *= 0.5) {
    const Vec3 d = (x + step) - x;
    Badness badness;
    if (badness_at(star, d, badness) && badness.sum < quadratic.badness.sum &&
        badness.worst <= std::max(quadratic.badness.worst, bearable))
      return d;
  }
  return {};
}

MoveVerdict VertexMover::move(std::uint32_t tet, std::uint32_t corner) {
  const StarVerdict found = find_star(mesh_, tet, corner, star_);
  if (found != StarVerdict::Found)
    return found == StarVerdict::OnSurface ? MoveVerdict::OnSurface : MoveVerdict::TooLarge;
  const std::span<StarTet> tets = std::span(tets_).first(star_.count);
  measure(mesh_, star_, tets);
  Vec3& x = mesh_.mesh().points[star_.vertex];
  const Vec3 step = find_newton_step(tets, x, floor_);
  if (step == Vec3{}) return MoveVerdict::NoGain;
  x += step;
  for (std::size_t i = 0; i < star_.count; ++i)
    mesh_.set_quality(star_.codes[i] / 4, cubed_quality(tets[i].volume_at(step), tets[i].squares_at(step)));
  return MoveVerdict::Moved;
}

std::size_t move_vertices(WorkingMesh& mesh, double limit, const TaskRunner& runner) {
  GrowingArray<std::uint8_t> visited;
  visited.resize(mesh.mesh().points.size());
  VertexMover mover(mesh, std::max(kFloor, least_quality(mesh)));
  std::size_t count = 0;
  for_each_bad_tet(mesh, limit, runner, [&](std::uint32_t tet) {
    for (std::uint32_t corner = 0; corner < 4; ++corner) {
      const std::uint32_t vertex = mesh.verts(tet)[corner];
      if (mesh.is_fixed_point(vertex) || visited[vertex] != 0) continue;
      visited[vertex] = 1;
      count += mover.move(tet, corner) == MoveVerdict::Moved;
    }
  });
  return count;
}

}  // namespace tetloom::tets
