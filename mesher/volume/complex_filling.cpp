#include "mesher/volume/complex_filling.hpp"

#include <algorithm>
#include <numeric>

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
  if (input.options.lattice == LatticeKind::Bcc) options.lattice_tets = static_cast<std::uint32_t>(figures.core_tets);
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
  options.goals = input.options.goals;
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

PartMesh to_part(FilledMesh&& filled, const Complex& complex, const TaskRunner& runner) {
  PartMesh part;
  TetMesh& mesh = filled.mesh;
  mesh.to_neighbor.release();
  mesh.to_fixed.release();
  std::vector<std::uint32_t> to_new(mesh.points.size(), tets::kNone);
  for (const std::uint32_t v : mesh.to_vert) to_new[v] = 0;
  runner.check_cancelled();
  std::uint32_t count = 0;
  for (std::uint32_t v = 0; v < to_new.size(); ++v) {
    if (v >= complex.points.size() && to_new[v] == tets::kNone) continue;
    mesh.points[count] = mesh.points[v];
    to_new[v] = count++;
  }
  mesh.points.resize_for_overwrite(count);
  mesh.points.shrink_to_fit();
  runner.for_blocks(mesh.to_vert.size(), 4 * kBlock, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) mesh.to_vert[i] = to_new[mesh.to_vert[i]];
  });
  part.points = std::move(mesh.points);
  part.vert_to_global.resize_for_overwrite(count);
  std::iota(part.vert_to_global.begin(), part.vert_to_global.end(), std::uint64_t{0});
  CellBlock& tets = part.block(CellKind::Tet);
  tets.to_vert = std::move(mesh.to_vert), tets.to_region = std::move(mesh.to_region);
  BoundaryBlock& triangles = part.block(BoundaryKind::Triangle);
  triangles.to_vert.reserve(3 * complex.tri_to_vert.size());
  for (const auto& verts : filled.tri_to_vert.empty() ? complex.tri_to_vert : filled.tri_to_vert)
    triangles.to_vert.append(verts);
  triangles.to_entity.resize_for_overwrite(complex.tri_to_vert.size());
  std::iota(triangles.to_entity.begin(), triangles.to_entity.end(), 0u);
  return part;
}

}  // namespace tetloom::volume
