#include "mesher/parts/lattice_steps.hpp"

#include <algorithm>
#include <utility>

#include "mesher/parts/near_box.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

namespace {

using lattice::LevelPoints;
using lattice::Site;

// How far sites that were left out matter for those that stay, in sizes: each of them lies within .65 sizes of a
// finer one that may be left out itself, and so on.
constexpr double kDroppingReach = 2.2;

// One site of a level on its way to another part.
struct SentSite {
  Site site;
  std::uint32_t index;  // among all of its part
};

struct SentShellPoint {
  Vec3 point;
  std::uint32_t index;
  std::uint32_t has_pure;  // whether pure sites are around it
};

double cube_of(const SharedInput& input, const LevelPoints& level) {
  const lattice::LatticeShape& shape = level.lattice.shape();
  return level.lattice.size() * (input.is_graded() ? shape.graded_cube_per_size() : shape.cube_per_size());
}

// What one neighbour is told of the sites of a level.
struct SentSites {
  std::vector<SentSite> sites;
  std::vector<char> near;  // whether each is near the surface
};

// Per neighbour: the level's sites within the margin of its box. Most sites lie deep inside of the part's, which shows
// before they are moved to where they are.
std::vector<SentSites> find_sent_sites(const SharedInput& input, const LevelPoints& level, std::uint32_t first,
                                       double margin, PartId part) {
  const Box3& box = input.decomposition.box(part);
  const NeighborBoxes neighbors(input.decomposition, part);
  const double deep = margin + level.lattice.most_moved();
  std::vector<SentSites> sent(neighbors.size());
  for (std::size_t i = 0; i < level.sites.size(); ++i) {
    const Site& site = level.sites[i];
    if (depth_inside(level.lattice.place(site), box) > deep) continue;
    neighbors.for_each_near(level.lattice.point(site), margin, [&](std::size_t n) {
      sent[n].sites.push_back({site, first + static_cast<std::uint32_t>(i)});
      sent[n].near.push_back(level.near_surface[i]);
    });
  }
  return sent;
}

// Per level: its sites within so many cubes of the other part's box, and whether each is near the surface.
void send_sites(const SharedInput& input, const PartShell& shell, double reach, PartTask& task) {
  const auto neighbors = input.decomposition.neighbors(task.part());
  std::vector<MessageWriter> writers(neighbors.size());
  for (std::size_t l = 0; l < shell.levels.size(); ++l) {
    const LevelPoints& level = shell.levels[l];
    const double margin = reach * cube_of(input, level);
    const auto sent = find_sent_sites(input, level, shell.own_first[l], margin, task.part());
    for (std::size_t n = 0; n < neighbors.size(); ++n) {
      writers[n].put_array<SentSite>(sent[n].sites);
      writers[n].put_array<char>(sent[n].near);
    }
  }
  for (std::size_t n = 0; n < neighbors.size(); ++n) task.send(neighbors[n], writers[n].take());
}

void number_own(PartShell& shell) {
  shell.own_first.assign(1, 0);
  for (const LevelPoints& level : shell.levels)
    shell.own_first.push_back(shell.own_first.back() + static_cast<std::uint32_t>(level.sites.size()));
}

// Appends what others sent, level by level, to lists of the same levels.
void take_sites(PartTask& task, std::vector<LevelPoints>& levels, std::vector<std::vector<VertKey>>& keys) {
  keys.resize(levels.size());
  for (Message& message : task.inbox()) {
    MessageReader reader(message.bytes);
    for (std::size_t l = 0; l < levels.size(); ++l) {
      for (const SentSite& sent : reader.get_view<SentSite>()) {
        levels[l].sites.push_back(sent.site);
        keys[l].push_back(key_of(message.from, sent.index));
      }
      const auto near = reader.get_view<char>();
      levels[l].near_surface.insert(levels[l].near_surface.end(), near.begin(), near.end());
    }
    message.bytes.release();
  }
}

std::vector<LevelPoints> empty_levels(const SharedInput& input) {
  std::vector<LevelPoints> levels;
  for (const lattice::SiteLattice& lattice : input.cells.lattices()) levels.push_back({lattice, {}, {}});
  return levels;
}

void append_points(const LevelPoints& level, std::vector<Vec3>& points) {
  for (const Site& site : level.sites) points.push_back(level.lattice.point(site));
}

void send_shell_points(const SharedInput& input, const PartShell& shell, PartTask& task) {
  std::vector<Placed<SentShellPoint>> border;
  std::size_t l = 0;
  for (const std::uint32_t vert : shell.core.shell_verts) {
    while (vert >= shell.core.level_to_vert[l + 1]) ++l;
    const Vec3& x = shell.core_mesh.points[vert];
    const double reach = kShellReach * shell.levels[l].lattice.size();
    if (depth_inside(x, input.decomposition.box(task.part())) > reach) continue;
    const auto index = static_cast<std::uint32_t>(shell.keys[vert]);
    border.push_back({x, reach, {x, index, shell.pure_around[vert] != 0}});
  }
  const auto neighbors = input.decomposition.neighbors(task.part());
  const auto near = near_neighbors(border, input.decomposition, task.part());
  for (std::size_t n = 0; n < neighbors.size(); ++n) {
    if (near[n].empty()) continue;
    MessageWriter writer;
    writer.put_array<SentShellPoint>(near[n]);
    task.send(neighbors[n], writer.take());
  }
}

}  // namespace

