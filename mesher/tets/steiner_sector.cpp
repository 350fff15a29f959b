// Fillings of a sector of the ball of a point that leaves the surface.
#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/lists.hpp"
#include "core/predicates/predicates.hpp"
#include "mesher/tets/steiner.hpp"

namespace tetloom::tets {

namespace {

struct Plane {
  Vec3 point, normal;  // inwards, of unit length
};

std::vector<Plane> planes_of(const LocalMesh& mesh, const Sector& sector) {
  std::vector<Plane> planes;
  for (const TriangleVerts& f : sector.faces) {
    const Vec3 a = mesh.point(f[0]);
    planes.push_back({a, normalized(cross(mesh.point(f[1]) - a, mesh.point(f[2]) - a))});
  }
  return planes;
}

double depth_at(const std::vector<Plane>& planes, const Vec3& p) {
  double depth = HUGE_VAL;
  for (const Plane& plane : planes) depth = std::min(depth, dot(plane.normal, p - plane.point));
  return depth;
}

// The direction that leads below all of these planes alike; none where there is no such. The point nearest to the
// origin of the hull of the normals, step by step towards the normal that it looks along least (Gilbert 1966).
Vec3 direction_below(const std::vector<Vec3>& normals) {
  constexpr int kSteps = 100;
  if (normals.empty()) return {};
  Vec3 d = normals[0];
  for (int step = 0; step < kSteps; ++step) {
    const Vec3& least = *std::ranges::min_element(normals, {}, [&](const Vec3& n) { return dot(n, d); });
    const Vec3 way = least - d;
    if (way == Vec3{}) break;
    d += std::clamp(-dot(d, way) / norm2(way), 0.0, 1.0) * way;
  }
  return normalized(d);
}

// The old place lies in some planes and below the others, so that a short way to below the former leads below all. How
// near is in a plane is tried: beside needles all planes are near.
std::optional<Vec3> find_point_below(const std::vector<Plane>& planes, const Vec3& start, double radius) {
  for (const double near : {1e-9, 1e-12, 1e-15}) {
    std::vector<Vec3> normals;
    for (const Plane& plane : planes) {
      if (dot(plane.normal, start - plane.point) < near * radius) normals.push_back(plane.normal);
    }
    const Vec3 direction = direction_below(normals);
    Vec3 best;
    double depth = 0;
    for (double step = radius / 2; step > 1e-15 * radius; step /= 2) {
      const Vec3 p = start + step * direction;
      if (const double d = depth_at(planes, p); d > depth) depth = d, best = p;
    }
    if (depth > 0) return best;
  }
  return std::nullopt;
}

// A point deep below all planes: from one below them a search along the axes.
std::optional<Vec3> find_deep_point(const LocalMesh& mesh, const Sector& sector, const Vec3& start) {
  const std::vector<Plane> planes = planes_of(mesh, sector);
  double radius = 0;
  for (const TriangleVerts& f : sector.faces) radius = std::max(radius, distance(start, mesh.point(f[0])));
  const std::optional<Vec3> below = find_point_below(planes, start, radius);
  if (!below) return std::nullopt;
  Vec3 best = *below;
  double depth = depth_at(planes, best);
  for (double step = radius / 4; step > radius / 1000; step /= 2) {
    for (int k = 0; k < 6; ++k) {
      Vec3 p = best;
      p[k / 2] += k % 2 == 0 ? step : -step;
      if (const double d = depth_at(planes, p); d > depth) depth = d, best = p;
    }
  }
  // Off the planes of symmetry: other triangles may be still to come there.
  return best + 0.1 * depth * Vec3{0.37, -0.61, 0.53};
}

// `free_points` are those inside.
std::optional<std::vector<Tet>> search(const LocalMesh& mesh, const Sector& sector,
                                       std::span<const std::uint32_t> free_points, std::uint64_t steps) {
  std::vector<std::uint32_t> to_vert(free_points.begin(), free_points.end());
  for (const TriangleVerts& f : sector.faces) to_vert.insert(to_vert.end(), f.begin(), f.end());
  sort_unique(to_vert);
  if (to_vert.size() > 64) return std::nullopt;
  const auto id = [&](std::uint32_t v) {
    return static_cast<std::uint8_t>(std::lower_bound(to_vert.begin(), to_vert.end(), v) - to_vert.begin());
  };
  SmallPolyhedron shape;
  for (const std::uint32_t v : to_vert) shape.points.push_back(mesh.point(v));
  for (const TriangleVerts& f : sector.faces) shape.faces.push_back({id(f[0]), id(f[1]), id(f[2])});
  const SmallFilling filling = fill_small_polyhedron(shape, steps);
  if (filling.outcome != SmallFilling::Found) return std::nullopt;
  std::vector<Tet> tets;
  for (const auto& t : filling.tets) tets.push_back({to_vert[t[0]], to_vert[t[1]], to_vert[t[2]], to_vert[t[3]]});
  return tets;
}

std::optional<std::vector<Tet>> fill_star(LocalMesh& mesh, const Sector& sector, const Vec3& start) {
  const std::optional<Vec3> inside = find_deep_point(mesh, sector, start);
  if (!inside) return std::nullopt;
  for (const TriangleVerts& f : sector.faces) {
    if (orient3d(mesh.point(f[0]), mesh.point(f[1]), mesh.point(f[2]), *inside) <= 0) return std::nullopt;
  }
  const std::uint32_t fresh = mesh.add_point(*inside);
  std::vector<Tet> tets;
  for (const TriangleVerts& f : sector.faces) tets.push_back({f[0], f[1], f[2], fresh});
  return tets;
}

// A piece with nothing else at its edge is a slit in the ball: points above, below and beyond it.
//
//            above
//     z ------x  beyond       the slit ends at the edge xy, seen from its end
//            below
std::optional<std::vector<Tet>> fill_slit(LocalMesh& mesh, const Sector& sector, const Vec3& start,
                                          const RecoverOptions& options) {
  const TriangleVerts piece = sector.faces.back();
  const Vec3 a = mesh.point(piece[0]), b = mesh.point(piece[1]), c = mesh.point(piece[2]);
  const Vec3 normal = normalized(cross(b - a, c - a)), beyond = normalized(start - (a + b + c) / 3);
  double radius = HUGE_VAL;
  for (const TriangleVerts& f : sector.faces) radius = std::min(radius, distance(start, mesh.point(f[0])));
  for (const double step : {0.3 * radius, 0.1 * radius, 0.02 * radius}) {
    const std::array<std::uint32_t, 3> free{mesh.add_point(start + step * beyond),
                                            mesh.add_point(start + step * normal),
                                            mesh.add_point(start - step * normal)};
    for (const std::size_t count : {1, 3}) {
      if (auto tets = search(mesh, sector, std::span(free).first(count), options.search_steps / 4)) return tets;
    }
    if (auto tets = search(mesh, sector, std::span(free).last(2), options.search_steps / 4)) return tets;
  }
  return std::nullopt;
}

}  // namespace

std::optional<std::vector<Tet>> fill_sector(LocalMesh& mesh, const Sector& sector, std::uint32_t point,
                                            const RecoverOptions& options) {
  if (auto tets = search(mesh, sector, {}, options.search_steps / 4)) return tets;
  const Vec3 start = mesh.point(point);
  if (auto tets = fill_star(mesh, sector, start)) return tets;
  return sector.faces.size() > 2 ? fill_slit(mesh, sector, start, options) : std::nullopt;
}

}  // namespace tetloom::tets
