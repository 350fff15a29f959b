#include "mesher/tets/newton_smoothing.hpp"

#include <algorithm>
#include <optional>

#include "core/tets/deep_point.hpp"
#include "core/tets/newton_step.hpp"
#include "core/tets/tet_pairs.hpp"
#include "mesher/tets/bad_tets.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

using pairs::PairVec;
using pairs::TetPair;

constexpr double kFloor = 0.6 * 0.6 * 0.6;  // a tet may get worse to here for the good of its star
constexpr double kNearlyFlat = 0.02 * 0.02 * 0.02;

double least_quality(WorkingMesh& mesh) {
  float least = 1;
  for (const float quality : mesh.qualities()) least = std::min(least, quality);
  return least;
}

// The points of the face opposite to a star's vertex, turned so that they are counter-clockwise seen from it.
std::array<const Vec3*, 3> opposite_face(const WorkingMesh& mesh, FaceCode code) {
  const auto verts = mesh.verts(code.tet());
  const auto& [a, c, b] = kFaceVerts[code.side()];
  return {&mesh.point(verts[a]), &mesh.point(verts[b]), &mesh.point(verts[c])};
}

// The star's tets measured from its vertex.
void measure(const WorkingMesh& mesh, const VertexStar& star, std::span<StarTet> tets) {
  const PairVec x = pairs::pair_of(mesh.point(star.vertex));
  for (std::size_t i = 0; i < star.count; i += 2) {
    const std::size_t j = std::min(i + 1, star.count - 1);
    const auto f = opposite_face(mesh, star.codes[i]), g = opposite_face(mesh, star.codes[j]);
    const TetPair pair = pairs::star_pair(pairs::pair_of(*f[0], *g[0]) - x, pairs::pair_of(*f[1], *g[1]) - x,
                                          pairs::pair_of(*f[2], *g[2]) - x);
    pairs::store(pair, tets[i], tets[j]);
  }
}

// The smallest cubed quality with the vertex at `d`; 0 where a tet is not surely positive.
double least_at(std::span<const StarTet> star, const Vec3& d) {
  double least = 1;
  for (const StarTet& tet : star) {
    if (!tet.is_surely_positive_at(d)) return 0;
    least = std::min(least, cubed_quality(tet.volume_at(d), tet.squares_at(d)));
  }
  return least;
}

// Newton's method leaves the neighbourhood of a face of the star slowly: where 1/q^3 has its pole, each step makes the
// distance from it half as large again. Such a vertex starts anew in the deepest place of its star.
Vec3 leave_flatness(std::span<const StarTet> star, const Vec3& x, const Vec3& step) {
  const double before = least_at(star, {});
  if (before >= kNearlyFlat) return step;
  const std::optional<DeepPoint> deep = find_deep_point(star);
  if (!deep) return step;
  const Vec3 d = (x + deep->point) - x;
  return least_at(star, d) > std::max(least_at(star, step), before * kGain) ? d : step;
}

}  // namespace

MoveVerdict VertexMover::move(std::uint32_t tet, std::uint32_t corner) {
  const StarVerdict found = find_star(mesh_, tet, corner, star_);
  if (found != StarVerdict::Found)
    return found == StarVerdict::OnSurface ? MoveVerdict::OnSurface : MoveVerdict::TooLarge;
  const std::span<StarTet> tets = std::span(tets_).first(star_.count);
  measure(mesh_, star_, tets);
  Vec3& x = mesh_.mesh().points[star_.vertex];
  const Vec3 step = leave_flatness(tets, x, find_newton_step(tets, x, floor_));
  if (step == Vec3{}) return MoveVerdict::NoGain;
  x += step;
  for (std::size_t i = 0; i < star_.count; ++i)
    mesh_.set_quality(star_.codes[i].tet(), cubed_quality(tets[i].volume_at(step), tets[i].squares_at(step)));
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
