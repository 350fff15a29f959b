#include "mesher/lattice/lattice_points.hpp"

#include <utility>

#include "mesher/lattice/lattice_cells.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::lattice {

namespace {

void append(const std::vector<KeptSite>& from, LevelPoints& to) {
  for (const KeptSite& kept : from) {
    to.sites.push_back(kept.site);
    to.near_surface.push_back(kept.near_surface);
  }
}

void drop_near_finer(std::vector<LevelPoints>& levels, const TaskRunner& runner) {
  std::vector<std::vector<Vec3>> points(levels.size());
  for (std::size_t level = 0; level < levels.size(); ++level) {
    const std::size_t first = level < kLevelsThatReach ? 0 : level - kLevelsThatReach;
    const std::vector<std::span<const Vec3>> finer(points.begin() + static_cast<std::ptrdiff_t>(first),
                                                   points.begin() + static_cast<std::ptrdiff_t>(level));
    if (!finer.empty()) drop_near_finer(levels[level], finer, runner);
    if (level + 1 == levels.size()) break;
    for (const Site& site : levels[level].sites) points[level].push_back(levels[level].lattice.point(site));
  }
}

}  // namespace

std::vector<LevelPoints> make_lattice_points(const LatticeRequest& request, const TaskRunner& runner) {
  if (request.box.empty()) return {};
  const LatticeCells tree(request, runner);
  const std::vector<LatticeCell>& cells = tree.cells();
  std::vector<std::vector<std::vector<KeptSite>>> cell_to_sites(cells.size());  // per level within a cell
  runner.for_blocks(cells.size(), 16, [&](std::size_t begin, std::size_t end) {
    CellSites sites;
    for (std::size_t i = begin; i < end; ++i) cell_to_sites[i] = tree.find_sites(cells[i], cells[i].box, sites);
  });
  std::vector<LevelPoints> result;
  for (std::size_t level = 0; level < tree.level_count(); ++level) {
    LevelPoints& points = result.emplace_back(LevelPoints{tree.lattices()[level], {}, {}});
    std::size_t count = 0;
    for (const auto& of_cell : cell_to_sites) count += of_cell[level].size();
    points.sites.reserve(count);
    points.near_surface.reserve(count);
    for (auto& of_cell : cell_to_sites) append(std::exchange(of_cell[level], {}), points);
  }
  drop_near_finer(result, runner);
  return result;
}

}  // namespace tetloom::lattice
