#include "mesher/classify_parts.hpp"

#include <algorithm>
#include <numeric>

#include "core/base/lists.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"

namespace tetloom {
namespace {

// The pieces of model edges by their lower point.
class EdgeIndex {
 public:
  explicit EdgeIndex(const Mesh& surface) : surface_(surface), order_(surface.edge_to_vert.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return std::pair(lower(a), a) < std::pair(lower(b), b); });
  }

  std::span<const std::uint32_t> edges_from(std::uint64_t point) const {
    return std::ranges::equal_range(order_, point, {}, [this](std::uint32_t edge) { return lower(edge); });
  }

 private:
  std::uint64_t lower(std::uint32_t edge) const {
    return std::min(surface_.edge_to_vert[edge][0], surface_.edge_to_vert[edge][1]);
  }

  const Mesh& surface_;
  std::vector<std::uint32_t> order_;
};

class PartClassifier {
 public:
  PartClassifier(const Mesh& surface, const EdgeIndex& edges, const layers::PartLayers* layers, PartMesh& part)
      : surface_(surface), edges_(edges), layers_(layers), part_(part) {}

  void run() {
    std::vector<std::uint32_t> walls;
    if (layers_) walls = layers_->take_tops(part_);
    for (std::uint32_t& entity : part_.block(BoundaryKind::Triangle).to_entity) entity = surface_.tri_to_entity[entity];
    if (layers_) layers_->add_stacks(walls, part_);
    connect_cells(part_);
    classify_vertices();
    add_edges();
    if (layers_) layers_->add_edges(walls, part_);
    add_entities();
    if (layers_) layers_->number_as_in_mesh(part_);
  }

 private:
  bool is_new(std::uint32_t vert) const { return part_.vert_to_global[vert] >= surface_.points.size(); }

  void classify_vertices() {
    part_.vert_to_entity.resize_for_overwrite(part_.vertex_count());
    for (std::uint32_t v = 0; v < part_.vertex_count(); ++v)
      part_.vert_to_entity[v] =
          PackedEntity(is_new(v) ? entity_of_new(v) : surface_.point_to_entity[part_.vert_to_global[v]]);
  }

  // New points lie inside of the region of any cell that has them, but for those of layers on faces.
  ModelEntity entity_of_new(std::uint32_t vert) const {
    if (layers_)
      if (const ModelEntity entity = layers_->entity_of(part_.vert_to_global[vert]); entity.valid()) return entity;
    const CellPlace place = part_.vert_to_place[vert];
    return ModelRegionId(part_.block(place.kind()).to_region[place.cell()]);
  }

  // A tet may have an edge of which the part has no triangle.
  void add_edges() {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> point_to_vert;
    for (std::uint32_t v = 0; v < part_.vertex_count(); ++v)
      if (!is_new(v)) point_to_vert.emplace_back(static_cast<std::uint32_t>(part_.vert_to_global[v]), v);
    std::sort(point_to_vert.begin(), point_to_vert.end());
    std::vector<std::pair<std::uint32_t, std::array<std::uint32_t, 2>>> found;
    BallFinder finder(part_);
    for (const auto& [point, vert] : point_to_vert) {
      for (const std::uint32_t edge : edges_.edges_from(point)) {
        std::array<std::uint32_t, 2> verts = surface_.edge_to_vert[edge];
        const bool turned = verts[0] != point;
        const std::uint32_t other = verts[turned ? 0 : 1];
        const auto at = std::ranges::lower_bound(point_to_vert, std::pair(other, std::uint32_t{0}));
        if (at == point_to_vert.end() || at->first != other || finder.find_shell(vert, at->second).empty()) continue;
        verts = {vert, at->second};
        if (turned) std::swap(verts[0], verts[1]);
        found.push_back({edge, verts});
      }
    }
    std::sort(found.begin(), found.end());
    BoundaryBlock& block = part_.block(BoundaryKind::Edge);
    for (const auto& [edge, verts] : found) {
      block.to_vert.append(std::span<const std::uint32_t>(verts));
      block.to_entity.push_back(surface_.edge_to_entity[edge]);
    }
  }

  void add_entities() {
    std::vector<PackedEntity> used;
    for (const PackedEntity entity : part_.vert_to_entity) note(entity, used);
    for (const CellBlock& block : part_.cells)
      for (const std::uint32_t region : block.to_region) note(PackedEntity({3, region}), used);
    for (const BoundaryKind kind : {BoundaryKind::Triangle, BoundaryKind::Quad})
      for (const std::uint32_t face : part_.block(kind).to_entity) note(PackedEntity({2, face}), used);
    for (const std::uint32_t edge : part_.block(BoundaryKind::Edge).to_entity) note(PackedEntity({1, edge}), used);
    sort_unique(used);
    for (const PackedEntity packed : used)
      if (packed.unpack().valid()) part_.entities.push_back(describe(packed.unpack()));
  }

  static void note(PackedEntity entity, std::vector<PackedEntity>& used) {
    if (used.empty() || used.back() != entity) used.push_back(entity);
  }

  PartEntity describe(ModelEntity entity) const {
    PartEntity known;
    known.entity = entity;
    const auto& attributes = surface_.entities[entity.dim];
    known.has_attributes = entity.index < attributes.size();
    if (known.has_attributes) known.attributes = attributes[entity.index];
    if (entity.dim == 2 && entity.index < surface_.face_to_sides.size())
      known.sides = surface_.face_to_sides[entity.index];
    return known;
  }

  const Mesh& surface_;
  const EdgeIndex& edges_;
  const layers::PartLayers* const layers_;
  PartMesh& part_;
};

}  // namespace

PartitionedMesh classify_parts(const Mesh& surface, std::vector<PartMesh>&& parts, std::size_t part_count,
                               const layers::PartLayers* layers, const SharedWork& work) {
  const TaskRunner& runner = work.runner();
  PartitionedMesh mesh(work.ranks(), part_count);
  const auto local = mesh.local();
  run_on_all(work.ranks(), [&] {
    const EdgeIndex edges(surface);
    runner.for_each(local.size(), [&](std::size_t i) {
      PartMesh& part = mesh.parts.at(local[i]).mesh = std::move(parts[i]);
      PartClassifier(surface, edges, layers, part).run();
      runner.check_cancelled();
    });
  });
  parts.clear();
  if (layers) mesh.cell_fields = layers->fields();
  link_parts(mesh, runner);
  return mesh;
}

}  // namespace tetloom
