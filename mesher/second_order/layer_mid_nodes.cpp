#include "mesher/second_order/layer_mid_nodes.hpp"

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

#include "core/base/lists.hpp"
#include "core/geometry/model_projector.hpp"
#include "core/mesh/mid_nodes.hpp"

namespace tetloom::second_order {
namespace {

// Edges of a prism's triangle below, and those above them.
constexpr std::array<std::array<LocalEdge, 2>, 3> kBelowAndAbove{
    {{{{0, 1}, {3, 4}}}, {{{1, 2}, {4, 5}}}, {{{2, 0}, {5, 3}}}}};

class Carrier {
 public:
  Carrier(const GeometricModel& model, const Mesh& mesh, std::vector<CurvedNode>& curved)
      : mesh_(mesh), first_mid_(vertex_count(mesh)), project_(make_projector(model)), curved_(curved) {}

  void run() {
    find_above();
    leader_.assign(mesh_.mid_to_vert.size(), kNone);
    const std::vector<CurvedNode> walls = nodes_on_walls();
    for (const CurvedNode& wall : walls) leader_[wall.mid] = wall.mid;
    for (const CurvedNode& wall : walls) carry(wall);
    std::erase_if(curved_,
                  [&](const CurvedNode& node) { return leader_[node.mid] != kNone && leader_[node.mid] != node.mid; });
    curved_.insert(curved_.end(), carried_.begin(), carried_.end());
    std::ranges::sort(curved_, {}, &CurvedNode::mid);
  }

 private:
  using Above = std::pair<std::uint32_t, std::uint32_t>;

  void find_above() {
    const MidNodes mids(mesh_);
    is_above_.assign(mesh_.mid_to_vert.size(), false);
    for (const auto& prism : mesh_.prism_to_vert)
      for (const auto& [below, above] : kBelowAndAbove) {
        const std::uint32_t top = mids.find(prism[above[0]], prism[above[1]]);
        above_.emplace_back(mids.find(prism[below[0]], prism[below[1]]), top);
        is_above_[top] = true;
      }
    sort_unique(above_);
  }

  std::span<const Above> above(std::uint32_t mid) const {
    const auto [first, last] = std::ranges::equal_range(above_, mid, {}, &Above::first);
    return {first, last};
  }

  std::vector<CurvedNode> nodes_on_walls() const {
    std::vector<CurvedNode> walls;
    for (const CurvedNode& node : curved_)
      if (!is_above_[node.mid] && !above(node.mid).empty()) walls.push_back(node);
    return walls;
  }

  // Where layers of two walls meet the first one has the last word.
  void carry(const CurvedNode& wall) {
    const Vec3 away = wall.place - middle_of_edge(mesh_, wall.mid);
    std::vector<std::uint32_t> open{wall.mid};
    while (!open.empty()) {
      const std::uint32_t below = open.back();
      open.pop_back();
      for (const auto& [mid, top] : above(below)) {
        if (leader_[top] != kNone) continue;
        const std::optional<Vec3> place = place_of(top, away);
        if (!place) continue;
        leader_[top] = wall.mid;
        carried_.push_back({top, *place, wall.mid});
        open.push_back(top);
      }
    }
  }

  std::optional<Vec3> place_of(std::uint32_t mid, const Vec3& away) const {
    const Vec3 place = middle_of_edge(mesh_, mid) + away;
    const ModelEntity entity = mesh_.point_to_entity[first_mid_ + mid];
    if (entity.dim == 3) return place;
    const auto& [a, b] = mesh_.mid_to_vert[mid];
    const std::optional<SurfaceSpot> spot = project_(entity, place);
    if (!spot || !(distance(spot->point, place) <= kMostDisplacement * distance(mesh_.points[a], mesh_.points[b])))
      return std::nullopt;
    return spot->point;
  }

  const Mesh& mesh_;
  std::size_t first_mid_;
  SurfaceProjector project_;
  std::vector<CurvedNode>& curved_;
  std::vector<Above> above_;           // ascending; mid nodes, and those that lie above them in one layer
  std::vector<bool> is_above_;         // by mid
  std::vector<std::uint32_t> leader_;  // by mid: the one on the wall; kNone: none
  std::vector<CurvedNode> carried_;
};

}  // namespace

void carry_through_layers(const GeometricModel& model, const Mesh& mesh, std::vector<CurvedNode>& curved) {
  if (!mesh.prism_to_vert.empty()) Carrier(model, mesh, curved).run();
}

}  // namespace tetloom::second_order
