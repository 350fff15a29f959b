// Points where an obstacle crosses an edge or a triangle of the surface.
#include <algorithm>
#include <cmath>

#include "core/predicates/predicates.hpp"
#include "mesher/tets/steiner.hpp"

namespace tetloom::tets {

namespace {

constexpr std::size_t kTrials = 12;
constexpr double kCentral = 1e-3;  // least share of a triangle that a point inside may give to a third of it

// A face or an edge (third vertex kNone) that may be split at a point; the smaller `rank` the better.
struct Crossing {
  double rank;
  TriangleVerts verts;
  Vec3 point;

  bool operator<(const Crossing& b) const { return rank != b.rank ? rank < b.rank : verts < b.verts; }
};

bool is_positive(const LocalMesh& mesh, const Tet& t, std::uint32_t v, const Vec3& p) {
  const auto at = [&](std::size_t i) -> const Vec3& { return t[i] == v ? p : mesh.point(t[i]); };
  return orient3d(at(0), at(1), at(2), at(3)) > 0;
}

// Each tet is divided by a point on the simplex `verts`, which all of them have.
bool split(LocalMesh& mesh, const TetList& tets, const TriangleVerts& verts, const Vec3& p) {
  const bool is_face = verts[2] != kNone;
  for (const std::uint32_t t : tets) {
    const Tet v = mesh.tet(t);
    for (std::uint32_t k = 0; k < 4; ++k) {
      const bool in_simplex = std::find(verts.begin(), verts.end(), v[k]) != verts.end();
      if (in_simplex && !is_positive(mesh, v, v[k], p)) return false;
      // The faces that hold the simplex are divided.
      if (!is_face && !in_simplex && mesh.mesh().is_fixed({t, k})) return false;
      if (is_face && !in_simplex && mesh.mesh().is_fixed({t, k})) return false;
    }
  }
  const std::uint32_t point = mesh.add_point(p);
  std::vector<Tet> fresh;
  for (const std::uint32_t t : tets) {
    for (const std::uint32_t v : verts) {
      if (v == kNone) continue;
      fresh.push_back(mesh.tet(t));
      *std::find(fresh.back().begin(), fresh.back().end(), v) = point;
    }
  }
  mesh.replace(tets, fresh);
  return true;
}

bool split(LocalMesh& mesh, const EdgeSet& kept, const Crossing& crossing) {
  const auto& [a, b, c] = crossing.verts;
  if (c == kNone) return !kept.contains(a, b) && split(mesh, mesh.find_shell(a, b), crossing.verts, crossing.point);
  const FaceCode code = mesh.find_face(crossing.verts);
  if (!code.valid() || !mesh.mesh().behind(code).valid()) return false;
  return split(mesh, {code.tet(), mesh.mesh().behind(code).tet()}, crossing.verts, crossing.point);
}

std::uint32_t split_best(LocalMesh& mesh, const EdgeSet& kept, std::vector<Crossing>& crossings) {
  std::sort(crossings.begin(), crossings.end());
  crossings.erase(std::unique(crossings.begin(), crossings.end(),
                              [](const Crossing& x, const Crossing& y) { return x.verts == y.verts; }),
                  crossings.end());
  for (std::size_t i = 0; i < std::min(crossings.size(), kTrials); ++i) {
    if (split(mesh, kept, crossings[i])) return static_cast<std::uint32_t>(mesh.mesh().points.size() - 1);
  }
  return kNone;
}

double signed_volume(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  return dot(cross(b - a, c - a), d - a);
}

// Where the segment ab is hit by the line of the edge pq, seen as nearly as rounding allows; rank by how central.
void add_edge_crossing(const LocalMesh& mesh, const Vec3& a, const Vec3& b, std::uint32_t p, std::uint32_t q,
                       std::vector<Crossing>& crossings) {
  const Vec3 u = b - a, v = mesh.point(q) - mesh.point(p), w = mesh.point(p) - a;
  const Vec3 normal = cross(u, v);
  const double s = dot(cross(w, v), normal) / norm2(normal), t = dot(cross(w, u), normal) / norm2(normal);
  if (!(s > 0 && s < 1 && t > 0 && t < 1)) return;
  crossings.push_back({std::abs(s - 0.5), {std::min(p, q), std::max(p, q), kNone}, mesh.point(p) + t * v});
}

}  // namespace

std::uint32_t split_obstacle(LocalMesh& mesh, const EdgeSet& kept, std::uint32_t a, std::uint32_t b,
                             const TetList& obstacles) {
  const Vec3 pa = mesh.point(a), pb = mesh.point(b);
  std::vector<Crossing> crossings;
  for (const std::uint32_t t : obstacles) {
    for (std::uint32_t k = 0; k < 4; ++k) {
      const TriangleVerts f = sorted(mesh.face({t, k})).verts;
      if (std::find(f.begin(), f.end(), a) != f.end() || std::find(f.begin(), f.end(), b) != f.end()) continue;
      if (!meets(mesh, a, b, f)) continue;
      bool on_edge = false;
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t p = f[i], q = f[(i + 1) % 3];
        if (orient3d(pa, pb, mesh.point(p), mesh.point(q)) != 0) continue;
        on_edge = true;
        add_edge_crossing(mesh, pa, pb, p, q, crossings);
      }
      if (on_edge) continue;
      const double above = signed_volume(mesh.point(f[0]), mesh.point(f[1]), mesh.point(f[2]), pa);
      const double below = signed_volume(mesh.point(f[0]), mesh.point(f[1]), mesh.point(f[2]), pb);
      const double s = above / (above - below);
      if (s > 0 && s < 1) crossings.push_back({std::abs(s - 0.5), f, pa + s * (pb - pa)});
    }
  }
  return split_best(mesh, kept, crossings);
}

std::uint32_t split_obstacle(LocalMesh& mesh, const EdgeSet& kept, const TriangleVerts& triangle,
                             const TetList& obstacles) {
  const Vec3 a = mesh.point(triangle[0]), b = mesh.point(triangle[1]), c = mesh.point(triangle[2]);
  const Vec3 normal = cross(b - a, c - a);
  std::vector<Crossing> crossings;
  for (const std::uint32_t t : obstacles) {
    const Tet v = mesh.tet(t);
    for (std::size_t i = 0; i < 4; ++i) {
      for (std::size_t j = i + 1; j < 4; ++j) {
        const std::uint32_t p = std::min(v[i], v[j]), q = std::max(v[i], v[j]);
        if (!meets(mesh, p, q, triangle)) continue;
        const double above = dot(normal, mesh.point(p) - a), below = dot(normal, mesh.point(q) - a);
        const double s = above / (above - below);
        if (!(s > 0 && s < 1)) continue;
        const Vec3 x = mesh.point(p) + s * (mesh.point(q) - mesh.point(p));
        const double central = std::min(
            {dot(cross(b - a, x - a), normal), dot(cross(c - b, x - b), normal), dot(cross(a - c, x - c), normal)});
        if (central > kCentral * norm2(normal)) crossings.push_back({-central / norm2(normal), {p, q, kNone}, x});
      }
    }
  }
  return split_best(mesh, kept, crossings);
}

}  // namespace tetloom::tets
