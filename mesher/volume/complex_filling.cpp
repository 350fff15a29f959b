#include "mesher/volume/complex_filling.hpp"

#include <algorithm>

#include "core/base/stopwatch.hpp"
#include "core/predicates/predicates.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

namespace {

using tets::TetMesh;

// Growth of the size per unit of distance from which on the optimiser spreads vertices first.
constexpr double kStrongGradation = 0.1;
constexpr std::size_t kBlock = 1 << 16;  // tets of one task

void optimise(FilledMesh& filled, const FillingInput& input, const TaskRunner& runner) {
  Stopwatch watch;
  FillingFigures& figures = filled.figures;
  tets::OptimizeOptions options = optimize_options(input);
  if (input.lattice == LatticeKind::Bcc) options.lattice_tets = static_cast<std::uint32_t>(figures.core_tets);
  figures.optimizer = optimize(filled.mesh, options, runner);
  figures.seconds.optimize += watch.lap();
  input.progress.reach(FillingStep::Optimized, runner);
  if (!input.freedom) return;
  filled.tri_to_vert =
      improve(filled.mesh, {input.complex, input.tree, *input.freedom, options}, figures.optimizer, runner);
  figures.seconds.surface += watch.lap();
  input.progress.reach(FillingStep::Improved, runner);
}

}  // namespace

tets::OptimizeOptions optimize_options(const FillingInput& input) {
  tets::OptimizeOptions options;
  options.fixed_points = static_cast<std::uint32_t>(input.complex.points.size());
  options.goals = input.goals;
  if (input.sizes.gradation() > kStrongGradation) options.sizes = &input.sizes;
  return options;
}

// By construction there are none; but what is promised is looked at.
tets::Fault check_volumes(const TetMesh& mesh, const TaskRunner& runner) {
  std::vector<std::uint32_t> block_to_fault((mesh.size() + kBlock - 1) / kBlock, tets::kNone);
  runner.for_blocks(mesh.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
      const Vec3 &a = mesh.point_of(t, 0), &b = mesh.point_of(t, 1), &c = mesh.point_of(t, 2), &d = mesh.point_of(t, 3);
      if (orient3d(a, b, c, d) <= 0) block_to_fault[begin / kBlock] = t;
    }
  });
  const auto fault = std::ranges::find_if(block_to_fault, [](std::uint32_t t) { return t != tets::kNone; });
  if (fault == block_to_fault.end()) return {};
  return {"a tetrahedron has no volume", {}, mesh.point_of(*fault, 0)};
}

void finish_filling(FilledMesh& filled, const FillingInput& input, const TaskRunner& runner) {
  optimise(filled, input, runner);
  filled.fault = check_volumes(filled.mesh, runner);
}

Filling to_filling(TetMesh&& mesh, std::size_t given, const TaskRunner& runner) {
  Filling filling;
  mesh.to_neighbor.release();
  mesh.to_fixed.release();
  std::vector<std::uint32_t> to_new(mesh.points.size(), tets::kNone);
  for (const std::uint32_t v : mesh.to_vert) to_new[v] = 0;
  runner.check_cancelled();
  for (std::uint32_t v = 0; v < to_new.size(); ++v) {
    if (v >= given && to_new[v] == tets::kNone) continue;
    to_new[v] = static_cast<std::uint32_t>(filling.points.size());
    filling.points.push_back(mesh.points[v]);
  }
  mesh.points.release();
  filling.tet_to_vert.resize(mesh.to_region.size());
  runner.for_blocks(filling.tet_to_vert.size(), kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t tet = begin; tet < end; ++tet) {
      for (std::size_t i = 0; i < 4; ++i) filling.tet_to_vert[tet][i] = to_new[mesh.to_vert[tet * 4 + i]];
    }
  });
  mesh.to_vert.release();
  filling.tet_to_region.assign(mesh.to_region.begin(), mesh.to_region.end());
  mesh.to_region.release();
  return filling;
}

}  // namespace tetloom::volume
