#pragma once
// The shell of a part: the Delaunay tetrahedralisation of what the part knows of its points, and those tets of it that
// are the part's own.
//
// A tet is a part's own when its vertex of the lowest key is. Tets inside the surface have circumspheres of about a
// size, so that most reach nowhere but where the part knows all points: they are tets of the Delaunay
// tetrahedralisation of all points. Of the others, the parts that their balls reach are asked; what they answer is
// inserted too.
#include <span>
#include <vector>

#include "mesher/parts/part_state.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// A point of the shell that a part has not known.
struct ShellPoint {
  Vec3 point;
  VertKey key = 0;
  std::uint32_t has_pure = 0;
};

/// Whether holds(lattice, site) does for any of the pure sites next to an own point of the shell.
template <class Predicate>
bool any_pure_around(const PartShell& shell, std::uint32_t vert, Predicate&& holds) {
  std::size_t l = 0;
  while (vert >= shell.core.level_to_vert[l + 1]) ++l;
  const lattice::LevelPoints& level = shell.levels[l];
  const lattice::Site& site = level.sites[vert - shell.core.level_to_vert[l]];
  const auto& around = level.lattice.shape().around(level.lattice.shape().kind_of(site));
  for (std::size_t i = 0; i < around.size(); ++i) {
    if (!(shell.pure_around[vert] >> i & 1)) continue;
    if (holds(level.lattice, {site.i + around[i].i, site.j + around[i].j, site.k + around[i].k})) return true;
  }
  return false;
}

/// Calls visit(vertex) for the part's own points of the shell, those of the surface first; both ascend.
template <class Visit>
void for_each_own_vert(const SharedInput& input, const PartShell& shell, PartId part, Visit&& visit) {
  for (std::uint32_t v = 0; v < shell.surface_count(); ++v)
    if (input.surface.owner_of(shell.surface[v]) == part) visit(v);
  for (const std::uint32_t v : shell.core.shell_verts) visit(v);
}

/// A vertex of the shell as other parts are told of it.
inline ShellPoint shell_point(const PartShell& shell, std::uint32_t vert) {
  return {shell.mesh.points[vert], shell.keys[vert], shell.pure_around[vert] != 0};
}

/// Makes the shell anew from its `verts`: kept tets, open balls, missing triangles. The fault: points coincide.
tets::Fault make_shell(const SharedInput& input, PartShell& shell, PartId part, const TaskRunner& runner);

/// Adds points that the part does not know yet; whether there were any.
bool add_shell_points(const SharedInput& input, PartShell& shell, std::span<const ShellPoint> points);

/// What core and shell have become.
struct JoinedShell {
  PartTets tets;
  std::vector<tets::FaceCode> open_faces;     ///< of the core, that are open still
  std::size_t core_tets = 0, shell_tets = 0;  ///< the core's first
  std::size_t seen_sides = 0;                 ///< of surface triangles
};

/// Appends the kept tets of the shell to the core; all that only making them has needed goes. `removed`: tets of any
/// part's shell that are no more, ascending.
JoinedShell append_shell(const SharedInput& input, PartShell&& shell, std::span<const TetKeys> removed);

/// Names the region of every tet where there are several: what hangs together is in that around one of its tets. The
/// fault: a tet lies in none.
tets::Fault name_regions(const SharedInput& input, tets::TetMesh& mesh);

}  // namespace tetloom::parts
