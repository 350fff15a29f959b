#include "mesher/volume/filling.hpp"

#include "core/base/stopwatch.hpp"
#include "core/predicates/predicates.hpp"

namespace tetloom::volume {

namespace {

using tets::TetMesh;

// Growth of the size per unit of distance from which on the optimiser works twice as hard.
constexpr double kStrongGradation = 0.1;

void optimise(FilledMesh& filled, const FillingInput& input, const TaskRunner& runner) {
  Stopwatch watch;
  FillingFigures& figures = filled.figures;
  tets::OptimizeOptions options;
  options.fixed_points = static_cast<std::uint32_t>(input.complex.points.size());
  options.goals = input.goals;
  options.strong_gradation = input.sizes.gradation() > kStrongGradation;
  figures.optimizer = optimize(filled.mesh, options, runner);
  figures.seconds.optimize += watch.lap();
  if (!input.freedom) return;
  filled.tri_to_vert =
      improve(filled.mesh, {input.complex, input.tree, *input.freedom, options}, figures.optimizer, runner);
  figures.seconds.surface += watch.lap();
}

// By construction there are none; but what is promised is looked at.
tets::Fault check_volumes(const TetMesh& mesh) {
  for (std::uint32_t t = 0; t < mesh.size(); ++t) {
    const Vec3 &a = mesh.point_of(t, 0), &b = mesh.point_of(t, 1), &c = mesh.point_of(t, 2), &d = mesh.point_of(t, 3);
    if (orient3d(a, b, c, d) <= 0) return {"a tetrahedron has no volume", {}, a};
  }
  return {};
}

}  // namespace

void finish_filling(FilledMesh& filled, const FillingInput& input, const TaskRunner& runner) {
  optimise(filled, input, runner);
  filled.fault = check_volumes(filled.mesh);
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
