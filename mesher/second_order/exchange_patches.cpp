#include "mesher/second_order/exchange_patches.hpp"

#include <algorithm>
#include <iterator>

#include "core/mesh/mid_nodes.hpp"
#include "mesher/second_order/patch_mender.hpp"

namespace tetloom::second_order {
namespace {

using Edge = std::array<std::uint32_t, 2>;
using TetVerts = std::array<std::uint32_t, 4>;

/// An edge with the region that it lies in.
struct InnerEdge {
  Edge ends;
  std::uint32_t region;
  friend auto operator<=>(const InnerEdge&, const InnerEdge&) = default;
};

void add_edges(const TetVerts& verts, std::uint32_t region, std::vector<InnerEdge>& edges) {
  for (const auto& [a, b] : shape_of(CellKind::Tet).edges())
    edges.push_back({{std::min(verts[a], verts[b]), std::max(verts[a], verts[b])}, region});
}

// Each once, in the lowest of its regions.
void make_unique(std::vector<InnerEdge>& edges) {
  std::ranges::sort(edges);
  const auto rest = std::ranges::unique(edges, {}, &InnerEdge::ends);
  edges.erase(rest.begin(), rest.end());
}

class Exchange {
 public:
  Exchange(std::span<const BadPatch> patches, std::vector<CurvedNode>& curved, Mesh& mesh)
      : patches_(patches), curved_(curved), mesh_(mesh), vertices_(vertex_count(mesh)) {}

  void run() {
    for (const BadPatch& patch : patches_)
      for (const std::uint32_t tet : patch.to_tet) add_edges(mesh_.tet_to_vert[tet], mesh_.tet_to_entity[tet], before_);
    for (const BadPatch& patch : patches_) take(patch);
    fill_holes();
    make_unique(before_);
    make_unique(after_);
    renew_mid_nodes();
  }

 private:
  void take(const BadPatch& patch) {
    const auto own = static_cast<std::uint32_t>(patch.to_vert.size());
    const auto first_new = static_cast<std::uint32_t>(vertices_ + new_points_.size());
    const std::size_t points = patch.tets.points.size() - PatchMender::kUnusedPoints;
    for (std::size_t v = 0; v < own; ++v) mesh_.points[patch.to_vert[v]] = patch.tets.points[v];
    for (std::size_t v = own; v < points; ++v) new_points_.push_back(patch.tets.points[v]);
    new_regions_.resize(new_points_.size(), 0);
    for (std::uint32_t t = 0; t < patch.tets.size(); ++t) {
      const bool is_old = t < patch.to_tet.size();
      if (patch.tets.is_dead(t)) {
        if (is_old) holes_.push_back(patch.to_tet[t]);
        continue;
      }
      TetVerts verts;
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint32_t v = patch.tets.to_vert[std::size_t{t} * 4 + i];
        verts[i] = v < own ? patch.to_vert[v] : first_new + (v - own);
        if (v >= own) new_regions_[verts[i] - vertices_] = patch.tets.to_region[t];
      }
      add_edges(verts, patch.tets.to_region[t], after_);
      if (is_old)
        mesh_.tet_to_vert[patch.to_tet[t]] = verts;
      else
        fresh_.emplace_back(verts, patch.tets.to_region[t]);
    }
  }

  void fill_holes() {
    std::ranges::sort(holes_);
    const std::size_t filled = std::min(holes_.size(), fresh_.size());
    for (std::size_t i = 0; i < fresh_.size(); ++i) {
      const auto& [verts, region] = fresh_[i];
      if (i < filled) {
        mesh_.tet_to_vert[holes_[i]] = verts, mesh_.tet_to_entity[holes_[i]] = region;
      } else {
        mesh_.tet_to_vert.push_back(verts), mesh_.tet_to_entity.push_back(region);
      }
    }
    const std::span<const std::uint32_t> left = std::span(holes_).subspan(filled);
    std::size_t count = mesh_.tet_to_vert.size(), next = 0, to = 0;
    for (std::size_t from = 0; from < count; ++from) {
      if (next < left.size() && left[next] == from) {
        ++next;
        continue;
      }
      mesh_.tet_to_vert[to] = mesh_.tet_to_vert[from], mesh_.tet_to_entity[to++] = mesh_.tet_to_entity[from];
    }
    mesh_.tet_to_vert.resize(to), mesh_.tet_to_entity.resize(to);
  }

