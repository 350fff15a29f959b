#include "mesher/volume/lattice_filling.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "core/base/stopwatch.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/lattice/lattice_core.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/recovery.hpp"
#include "mesher/tets/shell.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

namespace {

using tets::Fault;
using tets::TetMesh;

class LatticeFiller {
 public:
  LatticeFiller(const FillingInput& input, const TaskRunner& runner)
      : input_(input), complex_(input.complex), runner_(runner) {}

  FilledMesh run() {
    FilledMesh filled;
    TetMesh& mesh = filled.mesh;
    mesh.points = GrowingArray<Vec3>(std::span(complex_.points));
    const lattice::LatticeCore core = make_core(mesh);
    filled.fault = make_shell(mesh, core);
    if (!filled.fault.any()) filled.fault = join(mesh, core);
    filled.figures = figures_;
    if (!filled.fault.any()) finish_filling(filled, input_, runner_);
    return filled;
  }

 private:
  lattice::LatticeCore make_core(TetMesh& mesh) {
    lattice::LatticeRequest request{&input_.tree,  complex_.tri_to_sides,  {},
                                    &input_.sizes, input_.options.lattice, input_.attempt};
    for (const Vec3& x : complex_.points) request.box.add(x);
    const std::vector<lattice::LevelPoints> levels = make_lattice_points(request, runner_);
    figures_.seconds.points = watch_.lap();
    input_.progress.reach(FillingStep::Points, runner_);
    lattice::LatticeCore core = emit_core(mesh, levels, runner_);
    figures_.core_tets = mesh.size();
    figures_.seconds.core = watch_.lap();
    input_.progress.reach(FillingStep::Core, runner_);
    return core;
  }

  Fault make_shell(TetMesh& mesh, const lattice::LatticeCore& core) {
    std::vector<std::uint32_t> verts(complex_.points.size());
    std::iota(verts.begin(), verts.end(), 0u);
    verts.insert(verts.end(), core.shell_verts.begin(), core.shell_verts.end());
    shell_.points = std::move(mesh.points);
    const tets::DelaunayResult delaunay = make_delaunay(shell_, verts, runner_);
    figures_.seconds.delaunay = watch_.lap();
    input_.progress.reach(FillingStep::Delaunay, runner_);
    if (!delaunay.duplicates.empty()) return coinciding(delaunay.duplicates);
    if (const std::size_t missing = fix_core_faces(shell_, mesh, core.open_faces); missing > 0)
      return {std::to_string(missing) + " faces of the lattice core are not in the shell", {}, shell_.points[0]};
    Fault fault = recover();
    figures_.seconds.recovery = watch_.lap();
    input_.progress.reach(FillingStep::Recovery, runner_);
    return fault;
  }

  // Lattice points keep their distance from the surface and from each other: these are its own.
  Fault coinciding(std::span<const tets::Duplicate> duplicates) const {
    Fault fault{std::to_string(duplicates.size()) + " points of its surface coincide with others of it", {}, {}};
    fault.code = ErrorCode::SelfIntersection;
    fault.point = shell_.points[duplicates[0].vert];
    for (std::uint32_t t = 0; t < complex_.tri_to_vert.size(); ++t) {
      const auto& verts = complex_.tri_to_vert[t];
      const auto is_there = [&](std::uint32_t v) { return shell_.points[v] == fault.point; };
      if (std::any_of(verts.begin(), verts.end(), is_there)) fault.triangles.push_back(t);
    }
    return fault;
  }

  Fault recover() {
    tets::RecoverOptions options = tets::recover_options(input_.progress.whole(), input_.attempt);
    options.is_in_vain = [&] {
      return !find_self_intersections({complex_.points, complex_.tri_to_vert, {}, 1}, runner_).empty();
    };
    const tets::RecoveryReport report = recover_boundary(shell_, complex_.tri_to_vert, options, runner_);
    figures_.missing_triangles = report.missing_triangles;
    figures_.recovery_points = report.new_points;
    Fault fault;
    if (report.unrecovered.empty()) return fault;
    for (const tets::UnrecoveredTriangle& lost : report.unrecovered) fault.triangles.push_back(lost.triangle);
    fault.message =
        std::to_string(report.unrecovered.size()) + " surface triangles could not be made faces of the mesh";
    fault.point = report.unrecovered[0].point;
    return fault;
  }

  Fault join(TetMesh& mesh, const lattice::LatticeCore& core) {
    const tets::Surface surface{complex_.tri_to_vert, complex_.tri_to_sides};
    Fault fault = join_shell(mesh, std::move(shell_), core.open_faces, surface, runner_);
    figures_.shell_tets = mesh.size() - figures_.core_tets;
    figures_.seconds.join = watch_.lap();
    input_.progress.reach(FillingStep::Join, runner_);
    return fault;
  }

  const FillingInput& input_;
  const Complex& complex_;
  const TaskRunner& runner_;
  TetMesh shell_;
  FillingFigures figures_;
  Stopwatch watch_;
};

}  // namespace

FilledMesh fill_by_lattice(const FillingInput& input, const TaskRunner& runner) {
  return LatticeFiller(input, runner).run();
}

}  // namespace tetloom::volume
