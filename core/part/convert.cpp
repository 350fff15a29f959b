#include "core/part/convert.hpp"

#include <algorithm>
#include <numeric>

#include "core/mesh/mesh_access.hpp"
#include "core/part/adjacency.hpp"
#include "tetloom/error.hpp"

namespace tetloom {
namespace {

template <std::size_t N>
std::span<const std::uint32_t> flat(const std::vector<std::array<std::uint32_t, N>>& elements) {
  return {elements.empty() ? nullptr : elements.front().data(), elements.size() * N};
}

template <std::size_t N>
void unflatten(std::span<const std::uint32_t> values, std::vector<std::array<std::uint32_t, N>>& elements) {
  elements.resize(values.size() / N);
  for (std::size_t i = 0; i < elements.size(); ++i) std::copy_n(values.data() + i * N, N, elements[i].data());
}

template <class T>
std::span<const T> view(const std::vector<T>& values) {
  return values;
}

class PartMaker {
 public:
  /// Without `global_ids`, those are the indices of the points.
  PartMaker(const Mesh& mesh, std::span<const std::uint64_t> global_ids) : mesh_(mesh), global_ids_(global_ids) {}

  PartMesh make() {
    require_consistent(mesh_);
    require_entities_below(mesh_, PackedEntity::kMaxIndex + 1);
    number_vertices();
    add_vertices();
    add_cells(CellKind::Tet, flat(mesh_.tet_to_vert), mesh_.tet_to_entity);
    add_cells(CellKind::Pyramid, flat(mesh_.pyramid_to_vert), mesh_.pyramid_to_entity);
    add_cells(CellKind::Prism, flat(mesh_.prism_to_vert), mesh_.prism_to_entity);
    add_cells(CellKind::Hex, flat(mesh_.hex_to_vert), mesh_.hex_to_entity);
    if (part_.cell_count() == 0)
      throw Error(ErrorCode::InputUnsuitable, "the mesh has no volume cells; only those can be dealt to parts");
    add_fields();
    add_entities();
    connect_cells(part_);
    add_boundary(BoundaryKind::Edge, flat(mesh_.edge_to_vert), mesh_.edge_to_entity);
    add_boundary(BoundaryKind::Triangle, flat(mesh_.tri_to_vert), mesh_.tri_to_entity);
    add_boundary(BoundaryKind::Quad, flat(mesh_.quad_to_vert), mesh_.quad_to_entity);
    return std::move(part_);
  }

 private:
  void number_vertices() {
    local_.assign(mesh_.points.size(), kNone);
    for (const auto verts :
         {flat(mesh_.tet_to_vert), flat(mesh_.pyramid_to_vert), flat(mesh_.prism_to_vert), flat(mesh_.hex_to_vert)})
      for (const std::uint32_t v : verts) local_[v] = 0;
    std::uint32_t count = 0;
    for (std::uint32_t& local : local_)
      if (local == 0) local = count++;
    part_.points.reserve(count);
    part_.vert_to_entity.reserve(count);
    part_.vert_to_global.reserve(count);
  }

  void add_vertices() {
    for (std::size_t i = 0; i < local_.size(); ++i) {
      if (local_[i] == kNone) continue;
      part_.points.push_back(mesh_.points[i]);
      part_.vert_to_entity.push_back(PackedEntity(entity_of_point(mesh_, i)));
      part_.vert_to_global.push_back(global_ids_.empty() ? i : global_ids_[i]);
    }
  }

  void add_cells(CellKind kind, std::span<const std::uint32_t> verts, std::span<const std::uint32_t> regions) {
    CellBlock& block = part_.block(kind);
    block.to_vert.resize_for_overwrite(verts.size());
    for (std::size_t i = 0; i < verts.size(); ++i) block.to_vert[i] = local_[verts[i]];
    block.to_region.append(regions);
  }

  void add_fields() {
    for (const MeshField& field : mesh_.point_fields) {
      VertexField& made = part_.vertex_fields.emplace_back(VertexField{field.name, field.components, {}});
      const auto n = static_cast<std::size_t>(field.components);
      made.values.reserve(part_.vertex_count() * n);
      for (std::size_t i = 0; i < local_.size(); ++i)
        if (local_[i] != kNone) made.values.append(view(field.values).subspan(i * n, n));
    }
    for (const MeshField& field : mesh_.cell_fields) {
      CellField& made = part_.cell_fields.emplace_back(CellField{field.name, field.components, {}});
      std::size_t begin = 0;
      for (std::size_t kind = 0; kind < kCellKinds; ++kind) {
        const std::size_t count = part_.cells[kind].size() * static_cast<std::size_t>(field.components);
        made.values[kind].append(view(field.values).subspan(begin, count));
        begin += count;
      }
    }
  }