  // An edge that all tets of a patch have lost lay inside of a cavity, so no other tet has it.
  void renew_mid_nodes() {
    const MidNodes mids(mesh_);
    std::vector<InnerEdge> lost, won;
    std::ranges::set_difference(before_, after_, std::back_inserter(lost), {}, &InnerEdge::ends, &InnerEdge::ends);
    std::ranges::set_difference(after_, before_, std::back_inserter(won), {}, &InnerEdge::ends, &InnerEdge::ends);
    std::erase_if(lost, [&](const InnerEdge& edge) { return is_on_surface(mids.find(edge.ends[0], edge.ends[1])); });
    std::erase_if(won, [&](const InnerEdge& edge) { return mids.find(edge.ends[0], edge.ends[1]) != kNone; });
    std::vector<Edge> edges;
    std::vector<Vec3> points(mesh_.points.begin(), mesh_.points.begin() + static_cast<std::ptrdiff_t>(vertices_));
    std::vector<ModelEntity> entities(mesh_.point_to_entity.begin(),
                                      mesh_.point_to_entity.begin() + static_cast<std::ptrdiff_t>(vertices_));
    std::ranges::copy(new_points_, std::back_inserter(points));
    for (const std::uint32_t region : new_regions_) entities.push_back({3, region});
    std::vector<std::uint32_t> to_new(mesh_.mid_to_vert.size(), kNone);
    const auto add = [&](const Edge& ends, ModelEntity entity, const Vec3* place) {
      edges.push_back(ends);
      entities.push_back(entity);
      points.push_back(place ? *place : 0.5 * (points[ends[0]] + points[ends[1]]));
    };
    std::size_t next_won = 0, next_lost = 0;
    for (std::size_t m = 0; m < to_new.size(); ++m) {
      const Edge& ends = mesh_.mid_to_vert[m];
      for (; next_won < won.size() && won[next_won].ends < ends; ++next_won)
        add(won[next_won].ends, {3, won[next_won].region}, nullptr);
      if (next_lost < lost.size() && lost[next_lost].ends == ends) {
        ++next_lost;
        continue;
      }
      to_new[m] = static_cast<std::uint32_t>(edges.size());
      add(ends, mesh_.point_to_entity[vertices_ + m],
          is_on_surface(static_cast<std::uint32_t>(m)) ? &mesh_.points[vertices_ + m] : nullptr);
    }
    for (; next_won < won.size(); ++next_won) add(won[next_won].ends, {3, won[next_won].region}, nullptr);
    for (CurvedNode& node : curved_) node.mid = to_new[node.mid];
    mesh_.points = std::move(points), mesh_.point_to_entity = std::move(entities), mesh_.mid_to_vert = std::move(edges);
  }

  bool is_on_surface(std::uint32_t mid) const {
    const ModelEntity entity = mesh_.point_to_entity[vertices_ + mid];
    return !entity.valid() || entity.dim < 3;
  }

  std::span<const BadPatch> patches_;
  std::vector<CurvedNode>& curved_;
  Mesh& mesh_;
  std::size_t vertices_;
  std::vector<Vec3> new_points_;
  std::vector<std::uint32_t> new_regions_, holes_;
  std::vector<std::pair<TetVerts, std::uint32_t>> fresh_;
  std::vector<InnerEdge> before_, after_;
};

}  // namespace

void exchange_patches(std::span<const BadPatch> patches, std::vector<CurvedNode>& curved, Mesh& mesh) {
  Exchange(patches, curved, mesh).run();
}

}  // namespace tetloom::second_order
