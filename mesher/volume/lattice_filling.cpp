#include "mesher/volume/lattice_filling.hpp"

#include <numeric>
#include <utility>

#include "core/base/stopwatch.hpp"
#include "core/predicates/predicates.hpp"
#include "mesher/lattice/lattice_core.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/recovery.hpp"
#include "mesher/tets/shell.hpp"

namespace tetloom::volume {

namespace {

using tets::Fault;
using tets::TetMesh;

// Growth of the size per unit of distance from which on the optimiser works twice as hard.
constexpr double kStrongGradation = 0.1;

class LatticeFiller {
 public:
  LatticeFiller(const LatticeInput& input, const TaskRunner& runner)
      : complex_(input.complex), tree_(input.tree), sizes_(input.sizes), freedom_(input.freedom), runner_(runner) {}

  LatticeFilling run() {
    LatticeFilling filling;
    TetMesh& mesh = filling.mesh;
    mesh.points = GrowingArray<Vec3>(std::span(complex_.points));
    const lattice::LatticeCore core = make_core(mesh);
    Fault fault = make_shell(mesh, core);
    if (!fault.any()) fault = join(mesh, core);
    if (!fault.any()) optimise(mesh, filling);
    if (!fault.any()) fault = check_volumes(mesh);
    filling.verdict = {std::move(fault.message), std::move(fault.triangles), fault.point};
    filling.figures = figures_;
    return filling;
  }

 private:
  lattice::LatticeCore make_core(TetMesh& mesh) {
    lattice::LatticeRequest request{&tree_, complex_.tri_to_sides, {}, &sizes_};
    for (const Vec3& x : complex_.points) request.box.add(x);
    const std::vector<lattice::LevelPoints> levels = make_lattice_points(request, runner_);
    figures_.seconds.points = watch_.lap();
    lattice::LatticeCore core = emit_core(mesh, levels);
    figures_.core_tets = mesh.size();
    figures_.seconds.core = watch_.lap();
    return core;
  }

  Fault make_shell(TetMesh& mesh, const lattice::LatticeCore& core) {
    std::vector<std::uint32_t> verts(complex_.points.size());
    std::iota(verts.begin(), verts.end(), 0u);
    verts.insert(verts.end(), core.shell_verts.begin(), core.shell_verts.end());
    shell_.points = std::move(mesh.points);
    const tets::DelaunayResult delaunay = make_delaunay(shell_, verts, runner_);
    figures_.seconds.delaunay = watch_.lap();
    if (!delaunay.duplicates.empty())
      return {"two points of the surface coincide", {}, complex_.points[delaunay.duplicates[0].vert]};
    if (const std::size_t missing = fix_core_faces(shell_, mesh, core.open_faces); missing > 0)
      return {std::to_string(missing) + " faces of the lattice core are not in the shell", {}, shell_.points[0]};
    Fault fault = recover();
    figures_.seconds.recovery = watch_.lap();
    return fault;
  }

  Fault recover() {
    const tets::RecoveryReport report = recover_boundary(shell_, complex_.tri_to_vert, {}, runner_);
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
    Fault fault = join_shell(mesh, std::move(shell_), core.open_faces, surface);
    figures_.shell_tets = mesh.size() - figures_.core_tets;
    figures_.seconds.join = watch_.lap();
    return fault;
  }

  void optimise(TetMesh& mesh, LatticeFilling& filling) {
    tets::OptimizeOptions options;
    options.fixed_points = static_cast<std::uint32_t>(complex_.points.size());
    options.strong_gradation = sizes_.gradation() > kStrongGradation;
    figures_.optimizer = optimize(mesh, options, runner_);
    figures_.seconds.optimize = watch_.lap();
    if (!freedom_) return;
    filling.tri_to_vert = improve(mesh, {complex_, tree_, *freedom_, options}, figures_.optimizer, runner_);
    figures_.seconds.surface = watch_.lap();
  }

  // By construction there are none; but what is promised is looked at.
  static Fault check_volumes(const TetMesh& mesh) {
    for (std::uint32_t t = 0; t < mesh.size(); ++t) {
      const Vec3 &a = mesh.point_of(t, 0), &b = mesh.point_of(t, 1), &c = mesh.point_of(t, 2), &d = mesh.point_of(t, 3);
      if (orient3d(a, b, c, d) <= 0) return {"a tetrahedron has no volume", {}, a};
    }
    return {};
  }

  const Complex& complex_;
  const intersection::TriangleTree& tree_;
  const SizeField& sizes_;
  const SurfaceFreedom* freedom_;
  const TaskRunner& runner_;
  TetMesh shell_;
  FillingFigures figures_;
  Stopwatch watch_;
};

}  // namespace

LatticeFilling fill_by_lattice(const LatticeInput& input, const TaskRunner& runner) {
  return LatticeFiller(input, runner).run();
}

Filling to_filling(TetMesh&& mesh, std::size_t given) {
  Filling filling;
  mesh.to_neighbor.release();
  mesh.to_fixed.release();
  std::vector<std::uint32_t> to_new(mesh.points.size(), tets::kNone);
  for (const std::uint32_t v : mesh.to_vert) to_new[v] = 0;
  for (std::uint32_t v = 0; v < to_new.size(); ++v) {
    if (v >= given && to_new[v] == tets::kNone) continue;
    to_new[v] = static_cast<std::uint32_t>(filling.points.size());
    filling.points.push_back(mesh.points[v]);
  }
  mesh.points.release();
  filling.tet_to_vert.resize(mesh.to_region.size());
  for (std::size_t tet = 0; tet < filling.tet_to_vert.size(); ++tet) {
    for (std::size_t i = 0; i < 4; ++i) filling.tet_to_vert[tet][i] = to_new[mesh.to_vert[tet * 4 + i]];
  }
  mesh.to_vert.release();
  filling.tet_to_region.assign(mesh.to_region.begin(), mesh.to_region.end());
  mesh.to_region.release();
  return filling;
}

}  // namespace tetloom::volume