  void add_entities() {
    for (int dim = 0; dim < 4; ++dim) {
      const auto& attributes = mesh_.entities[static_cast<std::size_t>(dim)];
      const std::size_t count = std::max(attributes.size(), dim == 2 ? mesh_.face_to_sides.size() : 0);
      for (std::uint32_t i = 0; i < count; ++i) {
        PartEntity& entity = part_.entities.emplace_back();
        entity.entity = ModelEntity(dim, i);
        entity.has_attributes = i < attributes.size();
        if (entity.has_attributes) entity.attributes = attributes[i];
        if (dim == 2 && i < mesh_.face_to_sides.size()) entity.sides = mesh_.face_to_sides[i];
      }
    }
  }

  void add_boundary(BoundaryKind kind, std::span<const std::uint32_t> verts, std::span<const std::uint32_t> entities) {
    BoundaryBlock& block = part_.block(kind);
    const std::size_t n = kBoundaryVertexCount[static_cast<std::size_t>(kind)];
    BallFinder finder(part_);
    for (std::size_t i = 0; i < entities.size(); ++i) {
      const auto element = verts.subspan(i * n, n);
      std::array<std::uint32_t, 4> local{};
      bool used = true;
      for (std::size_t j = 0; j < n; ++j) {
        local[j] = local_[element[j]];
        used = used && local[j] != kNone;
      }
      const auto local_verts = std::span(local).first(n);
      if (!used || !is_on_a_cell(finder, local_verts)) refuse(kind, i, element);
      block.to_vert.append(std::span<const std::uint32_t>(local_verts));
    }
    block.to_entity.append(entities);
  }

  static bool is_on_a_cell(BallFinder& finder, std::span<const std::uint32_t> verts) {
    return verts.size() == 2 ? !finder.find_shell(verts[0], verts[1]).empty() : finder.find_face(verts).valid();
  }

  [[noreturn]] void refuse(BoundaryKind kind, std::size_t element, std::span<const std::uint32_t> verts) const {
    constexpr std::array<const char*, 3> names{"edge", "triangle", "quadrilateral"};
    Diagnostic diagnostic{ErrorCode::InputUnsuitable, {}, {}, mesh_.points[verts[0]], {element}};
    diagnostic.message = std::string(names[static_cast<std::size_t>(kind)]) + " " + std::to_string(element + 1) +
                         " belongs to no volume cell; sheets and wires cannot be dealt to parts";
    throw Error(std::move(diagnostic));
  }

  const Mesh& mesh_;
  const std::span<const std::uint64_t> global_ids_;
  PartMesh part_;
  std::vector<std::uint32_t> local_;
};

void require_distinct(const Mesh& mesh, std::span<const std::uint64_t> global_ids) {
  std::vector<std::uint32_t> order(global_ids.size());
  std::iota(order.begin(), order.end(), 0u);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return global_ids[a] < global_ids[b]; });
  const auto twice =
      std::adjacent_find(order.begin(), order.end(), [&](auto a, auto b) { return global_ids[a] == global_ids[b]; });
  if (twice == order.end()) return;
  Diagnostic diagnostic{ErrorCode::InputUnsuitable, {}, {}, mesh.points[*twice], {}};
  diagnostic.message = "two points have the global id " + std::to_string(global_ids[*twice]);
  throw Error(std::move(diagnostic));
}

// Tables by index have entries for entities that this piece knows nothing of; another piece does, and must be heard.
void drop_unknown_entities(PartMesh& part) {
  std::vector<ModelEntity> used;
  ModelEntity last;
  const auto note = [&](ModelEntity entity) {
    if (entity != last) used.push_back(last = entity);
  };
  for (const PackedEntity entity : part.vert_to_entity) note(entity.unpack());
  for (const CellBlock& block : part.cells)
    for (const std::uint32_t region : block.to_region) note({3, region});
  for (std::size_t kind = 0; kind < part.boundary.size(); ++kind)
    for (const std::uint32_t entity : part.boundary[kind].to_entity) note({kind == 0 ? 1 : 2, entity});
  std::sort(used.begin(), used.end());
  std::erase_if(part.entities, [&](const PartEntity& entity) {
    const EntityAttributes& attributes = entity.attributes;
    const bool blank = attributes.name.empty() && attributes.layer.empty() && attributes.group.empty() &&
                       !attributes.color && attributes.tolerance == 0 && !entity.sides.front.valid() &&
                       !entity.sides.back.valid();
    return blank && !std::binary_search(used.begin(), used.end(), entity.entity);
  });
}