PartShell find_points(const SharedInput& input, PartTask& task) {
  PartShell shell;
  const Box3& box = input.decomposition.box(task.part());
  shell.levels = empty_levels(input);
  lattice::CellSites working;
  for (const std::uint32_t index : input.decomposition.cells_of(task.part())) {
    task.check_cancelled();
    const lattice::LatticeCell& cell = input.cells.cells()[index];
    Box3 piece = cell.box;
    for (int axis = 0; axis < 3; ++axis) {
      piece.lo[axis] = std::max(piece.lo[axis], box.lo[axis]);
      piece.hi[axis] = std::min(piece.hi[axis], box.hi[axis]);
    }
    const auto level_to_sites = input.cells.find_sites(cell, piece, working);
    for (std::size_t l = 0; l < level_to_sites.size(); ++l) {
      for (const lattice::KeptSite& kept : level_to_sites[l]) {
        shell.levels[l].sites.push_back(kept.site);
        shell.levels[l].near_surface.push_back(kept.near_surface);
      }
    }
  }
  number_own(shell);
  send_sites(input, shell, input.is_graded() ? kDroppingReach : lattice::kReach, task);
  return shell;
}

void drop_near_finer(const SharedInput& input, PartShell& shell, PartTask& task) {
  std::vector<LevelPoints> others = empty_levels(input);
  std::vector<std::vector<VertKey>> keys;
  take_sites(task, others, keys);
  std::vector<std::vector<Vec3>> points(shell.levels.size());
  for (std::size_t l = 0; l < shell.levels.size(); ++l) {
    const std::size_t first = l < lattice::kLevelsThatReach ? 0 : l - lattice::kLevelsThatReach;
    const std::vector<std::span<const Vec3>> finer(points.begin() + static_cast<std::ptrdiff_t>(first),
                                                   points.begin() + static_cast<std::ptrdiff_t>(l));
    for (LevelPoints* level : {&shell.levels[l], &others[l]}) {
      if (l > 0) lattice::drop_near_finer(*level, finer, task.runner());
      append_points(*level, points[l]);
    }
  }
  number_own(shell);
  send_sites(input, shell, lattice::kGradedReach, task);
}

void make_core(const SharedInput& input, PartShell& shell, PartTask& task) {
  std::vector<std::vector<VertKey>> foreign;
  take_sites(task, shell.levels, foreign);
  const auto known = input.surface.points_of(task.part());
  shell.surface.assign(known.begin(), known.end());
  shell.keys.reserve(known.size());
  for (const std::uint32_t point : known) {
    shell.core_mesh.points.push_back(input.filling.complex.points[point]);
    shell.keys.push_back(point);
  }
  for (std::size_t l = 0; l < shell.levels.size(); ++l) {
    shell.levels[l].foreign = foreign[l].size();
    for (std::uint32_t i = shell.own_first[l]; i < shell.own_first[l + 1]; ++i)
      shell.keys.push_back(key_of(task.part(), i));
    shell.keys.append(foreign[l]);
  }
  shell.core = emit_core(shell.core_mesh, shell.levels, task.runner());
  shell.pure_around.assign(shell.core_mesh.points.size(), 0);
  for (std::size_t i = 0; i < shell.core.shell_verts.size(); ++i)
    shell.pure_around[shell.core.shell_verts[i]] = shell.core.pure_around[i];
  send_shell_points(input, shell, task);
}

void take_shell_points(PartShell& shell, PartTask& task) {
  // Those of the neighbourhood that the core knows are not taken twice.
  std::vector<std::pair<VertKey, std::uint32_t>> known;
  for (std::size_t l = 0; l < shell.levels.size(); ++l) {
    const std::uint32_t end = shell.core.level_to_vert[l + 1];
    for (auto v = end - static_cast<std::uint32_t>(shell.levels[l].foreign); v < end; ++v)
      known.emplace_back(shell.keys[v], v);
  }
  std::sort(known.begin(), known.end());
  shell.verts.resize(shell.surface.size());
  for (std::uint32_t v = 0; v < shell.verts.size(); ++v) shell.verts[v] = v;
  shell.verts.insert(shell.verts.end(), shell.core.shell_verts.begin(), shell.core.shell_verts.end());
  for (Message& message : task.inbox()) {
    MessageReader reader(message.bytes);
    for (const SentShellPoint& sent : reader.get_view<SentShellPoint>()) {
      const VertKey key = key_of(message.from, sent.index);
      const auto at = std::lower_bound(known.begin(), known.end(), std::pair{key, std::uint32_t{0}});
      std::uint32_t vert = 0;
      if (at != known.end() && at->first == key) {
        vert = at->second;
      } else {
        vert = static_cast<std::uint32_t>(shell.core_mesh.points.size());
        shell.core_mesh.points.push_back(sent.point);
        shell.keys.push_back(key);
        shell.pure_around.push_back(0);
      }
      shell.pure_around[vert] = sent.has_pure != 0;
      shell.verts.push_back(vert);
    }
  }
}

}  // namespace tetloom::parts
