#include "mesher/parts/mend_surface.hpp"

#include <algorithm>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/base/disjoint_sets.hpp"
#include "core/tets/find_triangles.hpp"
#include "mesher/parts/shell_tets.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/recovery.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;
using tets::TriangleVerts;

// How far the tets change around a missing triangle, at most, and how far points are known for that; in sizes.
constexpr double kApart = 3, kKnown = 7;

Box3 box_around(const SharedInput& input, std::uint32_t triangle, double sizes) {
  Box3 box;
  for (const std::uint32_t v : input.filling.complex.tri_to_vert[triangle]) {
    const Vec3& x = input.filling.complex.points[v];
    const double reach = sizes * input.size_at(x);
    box.add(x - Vec3{reach, reach, reach});
    box.add(x + Vec3{reach, reach, reach});
  }
  return box;
}

class ClusterRecovery {
 public:
  ClusterRecovery(const SharedInput& input, const Cluster& cluster, NearPoints around, const TaskRunner& runner)
      : input_(input),
        cluster_(cluster),
        points_(std::move(around.points)),
        pure_(std::move(around.pure)),
        runner_(runner) {
    std::sort(points_.begin(), points_.end(), [](const ShellPoint& a, const ShellPoint& b) { return a.key < b.key; });
    std::stable_sort(pure_.begin(), pure_.end(),
                     [](const PureSite& a, const PureSite& b) { return a.next_to < b.next_to; });
    for (const ShellPoint& point : points_) {
      mesh_.points.push_back(point.point);
      keys_.push_back(point.key);
      surface_count_ += is_of_surface(point.key);
    }
  }

  RecoveredCluster run() {
    std::vector<std::uint32_t> verts(keys_.size());
    std::iota(verts.begin(), verts.end(), 0u);
    first_outer_ = make_delaunay(mesh_, verts, runner_, {input_.box, keys_}).first_outer;
    fix_core();
    find_triangles();
    const std::vector<TetKeys> before = name_tets();
    const tets::RecoveryReport report =
        recover_boundary(mesh_, verts_, tets::recover_options(mesh_.size(), 0), runner_);
    result_.recovered = report.unrecovered.empty();
    if (!result_.recovered) return std::move(result_);
    const std::vector<TetKeys> after = name_tets();
    std::set_difference(before.begin(), before.end(), after.begin(), after.end(), std::back_inserter(result_.removed));
    for (std::size_t v = first_outer_ + 4; v < mesh_.points.size(); ++v)
      result_.tets.new_points.push_back(mesh_.points[v]);
    for (std::uint32_t tet = 0; tet < mesh_.size(); ++tet) {
      if (mesh_.is_dead(tet) || has_outer(tet) || std::binary_search(before.begin(), before.end(), name_of(tet)))
        continue;
      if (is_inside(tet)) make(tet);
    }
    for (const std::uint32_t v : used_) {
      result_.tets.keys.push_back(keys_[v]);
      result_.tets.points.push_back(mesh_.points[v]);
    }
    return std::move(result_);
  }

 private:
  // Faces between the shell and the place of the core stay.
  void fix_core() {
    std::vector<char> in_core(mesh_.size());
    for (std::uint32_t tet = 0; tet < mesh_.size(); ++tet) in_core[tet] = is_in_core(tet);
    for (const FaceCode face : mesh_.faces()) {
      const FaceCode behind = mesh_.behind(face);
      if (!behind.valid() || in_core[face.tet()] == in_core[behind.tet()]) continue;
      if (!has_outer(face.tet()) && !has_outer(behind.tet()))
        mesh_.to_fixed[face.tet()] |= static_cast<std::uint8_t>(1u << face.side());
    }
  }

  // As the shell's tets are; see there.
  bool is_in_core(std::uint32_t tet) const {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    for (int i = 0; i < 4; ++i)
      if (v[i] >= first_outer_ || points_[v[i]].has_pure == 0) return false;
    const VertKey lowest = keys_[std::min({v[0], v[1], v[2], v[3]})];
    auto pure = std::lower_bound(pure_.begin(), pure_.end(), lowest,
                                 [](const PureSite& site, VertKey key) { return site.next_to < key; });
    for (; pure != pure_.end() && pure->next_to == lowest; ++pure)
      if (ball_holds(mesh_, tet, pure->point)) return true;
    return false;
  }

  // Those that are there, to be kept, and those that are to be recovered.
  void find_triangles() {
    std::vector<std::uint32_t> near;
    std::vector<TriangleVerts> near_verts;
    input_.filling.tree.for_each_in(cluster_.box, [&](std::uint32_t triangle) { near.push_back(triangle); });
    std::sort(near.begin(), near.end());
    std::size_t count = 0;
    for (const std::uint32_t triangle : near) {
      TriangleVerts verts{};
      bool known = true;
      for (std::size_t i = 0; i < 3; ++i) {
        const VertKey key = input_.filling.complex.tri_to_vert[triangle][i];
        const auto at = std::lower_bound(keys_.begin(), keys_.end(), key);
        known &= at != keys_.end() && *at == key;
        verts[i] = static_cast<std::uint32_t>(at - keys_.begin());
      }
      if (!known) continue;
      near[count++] = triangle;
      near_verts.push_back(verts);
    }
    const std::vector<FaceCode> faces = tets::find_triangles(mesh_, near_verts, runner_);
    for (std::size_t t = 0; t < count; ++t) {
      const bool wanted = std::binary_search(cluster_.triangles.begin(), cluster_.triangles.end(), near[t]);
      if (!faces[t].valid() && !wanted) continue;
      verts_.push_back(near_verts[t]);
      triangles_.push_back(near[t]);
    }
    index_.emplace(verts_, surface_count_);
  }

