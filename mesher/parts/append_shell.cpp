#include <algorithm>
#include <bit>
#include <utility>

#include "core/tets/find_triangles.hpp"
#include "mesher/parts/shell_steps.hpp"
#include "mesher/parts/shell_tets.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;
using tets::TriangleVerts;

class ShellAppender {
 public:
  ShellAppender(const SharedInput& input, PartShell&& shell, std::span<const TetKeys> removed)
      : input_(input), shell_(std::move(shell)), removed_(removed) {
    mesh_ = std::move(shell_.core_mesh);
  }

  JoinedShell join() {
    core_size_ = static_cast<std::uint32_t>(mesh_.size());
    drop_removed();
    number_kept();
    std::vector<TriangleVerts> open_verts;
    for (const FaceCode face : shell_.core.open_faces) open_verts.push_back(verts_of(mesh_, face));
    const tets::TriangleIndex open(open_verts, keys_.size());
    const std::size_t count = core_size_ + shell_.kept.size();
    mesh_.to_vert.resize_for_overwrite(count * 4);
    mesh_.to_neighbor.resize_for_overwrite(count * 4);
    mesh_.to_fixed.resize_for_overwrite(count);
    for (const std::uint32_t tet : shell_.kept) append(tet, open);
    mesh_.to_region.resize(count, input_.only_region);
    mesh_.points = std::move(shell_.mesh.points);
    std::erase_if(shell_.core.open_faces, [&](FaceCode face) { return mesh_.behind(face).valid(); });
    drop_points_of_others();
    joined_.open_faces = std::move(shell_.core.open_faces);
    joined_.core_tets = core_size_, joined_.shell_tets = shell_.kept.size();
    joined_.tets.keys = std::move(keys_);
    joined_.tets.waits.resize(mesh_.points.size(), 0);
    joined_.tets.surface_count = shell_.surface_count();
    joined_.tets.triangles = std::move(shell_.triangles);
    joined_.tets.next_index = shell_.own_first.back();
    return std::move(joined_);
  }

 private:
  void drop_removed() {
    if (removed_.empty()) return;
    std::erase_if(shell_.kept, [&](std::uint32_t tet) {
      TetKeys keys;
      for (std::size_t i = 0; i < 4; ++i) keys[i] = keys_[shell_.mesh.to_vert[std::size_t{tet} * 4 + i]];
      std::sort(keys.begin(), keys.end());
      return std::binary_search(removed_.begin(), removed_.end(), keys);
    });
  }

  void number_kept() {
    to_kept_.resize(shell_.mesh.size(), kNone);
    std::uint32_t next = core_size_;
    for (const std::uint32_t tet : shell_.kept) to_kept_[tet] = next++;
  }

  void append(std::uint32_t tet, const tets::TriangleIndex& open) {
    const TetMesh& shell = shell_.mesh;
    const std::uint32_t kept = to_kept_[tet];
    mesh_.to_fixed[kept] = shell.to_fixed[tet];
    joined_.seen_sides += static_cast<std::size_t>(std::popcount(shell.to_fixed[tet]));
    for (std::uint32_t i = 0; i < 4; ++i) {
      const FaceCode from(tet, i), to(kept, i), behind = shell.behind(from);
      mesh_.to_vert[to.index()] = shell.apex(from);
      const std::uint32_t next = !behind.valid() ? kNone : to_kept_[behind.tet()];
      mesh_.behind(to) = next == kNone ? FaceCode() : behind.of_tet(next);
      if (next == kNone && !shell.is_fixed(from)) link_to_core(from, to, open);
    }
  }

  // Tets of the core have no vertices on the surface.
  void link_to_core(FaceCode from, FaceCode to, const tets::TriangleIndex& open) {
    const TriangleVerts verts = verts_of(shell_.mesh, from);
    if (std::min({verts[0], verts[1], verts[2]}) < shell_.surface_count()) return;
    const auto* face = open.find(tets::sorted(verts));
    if (!face) return;
    const FaceCode core = shell_.core.open_faces[face->triangle];
    mesh_.behind(to) = core;
    mesh_.behind(core) = to;
  }

  // Points around the part that none of its tets has got. The first ones are those of the surface, whose places are
  // counted on, and the part's own of the first level, which most tets have.
  void drop_points_of_others() {
    const std::uint32_t first = shell_.core.first_own_end;
    shell_.core.beyond_first.push_back({core_size_, static_cast<std::uint32_t>(mesh_.size())});
    const auto for_each_beyond = [&](auto&& visit) {
      for (const auto& [begin, end] : shell_.core.beyond_first)
        for (std::uint32_t& v : mesh_.to_vert.span().subspan(std::size_t{begin} * 4, std::size_t{end - begin} * 4))
          if (v >= first) visit(v);
    };
    std::vector<std::uint32_t> to_new(mesh_.points.size() - first, kNone);
    for_each_beyond([&](std::uint32_t& v) { to_new[v - first] = 0; });
    std::uint32_t next = first;
    for (std::uint32_t v = first; v < mesh_.points.size(); ++v) {
      if (to_new[v - first] == kNone) continue;
      mesh_.points[next] = mesh_.points[v];
      keys_[next] = keys_[v];
      to_new[v - first] = next++;
    }
    for_each_beyond([&](std::uint32_t& v) { v = to_new[v - first]; });
    mesh_.points.resize(next), mesh_.points.shrink_to_fit();
    keys_.resize(next), keys_.shrink_to_fit();
  }

  const SharedInput& input_;
  PartShell shell_;
  GrowingArray<VertKey>& keys_ = shell_.keys;
  JoinedShell joined_;
  TetMesh& mesh_ = joined_.tets.mesh;
  std::span<const TetKeys> removed_;
  std::uint32_t core_size_ = 0;
  GrowingArray<std::uint32_t> to_kept_;
};

}  // namespace

JoinedShell append_shell(const SharedInput& input, PartShell&& shell, std::span<const TetKeys> removed) {
  return ShellAppender(input, std::move(shell), removed).join();
}

tets::Fault name_regions(const SharedInput& input, TetMesh& mesh) {
  tets::Fault fault;
  if (input.only_region != kNone) return fault;
  std::vector<char> is_named(mesh.size(), 0);
  std::vector<std::uint32_t> stack;
  for (std::uint32_t seed = 0; seed < mesh.size(); ++seed) {
    if (is_named[seed]) continue;
    const std::uint32_t region = input.cells.region_at(center_of(mesh, seed));
    if (region == kNone) fault.message = "a tetrahedron lies in no region";
    stack.assign(1, seed);
    is_named[seed] = 1;
    while (!stack.empty()) {
      const std::uint32_t tet = stack.back();
      stack.pop_back();
      mesh.to_region[tet] = region;
      for (const FaceCode face : FaceCode::of(tet)) {
        const FaceCode behind = mesh.behind(face);
        if (!behind.valid() || mesh.is_fixed(face) || is_named[behind.tet()]) continue;
        is_named[behind.tet()] = 1;
        stack.push_back(behind.tet());
      }
    }
  }
  return fault;
}

}  // namespace tetloom::parts
