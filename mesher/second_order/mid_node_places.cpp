#include "mesher/second_order/mid_node_places.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>
#include <utility>
#include <vector>

#include "core/base/grain.hpp"
#include "core/geometry/model_projector.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "mesher/second_order/layer_mid_nodes.hpp"

namespace tetloom::second_order {
namespace {

constexpr std::size_t kProjectedTogether = 1024;  // their projector remembers what it has found
constexpr double kStraight = 1e-9;                // of the chord: below, the mid node is left in the middle

void add_mid_nodes(Mesh& mesh, const TaskRunner& runner) {
  std::vector<std::array<std::uint32_t, 2>> edges = edges_of_elements(mesh, runner);
  const std::size_t vertices = mesh.points.size();
  if (vertices + edges.size() >= kNone)
    throw Error(ErrorCode::InputUnsuitable, "the mesh of second order would have more than 2^32 - 2 points");
  mesh.points.resize(vertices + edges.size());
  mesh.point_to_entity.resize(vertices + edges.size());
  mesh.mid_to_vert = std::move(edges);
  runner.for_blocks(mesh.mid_to_vert.size(), kCopyGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t m = begin; m < end; ++m) mesh.points[vertices + m] = middle_of_edge(mesh, m);
  });
  classify_mid_nodes(mesh, runner);
}

// Mid nodes on the surface, by entity; those of one entity in blocks.
class SurfaceMidNodes {
 public:
  explicit SurfaceMidNodes(const Mesh& mesh) : first_(vertex_count(mesh)), entities_(mesh.point_to_entity) {
    for (std::uint32_t m = 0; m < mesh.mid_to_vert.size(); ++m)
      if (const ModelEntity entity = entity_of(m); entity.valid() && entity.dim < 3) order_.push_back(m);
    std::ranges::stable_sort(order_, {}, [&](std::uint32_t m) { return key_of(m); });
    for (std::size_t begin = 0, end = 0; begin < order_.size(); begin = end) {
      while (end < order_.size() && end - begin < kProjectedTogether && key_of(order_[end]) == key_of(order_[begin]))
        ++end;
      blocks_.push_back(std::span(order_).subspan(begin, end - begin));
    }
  }
  std::span<const std::span<const std::uint32_t>> blocks() const { return blocks_; }
  ModelEntity entity_of(std::uint32_t mid) const { return entities_[first_ + mid]; }

 private:
  std::pair<int, std::uint32_t> key_of(std::uint32_t mid) const { return {entity_of(mid).dim, entity_of(mid).index}; }

  std::size_t first_;
  std::span<const ModelEntity> entities_;
  std::vector<std::uint32_t> order_;
  std::vector<std::span<const std::uint32_t>> blocks_;
};

// What projecting mid nodes came to.
struct Projected {
  std::vector<CurvedNode> curved;
  std::vector<std::pair<std::uint32_t, double>> far;  // those that stay in the middle, and how far the model is
};

Projected project(const GeometricModel& model, const Mesh& mesh, ModelEntity entity,
                  std::span<const std::uint32_t> mids) {
  Projected projected;
  const SurfaceProjector projector = make_projector(model);
  for (const std::uint32_t mid : mids) {
    const auto [a, b] = mesh.mid_to_vert[mid];
    const double chord = distance(mesh.points[a], mesh.points[b]);
    const Vec3 middle = middle_of_edge(mesh, mid);
    const std::optional<SurfaceSpot> spot = projector(entity, middle);
    const double away = spot ? distance(spot->point, middle) : HUGE_VAL;
    if (!(away <= kMostDisplacement * chord))
      projected.far.emplace_back(mid, away);
    else if (away > kStraight * chord)
      projected.curved.push_back({mid, spot->point, kNone});
  }
  return projected;
}

}  // namespace

MidNodePlaces place_mid_nodes(const GeometricModel& model, Mesh& mesh, const TaskRunner& runner) {
  add_mid_nodes(mesh, runner);
  const SurfaceMidNodes surface(mesh);
  std::vector<Projected> of_blocks(surface.blocks().size());
  runner.begin_stage(Stage::SecondOrder, of_blocks.size());
  runner.for_each(of_blocks.size(), [&](std::size_t i) {
    const std::span<const std::uint32_t> mids = surface.blocks()[i];
    of_blocks[i] = project(model, mesh, surface.entity_of(mids.front()), mids);
    runner.advance();
  });
  MidNodePlaces places;
  for (const Projected& of_block : of_blocks)
    places.curved.insert(places.curved.end(), of_block.curved.begin(), of_block.curved.end());
  std::ranges::sort(places.curved, {}, &CurvedNode::mid);
  carry_through_layers(model, mesh, places.curved);
  for (const Projected& of_block : of_blocks)
    for (const auto& [mid, away] : of_block.far)
      if (!std::ranges::binary_search(places.curved, mid, {}, &CurvedNode::mid))
        places.off_model.push_back({surface.entity_of(mid), away, middle_of_edge(mesh, mid)});
  return places;
}

}  // namespace tetloom::second_order