  VertKey key(std::uint32_t v) const { return v < first_outer_ ? keys_[v] : kNewPoint + (v - first_outer_ - 4); }
  bool has_outer(std::uint32_t tet) const {
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t v = mesh_.to_vert[std::size_t{tet} * 4 + i];
      if (v >= first_outer_ && v < first_outer_ + 4) return true;
    }
    return false;
  }
  std::array<VertKey, 4> keys_of(std::uint32_t tet) const {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    return {key(v[0]), key(v[1]), key(v[2]), key(v[3])};
  }
  TetKeys name_of(std::uint32_t tet) const {
    TetKeys name = keys_of(tet);
    std::sort(name.begin(), name.end());
    return name;
  }
  std::vector<TetKeys> name_tets() const {
    std::vector<TetKeys> names;
    for (std::uint32_t tet = 0; tet < mesh_.size(); ++tet)
      if (!mesh_.is_dead(tet) && !has_outer(tet)) names.push_back(name_of(tet));
    std::sort(names.begin(), names.end());
    return names;
  }

  // Tets with a point of the lattices are, now that the surface is there.
  bool is_inside(std::uint32_t tet) const {
    for (const VertKey one : keys_of(tet))
      if (!is_of_surface(one) && one < kNewPoint) return true;
    if (const auto told = is_inside_by_faces(input_, mesh_, tet, {*index_, triangles_})) return *told;
    return is_inside_by_center(input_, mesh_, tet);
  }

  void make(std::uint32_t tet) {
    result_.tets.made.push_back(keys_of(tet));
    std::uint8_t& fixed = result_.tets.fixed.emplace_back(mesh_.to_fixed[tet]);
    for (std::uint32_t i = 0; i < 4; ++i)
      if (verts_of(mesh_, {tet, i})[0] >= surface_count_) fixed &= static_cast<std::uint8_t>(~(1u << i));
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint32_t v = mesh_.to_vert[std::size_t{tet} * 4 + i];
      if (v >= first_outer_) continue;
      const auto at = std::lower_bound(used_.begin(), used_.end(), v);
      if (at == used_.end() || *at != v) used_.insert(at, v);
    }
  }

  const SharedInput& input_;
  const Cluster& cluster_;
  std::vector<ShellPoint> points_;  // by key
  std::vector<PureSite> pure_;      // by the key that they are next to
  const TaskRunner& runner_;
  TetMesh mesh_;
  std::vector<VertKey> keys_;
  std::uint32_t surface_count_ = 0, first_outer_ = 0;
  std::vector<TriangleVerts> verts_;      // triangles there are to be
  std::vector<std::uint32_t> triangles_;  // the same, of the complex
  std::optional<tets::TriangleIndex> index_;
  std::vector<std::uint32_t> used_;
  RecoveredCluster result_;
};

// A sweep along x: a box is compared to those before it that reach it there.
DisjointSets join_overlapping(std::span<const Box3> boxes) {
  std::vector<std::uint32_t> order(boxes.size()), reaching;
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return boxes[a].lo.x < boxes[b].lo.x; });
  DisjointSets sets(boxes.size());
  for (const std::uint32_t box : order) {
    std::erase_if(reaching, [&](std::uint32_t other) { return boxes[other].hi.x < boxes[box].lo.x; });
    for (const std::uint32_t other : reaching)
      if (boxes[box].overlaps(boxes[other])) sets.join(box, other);
    reaching.push_back(box);
  }
  return sets;
}

}  // namespace

std::vector<Cluster> make_clusters(const SharedInput& input, std::span<const std::uint32_t> missing) {
  std::vector<Box3> boxes;
  for (const std::uint32_t triangle : missing) boxes.push_back(box_around(input, triangle, kApart));
  DisjointSets sets = join_overlapping(boxes);
  std::vector<Cluster> clusters;
  std::vector<std::uint32_t> to_cluster(missing.size(), kNone);
  for (std::uint32_t i = 0; i < missing.size(); ++i) {
    std::uint32_t& index = to_cluster[sets.find(i)];
    if (index == kNone) {
      index = static_cast<std::uint32_t>(clusters.size());
      const std::uint32_t vert = input.filling.complex.tri_to_vert[missing[i]][0];
      clusters.push_back({{}, {}, input.surface.owner_of(vert)});
    }
    clusters[index].triangles.push_back(missing[i]);
    clusters[index].box.add(box_around(input, missing[i], kKnown));
  }
  return clusters;
}

NearPoints find_near_points(const SharedInput& input, const PartShell& shell, PartId part, const Cluster& cluster) {
  NearPoints found;
  for_each_own_vert(input, shell, part, [&](std::uint32_t v) {
    if (!cluster.box.contains(shell.mesh.points[v])) return;
    found.points.push_back(shell_point(shell, v));
    if (v < shell.surface_count()) return;
    any_pure_around(shell, v, [&](const lattice::SiteLattice& lattice, const lattice::Site& site) {
      found.pure.push_back({shell.keys[v], lattice.point(site)});
      return false;
    });
  });
  return found;
}

RecoveredCluster recover_cluster(const SharedInput& input, const Cluster& cluster, NearPoints around,
                                 const TaskRunner& runner) {
  return ClusterRecovery(input, cluster, std::move(around), runner).run();
}

}  // namespace tetloom::parts
