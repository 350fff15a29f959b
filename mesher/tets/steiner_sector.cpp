// Fillings of a sector of the ball of a point that leaves the surface.
#include <algorithm>
#include <cmath>

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

// A point deep below all planes. The old place lies in some of them and below the others, so that a short way along
// the normals of the former leads below all; a search along the axes goes on from there.
std::optional<Vec3> find_deep_point(const LocalMesh& mesh, const Sector& sector, const Vec3& start) {
  const std::vector<Plane> planes = planes_of(mesh, sector);
  double radius = 0;
  for (const TriangleVerts& f : sector.faces) radius = std::max(radius, distance(start, mesh.point(f[0])));
  Vec3 direction;
  for (const Plane& plane : planes) {
    if (dot(plane.normal, start - plane.point) < 1e-9 * radius) direction += plane.normal;
  }
  direction = normalized(direction);
  Vec3 best = start;
  double depth = -HUGE_VAL;
  for (double step = radius / 2; step > 1e-8 * radius; step /= 2) {
    const Vec3 p = start + step * direction;
    if (const double d = depth_at(planes, p); d > depth) depth = d, best = p;
  }
  if (!(depth > 0)) return std::nullopt;
  for (double step = radius / 4; step > radius / 1000; step /= 2) {
    for (int k = 0; k < 6; ++k) {
      Vec3 p = best;
      p[k / 2] += k % 2 == 0 ? step : -step;
      if (const double d = depth_at(planes, p); d > depth) depth = d, best = p;
    }
  }
  return best;
}

struct LocalSector {
  SmallPolyhedron shape;
  std::vector<std::uint32_t> to_vert;
};

LocalSector make_local(const LocalMesh& mesh, const Sector& sector) {
  LocalSector local;
  for (const TriangleVerts& f : sector.faces) local.to_vert.insert(local.to_vert.end(), f.begin(), f.end());
  std::sort(local.to_vert.begin(), local.to_vert.end());
  local.to_vert.erase(std::unique(local.to_vert.begin(), local.to_vert.end()), local.to_vert.end());
  if (local.to_vert.size() > 63) return local;
  const auto id = [&](std::uint32_t v) {
    return static_cast<std::uint8_t>(std::lower_bound(local.to_vert.begin(), local.to_vert.end(), v) -
                                     local.to_vert.begin());
  };
  for (const std::uint32_t v : local.to_vert) local.shape.points.push_back(mesh.point(v));
  for (const TriangleVerts& f : sector.faces) local.shape.faces.push_back({id(f[0]), id(f[1]), id(f[2])});
  return local;
}

std::optional<std::vector<Tet>> search(const LocalSector& local, std::uint64_t steps) {
  if (local.shape.faces.empty()) return std::nullopt;
  const SmallFilling filling = fill_small_polyhedron(local.shape, steps);
  if (filling.outcome != SmallFilling::Found) return std::nullopt;
  std::vector<Tet> tets;
  for (const auto& t : filling.tets)
    tets.push_back({local.to_vert[t[0]], local.to_vert[t[1]], local.to_vert[t[2]], local.to_vert[t[3]]});
  return tets;
}

}  // namespace

std::optional<std::vector<Tet>> fill_sector(LocalMesh& mesh, const Sector& sector, std::uint32_t point,
                                            const RecoverOptions& options) {
  LocalSector local = make_local(mesh, sector);
  if (auto tets = search(local, options.search_steps)) return tets;
  const std::optional<Vec3> inside = find_deep_point(mesh, sector, mesh.point(point));
  if (!inside) return std::nullopt;
  const bool sees_all = std::all_of(sector.faces.begin(), sector.faces.end(), [&](const TriangleVerts& f) {
    return orient3d(mesh.point(f[0]), mesh.point(f[1]), mesh.point(f[2]), *inside) > 0;
  });
  if (!sees_all) return std::nullopt;
  const std::uint32_t fresh = mesh.add_point(*inside);
  std::vector<Tet> tets;
  for (const TriangleVerts& f : sector.faces) tets.push_back({f[0], f[1], f[2], fresh});
  return tets;
}

}  // namespace tetloom::tets
