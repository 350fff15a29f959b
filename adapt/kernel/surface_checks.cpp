// Whether an operation leaves the surface as it has to be.
#include <algorithm>
#include <cmath>

#include "adapt/kernel/passes.hpp"
#include "core/base/lists.hpp"

namespace tetloom::adapt {

namespace {

using tets::verts_of;

// Least cosines between the normals of a triangle and of what comes in its place, without a model to follow and with.
constexpr double kFlat = 1 - 1e-10, kFold = 0.9;

Vec3 normal_of(const CavityMesh& mesh, const Triangle& t) {
  return normalized(cross(mesh.point(t[1]) - mesh.point(t[0]), mesh.point(t[2]) - mesh.point(t[0])));
}

}  // namespace

bool Passes::is_frozen(const Cavity& cavity) const {
  if (cavity.surface.empty()) return false;
  if (cavity.core_size == 2) {
    const std::uint32_t edge = mesh_.surface.find_edge(cavity.core[0], cavity.core[1]);
    if (edge != kNone && (edge & kTouching) != 0) return true;
  }
  for (std::uint32_t k = 0; k < cavity.core_size; ++k)
    if (!mesh_.to_frozen[cavity.core[k]]) return false;
  return true;
}

// Whether p may take the place of the core as far as the surface is concerned. Pre: `cavity` is cavity_.
bool Passes::keeps_surface(const Cavity& cavity, std::uint32_t p) {
  return cavity.surface.empty() || (is_flat_enough(cavity, p) && mesh_.is_sound(cavity, p) && !pinches(p));
}

// Whether the triangles that have the core would neither fold nor, where there is no model to follow, leave their
// plane.
bool Passes::is_flat_enough(const Cavity& cavity, std::uint32_t p) const {
  const double least = project_ ? kFold : kFlat;
  for (const FaceCode face : cavity.surface) {
    const Triangle old = verts_of(mesh_.mesh, face);
    if (has(old, p)) continue;
    const Vec3 normal = normal_of(mesh_, old);
    for (std::uint32_t k = 0; k < cavity.core_size; ++k) {
      Triangle made = old;
      std::replace(made.begin(), made.end(), cavity.core[k], p);
      if (!(dot(normal_of(mesh_, made), normal) > least)) return false;
    }
  }
  return true;
}

std::vector<Vec3> Passes::normals_of(const Cavity& cavity) const {
  std::vector<Vec3> normals;
  for (const FaceCode face : cavity.surface) normals.push_back(normal_of(mesh_, verts_of(mesh_.mesh, face)));
  return normals;
}

// The same for triangles whose vertex has moved, with their normals from before. Those that are about to vanish are
// asked as well, which does no harm.
bool Passes::turns_no_normal(const Cavity& cavity, const std::vector<Vec3>& normals) const {
  const double least = project_ ? kFold : kFlat;
  for (std::size_t i = 0; i < normals.size(); ++i)
    if (!(dot(normal_of(mesh_, verts_of(mesh_.mesh, cavity.surface[i])), normals[i]) > least)) return false;
  return true;
}

// Whether the triangles of the cavity lie in one plane for each model face.
bool Passes::lies_in_planes(const Cavity& cavity) const {
  for (std::size_t i = 0; i < cavity.surface.size(); ++i) {
    const SurfaceTriangle* one = mesh_.surface.find(verts_of(mesh_.mesh, cavity.surface[i]));
    for (std::size_t j = 0; j < i; ++j) {
      const SurfaceTriangle* other = mesh_.surface.find(verts_of(mesh_.mesh, cavity.surface[j]));
      if (one->face == other->face && !(dot(normal_of(mesh_, one->verts), normal_of(mesh_, other->verts)) > kFlat))
        return false;
    }
  }
  return true;
}

// Whether an edge from p would be on the surface twice, or may be, where other parts have both of its ends. Pre:
// cavity_ is that of the core. Uses scratch_.
bool Passes::pinches(std::uint32_t p) {
  std::vector<std::uint32_t> near, beside;
  for (const FaceCode face : cavity_.surface) {
    const Triangle verts = verts_of(mesh_.mesh, face);
    for (const std::uint32_t v : verts)
      if (v != p && !cavity_.is_core(v)) (has(verts, p) ? beside : near).push_back(v);
  }
  std::erase_if(near, [&](std::uint32_t v) { return std::find(beside.begin(), beside.end(), v) != beside.end(); });
  if (mesh_.to_frozen[p] == 0) return has_surface_edge(p, near);
  if (std::ranges::any_of(near, [&](std::uint32_t v) { return mesh_.to_frozen[v] != 0; })) return true;
  // The part has all tets of the others.
  return std::ranges::any_of(near, [&](std::uint32_t v) { return has_surface_edge(v, std::span(&p, 1)); });
}

// Whether v has an edge of the surface to one of `ends`, beside triangles with the core. Pre: the part has all tets of
// v. Uses scratch_.
bool Passes::has_surface_edge(std::uint32_t v, std::span<const std::uint32_t> ends) {
  if (!mesh_.collect(std::span(&v, 1), mesh_.vert_to_tet[v], scratch_)) return true;
  for (const FaceCode face : scratch_.surface) {
    const Triangle verts = verts_of(mesh_.mesh, face);
    if (std::any_of(verts.begin(), verts.end(), [&](std::uint32_t u) { return cavity_.is_core(u); })) continue;
    for (const std::uint32_t u : verts)
      if (u != v && std::find(ends.begin(), ends.end(), u) != ends.end()) return true;
  }
  return false;
}

// Takes from a step what would leave the faces at a vertex. False: it must stay. Pre: cavity_ is its ball.
bool Passes::keep_on_face(Vec3& step) const {
  Vec3 normal;
  for (const FaceCode face : cavity_.surface) {
    const Vec3 one = normal_of(mesh_, mesh_.surface.find(verts_of(mesh_.mesh, face))->verts);
    if (!project_ && normal != Vec3{} && !(dot(one, normalized(normal)) > kFlat)) return false;
    normal += one;
  }
  normal = normalized(normal);
  step -= dot(step, normal) * normal;
  return true;
}

// The same for a vertex of a model edge.
bool Passes::keep_on_edge(std::uint32_t v, Vec3& step) const {
  std::array<Vec3, 2> ends;
  std::array<std::uint32_t, 2> verts{kNone, kNone};
  int found = 0;
  for (const FaceCode face : cavity_.surface) {
    for (const std::uint32_t u : verts_of(mesh_.mesh, face)) {
      if (found == 2 || u == v || u == verts[0] || mesh_.surface.find_edge(u, v) == kNone) continue;
      verts[static_cast<std::size_t>(found)] = u;
      ends[static_cast<std::size_t>(found++)] = mesh_.point(u);
    }
  }
  if (found != 2) return false;
  const Vec3 along = normalized(ends[1] - ends[0]), x = mesh_.point(v);
  const bool bends = dot(normalized(x - ends[0]), normalized(ends[1] - x)) < kFlat;
  if (!project_ && (bends || !lies_in_planes(cavity_))) return false;
  step = dot(step, along) * along;
  return true;
}

bool Passes::keep_on_entity(std::uint32_t v, Vec3& step) const {
  const int dim = mesh_.dim_of(v);
  if (dim == 3) return true;
  if (cavity_.surface.empty()) return false;
  return dim == 2 ? keep_on_face(step) : keep_on_edge(v, step);
}

}  // namespace tetloom::adapt