class MeshMaker {
 public:
  explicit MeshMaker(const PartMesh& part) : part_(part) {}

  Mesh make() {
    sort_vertices();
    for_each_cell_kind(mesh_, [&](CellKind kind, auto& cells, auto& regions) { add_cells(kind, cells, regions); });
    add_boundary(BoundaryKind::Edge, mesh_.edge_to_vert, mesh_.edge_to_entity);
    add_boundary(BoundaryKind::Triangle, mesh_.tri_to_vert, mesh_.tri_to_entity);
    add_boundary(BoundaryKind::Quad, mesh_.quad_to_vert, mesh_.quad_to_entity);
    add_fields();
    name_entities(part_.entities, mesh_);
    return std::move(mesh_);
  }

 private:
  void sort_vertices() {
    order_.resize(part_.vertex_count());
    std::iota(order_.begin(), order_.end(), 0u);
    std::sort(order_.begin(), order_.end(),
              [&](std::uint32_t a, std::uint32_t b) { return part_.vert_to_global[a] < part_.vert_to_global[b]; });
    index_.resize(order_.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) {
      index_[order_[i]] = i;
      mesh_.points.push_back(part_.points[order_[i]]);
      mesh_.point_to_entity.push_back(part_.vert_to_entity[order_[i]].unpack());
    }
  }

  template <std::size_t N>
  void add_elements(std::span<const std::uint32_t> verts, std::vector<std::array<std::uint32_t, N>>& elements) const {
    unflatten(verts, elements);
    for (auto& element : elements)
      for (std::uint32_t& v : element) v = index_[v];
  }
  template <std::size_t N>
  void add_cells(CellKind kind, std::vector<std::array<std::uint32_t, N>>& elements,
                 std::vector<std::uint32_t>& regions) const {
    add_elements(part_.block(kind).to_vert, elements);
    regions.assign(part_.block(kind).to_region.begin(), part_.block(kind).to_region.end());
  }
  template <std::size_t N>
  void add_boundary(BoundaryKind kind, std::vector<std::array<std::uint32_t, N>>& elements,
                    std::vector<std::uint32_t>& entities) const {
    add_elements(part_.block(kind).to_vert, elements);
    entities.assign(part_.block(kind).to_entity.begin(), part_.block(kind).to_entity.end());
  }

  void add_fields() {
    for (const VertexField& field : part_.vertex_fields) {
      MeshField& made = mesh_.point_fields.emplace_back(MeshField{field.name, field.components, {}});
      const auto n = static_cast<std::size_t>(field.components);
      for (const std::uint32_t v : order_)
        made.values.insert(made.values.end(), field.values.data() + v * n, field.values.data() + (v + 1) * n);
    }
    for (const CellField& field : part_.cell_fields) {
      MeshField& made = mesh_.cell_fields.emplace_back(MeshField{field.name, field.components, {}});
      for (const auto& values : field.values) made.values.insert(made.values.end(), values.begin(), values.end());
    }
  }

  const PartMesh& part_;
  Mesh mesh_;
  std::vector<std::uint32_t> order_, index_;
};

}  // namespace

PartMesh make_part(const Mesh& mesh) { return PartMaker(mesh, {}).make(); }

PartMesh make_part(const Mesh& mesh, std::span<const std::uint64_t> global_ids) {
  if (global_ids.size() != mesh.points.size())
    throw Error(ErrorCode::InvalidArgument, "a piece of a mesh needs one global id for each point");
  require_distinct(mesh, global_ids);
  PartMesh part = PartMaker(mesh, global_ids).make();
  drop_unknown_entities(part);
  return part;
}

void name_entities(std::span<const PartEntity> entities, Mesh& mesh) {
  for (const PartEntity& entity : entities) {
    if (entity.has_attributes) {
      auto& attributes = mesh.entities[entity.entity.dim];
      if (attributes.size() <= entity.entity.index) attributes.resize(entity.entity.index + 1);
      attributes[entity.entity.index] = entity.attributes;
    }
    if (entity.entity.dim != 2 || (!entity.sides.front.valid() && !entity.sides.back.valid())) continue;
    if (mesh.face_to_sides.size() <= entity.entity.index) mesh.face_to_sides.resize(entity.entity.index + 1);
    mesh.face_to_sides[entity.entity.index] = entity.sides;
  }
}

Mesh make_mesh(const PartMesh& part) { return MeshMaker(part).make(); }

}  // namespace tetloom
