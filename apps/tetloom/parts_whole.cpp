#include "apps/tetloom/parts_whole.hpp"

#include <array>

#include "tetloom/check.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom::app {
namespace {

/// Larger meshes are not brought together in one place for their digest alone.
constexpr std::int64_t kMostGathered = 20'000'000;

}  // namespace

void note_whole(const PartitionedMesh& mesh, const PartsFigures& figures, const TaskRunner& runner, RunReport& report,
                const std::function<void(const Mesh&, const TaskRunner&)>& look) {
  std::array<std::int64_t, 1> tets{};
  for (const PartId part : mesh.local())
    tets[0] += static_cast<std::int64_t>(mesh.parts.at(part).mesh.block(CellKind::Tet).size());
  mesh.communicator->sum(tets);
  report.counts.points = static_cast<std::uint64_t>(figures.vertices);
  report.counts.tets = static_cast<std::uint64_t>(tets[0]);
  if (figures.elements > kMostGathered) return;
  const Mesh whole = gather_mesh(mesh, runner);
  run_on_first(*mesh.communicator, [&] {
    const TaskRunner wide = runner.with_idle_threads(mesh.communicator->ranks_on_machine());
    report.digest = mesh_digest(whole, wide);
    report.counts.triangles = whole.tri_to_vert.size();
    if (look) look(whole, wide);
  });
}

void note_summary(const PartsSummary& summary, const PartsFigures& figures, RunReport& report) {
  report.counts.points = static_cast<std::uint64_t>(figures.vertices);
  report.counts.triangles = summary.triangles, report.counts.tets = summary.tets;
  report.counts.regions = summary.quality.cells.regions.size();
  report.quality = summary.quality;
  report.digest = summary.digest;
}

}  // namespace tetloom::app
