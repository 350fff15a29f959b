#include "mesher/second_order/bad_patches.hpp"

#include <algorithm>
#include <iterator>

#include "core/base/disjoint_sets.hpp"
#include "core/base/grain.hpp"
#include "core/base/lists.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "core/tets/link_tets.hpp"

namespace tetloom::second_order {
namespace {

class PatchFinder {
 public:
  PatchFinder(const Mesh& mesh, std::span<const std::uint32_t> bad, const TaskRunner& runner)
      : mesh_(mesh), bad_(bad), runner_(runner), is_near_(vertex_count(mesh), 0) {
    for (const std::uint32_t tet : bad)
      for (const std::uint32_t v : mesh.tet_to_vert[tet]) is_near_[v] = 1;
  }

  std::vector<BadPatch> run() {
    const std::vector<std::uint32_t> near = find_near(mesh_.tet_to_vert);
    sort_into_patches(near);
    add_triangles();
    runner_.for_each(patches_.size(), [&](std::size_t p) { link(patches_[p], triangles_[p]); });
    return std::move(patches_);
  }

 private:
  // Elements with a vertex of a bad tet, ascending.
  template <class Element>
  std::vector<std::uint32_t> find_near(const std::vector<Element>& elements) const {
    const auto collect = [&](std::size_t begin, std::size_t end, std::vector<std::uint32_t>& found) {
      for (std::size_t e = begin; e < end; ++e)
        if (std::ranges::any_of(elements[e], [&](std::uint32_t v) { return is_near_[v] != 0; }))
          found.push_back(static_cast<std::uint32_t>(e));
    };
    std::vector<std::uint32_t> all;
    for (const auto& found : map_blocks(runner_, elements.size(), kElementGrain, std::vector<std::uint32_t>{}, collect))
      std::ranges::copy(found, std::back_inserter(all));
    return all;
  }

  void sort_into_patches(std::span<const std::uint32_t> near) {
    DisjointSets sets(is_near_.size());
    for (const std::uint32_t tet : near)
      for (const std::uint32_t v : mesh_.tet_to_vert[tet]) sets.join(mesh_.tet_to_vert[tet][0], v);
    to_patch_.assign(is_near_.size(), kNone);
    const auto patch_of = [&](std::uint32_t tet) -> std::uint32_t& {
      return to_patch_[sets.find(mesh_.tet_to_vert[tet][0])];
    };
    for (const std::uint32_t tet : bad_) {
      if (patch_of(tet) != kNone) continue;
      patch_of(tet) = static_cast<std::uint32_t>(patches_.size());
      patches_.emplace_back();
    }
    for (const std::uint32_t tet : near) patches_[patch_of(tet)].to_tet.push_back(tet);
    for (const std::uint32_t tet : near)
      for (const std::uint32_t v : mesh_.tet_to_vert[tet]) to_patch_[v] = to_patch_[sets.find(v)];
    for (const std::uint32_t tet : bad_) {
      BadPatch& patch = patches_[patch_of(tet)];
      const auto at = std::ranges::lower_bound(patch.to_tet, tet);
      patch.bad.push_back(static_cast<std::uint32_t>(at - patch.to_tet.begin()));
    }
  }

  void add_triangles() {
    triangles_.resize(patches_.size());
    for (const std::uint32_t tri : find_near(mesh_.tri_to_vert)) {
      const auto& verts = mesh_.tri_to_vert[tri];
      if (to_patch_[verts[0]] != kNone) triangles_[to_patch_[verts[0]]].push_back(verts);
    }
  }

  // Triangles with vertices of the patch that are no faces of its tets are told as a fault, and do not matter.
  void link(BadPatch& patch, std::vector<tets::TriangleVerts>& triangles) const {
    for (const std::uint32_t tet : patch.to_tet)
      std::ranges::copy(mesh_.tet_to_vert[tet], std::back_inserter(patch.to_vert));
    sort_unique(patch.to_vert);
    for (const std::uint32_t v : patch.to_vert) patch.tets.points.push_back(mesh_.points[v]);
    const auto own = [&](std::uint32_t v) {
      return static_cast<std::uint32_t>(std::ranges::lower_bound(patch.to_vert, v) - patch.to_vert.begin());
    };
    std::erase_if(triangles, [&](const tets::TriangleVerts& triangle) {
      return !std::ranges::all_of(triangle, [&](auto v) { return std::ranges::binary_search(patch.to_vert, v); });
    });
    for (auto& triangle : triangles) std::ranges::transform(triangle, triangle.begin(), own);
    std::vector<std::array<std::uint32_t, 4>> tet_to_vert(patch.to_tet.size());
    for (std::size_t t = 0; t < tet_to_vert.size(); ++t)
      std::ranges::transform(mesh_.tet_to_vert[patch.to_tet[t]], tet_to_vert[t].begin(), own);
    tets::link_tets(patch.tets, tet_to_vert, triangles, serial_loop());
    for (std::size_t t = 0; t < tet_to_vert.size(); ++t) patch.tets.to_region[t] = mesh_.tet_to_entity[patch.to_tet[t]];
  }

  const Mesh& mesh_;
  std::span<const std::uint32_t> bad_;
  const TaskRunner& runner_;
  std::vector<std::uint8_t> is_near_;    // by vertex: of a bad tet
  std::vector<std::uint32_t> to_patch_;  // by vertex; kNone: in no patch
  std::vector<BadPatch> patches_;
  std::vector<std::vector<tets::TriangleVerts>> triangles_;  // by patch
};

}  // namespace

std::vector<BadPatch> find_bad_patches(const Mesh& mesh, std::span<const std::uint32_t> bad, const TaskRunner& runner) {
  return PatchFinder(mesh, bad, runner).run();
}

}  // namespace tetloom::second_order
