#include "mesher/tets/angle_search.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "core/tets/dihedral.hpp"
#include "core/tets/star_tet.hpp"
#include "mesher/tets/edge_removal.hpp"

namespace tetloom::tets {

namespace {

constexpr std::array kSteps{0.4, 0.2, 0.1, 0.05};              // of moves, in lengths of the edges beside the vertex
constexpr double kLeastInserted = 3 * std::numbers::pi / 180;  // below that an insertion is not worth a point
constexpr double kInsertionGain = 1.3;                         // of the smallest angle
// Where the search for an inserted point starts: shares of the edge, heights above the cavity's faces; and its steps.
constexpr std::array kOnEdge{0.25, 0.5, 0.75};
constexpr std::array kAboveFaces{0.05, 0.1, 0.2, 0.4};
constexpr double kFirstStep = 0.2, kLastStep = 0.01;

// Towards the faces, edges and corners of a cube.
std::array<Vec3, 26> all_around() {
  std::array<Vec3, 26> directions;
  std::size_t count = 0;
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k)
        if (i != 0 || j != 0 || k != 0)
          directions[count++] =
              normalized(Vec3{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
  return directions;
}

// The polyhedron of the tets around an edge, as faces counter-clockwise seen from inside.
struct Hollow {
  std::array<std::array<std::uint32_t, 3>, 2 * kMostRingVerts> faces;
  std::size_t count = 0;
  double size = 0;  // mean length of the faces' sides

  std::span<const std::array<std::uint32_t, 3>> list() const { return {faces.data(), count}; }
};

Hollow hollow_of(const WorkingMesh& mesh, const EdgeRing& ring) {
  Hollow hollow;
  for (int i = 0; i < ring.count; ++i) {
    const std::uint32_t r = ring.verts[static_cast<std::size_t>(i)],
                        s = ring.verts[static_cast<std::size_t>((i + 1) % ring.count)];
    hollow.faces[hollow.count++] = {r, s, ring.a};
    hollow.faces[hollow.count++] = {s, r, ring.b};
    hollow.size += distance(mesh.point(r), mesh.point(s)) / ring.count;
  }
  return hollow;
}

// The cosine of the smallest angle of the tets between the faces and a point; 2 where one of them is not surely
// positive, or of a cubed quality below `least`.
double largest_cosine_in(const WorkingMesh& mesh, const Hollow& hollow, const Vec3& x, double least) {
  double largest = -1;
  for (const auto& [a, b, c] : hollow.list()) {
    const Vec3 &p = mesh.point(a), &q = mesh.point(b), &r = mesh.point(c);
    if (!(cubed_quality(p, q, r, x) > std::max(least, kSurelyPositive))) return 2;
    largest = std::max(largest, cosine_of_smallest_dihedral(p, q, r, x));
  }
  return largest;
}

// Above the middles of the faces, near them and far, and on the line between the two ends of the edge that goes.
std::vector<Vec3> starts_in(const WorkingMesh& mesh, const EdgeRing& ring, const Hollow& hollow) {
  std::vector<Vec3> starts;
  for (const double share : kOnEdge) starts.push_back((1 - share) * mesh.point(ring.a) + share * mesh.point(ring.b));
  for (const auto& [a, b, c] : hollow.list()) {
    const Vec3 &p = mesh.point(a), &q = mesh.point(b), &r = mesh.point(c);
    const Vec3 normal = normalized(cross(q - p, r - p));
    for (const double height : kAboveFaces) starts.push_back((1.0 / 3) * (p + q + r) + height * hollow.size * normal);
  }
  return starts;
}

struct InsertionPlace {
  Vec3 x;
  double cosine = 2;
};

InsertionPlace find_place(const WorkingMesh& mesh, const EdgeRing& ring, const Hollow& hollow, double least) {
  InsertionPlace best;
  const auto try_at = [&](const Vec3& x) {
    const double cosine = largest_cosine_in(mesh, hollow, x, least);
    if (cosine < best.cosine) best = {x, cosine};
  };
  for (const Vec3& start : starts_in(mesh, ring, hollow)) try_at(start);
  const std::array<Vec3, 26> directions = all_around();
  for (double step = kFirstStep * hollow.size; best.cosine < 2 && step > kLastStep * hollow.size; step *= 0.5) {
    const Vec3 from = best.x;
    for (const Vec3& direction : directions) try_at(from + step * direction);
  }
  return best;
}

// The edge between the two faces of the angle, by its number as remove_edge_of has them.
int edge_between(const Dihedral& dihedral) {
  constexpr std::array<std::array<int, 4>, 4> kOpposite{{{-1, 5, 4, 3}, {5, -1, 2, 1}, {4, 2, -1, 0}, {3, 1, 0, -1}}};
  return kOpposite[dihedral.face][dihedral.other];
}

}  // namespace

double largest_cosine(WorkingMesh& mesh, const VertexStar& star, const Vec3& x, double enough) {
  Vec3& place = mesh.mesh().points[star.vertex];
  const Vec3 from = std::exchange(place, x);
  double largest = -1;
  for (const FaceCode code : star.tets()) {
    largest = std::max(largest, std::cos(smallest_dihedral(mesh.mesh(), code.tet()).angle));
    if (largest >= enough) break;
  }
  place = from;
  return largest;
}

Vec3 find_widest_step(WorkingMesh& mesh, const VertexStar& star, std::span<const Vec3> directions, double reach,
                      double goal, const std::function<bool(const Vec3& step)>& is_allowed) {
  const Vec3 x = mesh.point(star.vertex);
  Vec3 best;
  for (const double share : kSteps)
    for (const Vec3& direction : directions) {
      const Vec3 step = share * reach * direction;
      if (!is_allowed(step)) continue;
      const double cosine = largest_cosine(mesh, star, x + step, goal);
      if (cosine < goal) goal = cosine, best = step;
    }
  return best;
}

double cosine_to_beat(WorkingMesh& mesh, const VertexStar& star) {
  const double cosine = largest_cosine(mesh, star, mesh.point(star.vertex));
  return std::cos(kAngleGain * std::acos(std::clamp(cosine, -1.0, 1.0)));
}

bool move_for_angle(WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, double least) {
  VertexStar star;
  if (find_star(mesh, tet, corner, star) != StarVerdict::Found) return false;
  std::array<StarTet, WorkingMesh::kMostTets> room;
  const std::span<StarTet> tets = std::span(room).first(star.count);
  const Vec3 x = mesh.point(star.vertex);
  double reach = 0, least_before = 1;
  for (std::size_t i = 0; i < star.count; ++i) {
    const auto verts = mesh.verts(star.codes[i].tet());
    const auto& [a, c, b] = kFaceVerts[star.codes[i].side()];
    tets[i] = star_tet(mesh.point(verts[a]) - x, mesh.point(verts[b]) - x, mesh.point(verts[c]) - x);
    reach += distance(mesh.point(verts[a]), x) / static_cast<double>(star.count);
    least_before = std::min(least_before, cubed_quality(tets[i].volume, tets[i].squares));
  }
  least = std::max(least, kAngleQualityShare * least_before);
  const auto is_allowed = [&](const Vec3& step) {
    return std::ranges::all_of(tets, [&](const StarTet& t) {
      return t.is_surely_positive_at(step) && cubed_quality(t.volume_at(step), t.squares_at(step)) >= least;
    });
  };
  const Vec3 step = find_widest_step(mesh, star, all_around(), reach, cosine_to_beat(mesh, star), is_allowed);
  if (step == Vec3{}) return false;
  mesh.mesh().points[star.vertex] = x + step;
  for (std::size_t i = 0; i < star.count; ++i)
    mesh.set_quality(star.codes[i].tet(), cubed_quality(tets[i].volume_at(step), tets[i].squares_at(step)));
  return true;
}

bool insert_for_angle(WorkingMesh& mesh, std::uint32_t tet, double least) {
  const Dihedral dihedral = smallest_dihedral(mesh.mesh(), tet);
  EdgeRing ring;
  if (!find_any_ring(mesh, tet, edge_between(dihedral), ring)) return false;
  const Hollow hollow = hollow_of(mesh, ring);
  const InsertionPlace place = find_place(mesh, ring, hollow, least);
  double before = dihedral.angle;
  for (const std::uint32_t t : ring.old()) before = std::min(before, smallest_dihedral(mesh.mesh(), t).angle);
  if (!(place.cosine < std::cos(std::max(kInsertionGain * before, kLeastInserted)))) return false;
  const std::uint32_t vertex = mesh.add_point(place.x);
  std::array<NewTet, 2 * kMostRingVerts> made;
  for (std::size_t i = 0; i < hollow.count; ++i) {
    const auto& [a, b, c] = hollow.faces[i];
    made[i] = {{a, b, c, vertex}, cubed_quality(mesh.point(a), mesh.point(b), mesh.point(c), place.x)};
  }
  mesh.replace(ring.old(), std::span(made).first(hollow.count));
  return true;
}

}  // namespace tetloom::tets
