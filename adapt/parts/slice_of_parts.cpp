// The slices of a mesh that lies in parts.
#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "adapt/parts/mesh_slice.hpp"
#include "core/base/free_memory.hpp"
#include "core/part/convert.hpp"
#include "tetloom/error.hpp"
#include "threading/parts/gather_mesh.hpp"
#include "threading/parts/ghosts.hpp"
#include "threading/parts/number_ids.hpp"

namespace tetloom::adapt {

namespace {

constexpr int kTensorEntries = 6;
constexpr std::array<BoundaryKind, 2> kBoundaryKinds{BoundaryKind::Edge, BoundaryKind::Triangle};

void require_tets(const PartMesh& part) {
  if (part.cell_count() > part.block(CellKind::Tet).size())
    throw Error(ErrorCode::InputUnsuitable, "only meshes of tetrahedra are adapted; this one has other cells as well");
  if (part.block(BoundaryKind::Quad).size() > 0)
    throw Error(ErrorCode::InputUnsuitable,
                "only triangles may bound a mesh that is adapted; this one has quadrilaterals");
}

// As the last of the fields.
void add_metric(PartitionedMesh& mesh, PerPart<MetricField>&& metric) {
  mesh.vertex_fields.push_back({{}, kTensorEntries});
  for (const PartId id : mesh.local()) {
    VertexField field{{}, kTensorEntries, {}};
    field.values.reserve(metric.at(id).size() * kTensorEntries);
    for (const Tensor& m : metric.at(id).logs) field.values.append(std::array{m.xx, m.xy, m.yy, m.xz, m.yz, m.zz});
    metric.at(id) = MetricField();
    mesh.parts.at(id).mesh.vertex_fields.push_back(std::move(field));
  }
}

Tensor tensor_at(const double* m) { return {m[0], m[1], m[2], m[3], m[4], m[5]}; }

class PartSlicer {
 public:
  PartSlicer(PartitionedMesh&& mesh, const SharedWork& work) : mesh_(std::move(mesh)), work_(work) {
    mesh_.communicator = &work.ranks();
  }

  MeshSlice run(PerPart<MetricField>&& metric, const std::vector<std::string>& fields) {
    for (const PartId part : mesh_.local()) require_tets(mesh_.parts.at(part).mesh);
    name_entities(gather_entities(mesh_, work_), slice_.mesh);
    keep_fields(fields);
    add_metric(mesh_, std::move(metric));
    deal();
    find_ghosts();
    number_verts();
    take_points();
    take_tets();
    take_boundary(BoundaryKind::Triangle, slice_.mesh.tri_to_vert, slice_.mesh.tri_to_entity);
    take_boundary(BoundaryKind::Edge, slice_.mesh.edge_to_vert, slice_.mesh.edge_to_entity);
    ghosted_ = GhostedPart();
    return std::move(slice_);
  }

 private:
  std::size_t ranks() const { return static_cast<std::size_t>(work_.rank_count()); }
  PartMesh& part() { return ghosted_.mesh; }

  void keep_fields(const std::vector<std::string>& fields) {
    const auto is_kept = [&](const auto& field) { return std::ranges::count(fields, field.name) != 0; };
    std::erase_if(mesh_.vertex_fields, [&](const FieldInfo& info) { return !is_kept(info); });
    std::erase_if(mesh_.cell_fields, [&](const FieldInfo& info) { return !is_kept(info); });
    for (const PartId id : mesh_.local()) {
      PartMesh& part = mesh_.parts.at(id).mesh;
      std::erase_if(part.vertex_fields, [&](const VertexField& field) { return !is_kept(field); });
      std::erase_if(part.cell_fields, [&](const CellField& field) { return !is_kept(field); });
      part.entities.clear();
    }
  }

  // Equal numbers of tets for each rank, in their order.
  void deal() {
    std::vector<std::int64_t> firsts(mesh_.part_count() + 1, 0);
    for (const PartId id : mesh_.local())
      firsts[id.value + 1] = static_cast<std::int64_t>(mesh_.parts.at(id).mesh.cell_count());
    work_.sum(firsts);
    std::partial_sum(firsts.begin(), firsts.end(), firsts.begin());
    if (firsts.back() == 0) throw Error(ErrorCode::InputUnsuitable, "the mesh has no tetrahedra");
    if (firsts.back() / work_.rank_count() >= CellPlace::kMaxTets)
      throw Error(ErrorCode::InputUnsuitable, "the mesh has too many tetrahedra");
    slice_.first_tets = equal_ranges(static_cast<std::size_t>(firsts.back()), ranks());
    PerPart<Destinations> to_rank(mesh_.part_count(), mesh_.local());
    for (const PartId id : mesh_.local()) {
      const auto count = static_cast<std::size_t>(firsts[id.value + 1] - firsts[id.value]);
      std::uint32_t rank = 0;
      for (std::size_t tet = 0; tet < count; ++tet) {
        const Number number = slice_.first_tets[0] + static_cast<Number>(firsts[id.value]) + tet;
        while (slice_.first_tets[rank + 1] <= number) ++rank;
        to_rank.at(id).push_back(rank);
      }
    }
    migrate(mesh_, std::move(to_rank), ranks(), work_.runner());
  }

  void find_ghosts() {
    const PartId self(static_cast<std::size_t>(work_.rank()));
    ghosted_ = std::move(add_ghosts(std::move(mesh_), 1, work_.runner()).at(self));
    give_back_free_memory();
  }

  void number_verts() {
    std::vector<std::uint32_t>& order = order_;
    order.resize(part().vertex_count());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::sort(order, {}, [&](std::uint32_t v) { return part().vert_to_global[v]; });
    std::vector<std::uint64_t> ids;
    ids.reserve(order.size());
    for (const std::uint32_t v : order) ids.push_back(part().vert_to_global[v]);
    part().vert_to_global.release();
    slice_.to_vert_number = number_ids(ids, slice_.vert_count, work_);
    for (Number& number : slice_.to_vert_number) number += first_number();
    to_local_.resize(order.size());
    for (std::uint32_t i = 0; i < order.size(); ++i) to_local_[order[i]] = i;
  }

  void take_points() {
    Mesh& mesh = slice_.mesh;
    mesh.points.reserve(order_.size()), mesh.point_to_entity.reserve(order_.size());
    for (const std::uint32_t v : order_) {
      mesh.points.push_back(part().points[v]), mesh.point_to_entity.push_back(part().vert_to_entity[v].unpack());
      slice_.is_own.push_back(v < ghosted_.own_vertices ? 1 : 0);
    }
    part().points.release(), part().vert_to_entity.release();
    const auto take = [&](const VertexField& field, const auto& add) {
      const auto n = static_cast<std::size_t>(field.components);
      for (const std::uint32_t v : order_) add(field.values.data() + v * n);
    };
    take(part().vertex_fields.back(), [&](const double* m) { slice_.metric.logs.push_back(tensor_at(m)); });
    part().vertex_fields.pop_back();
    for (VertexField& field : part().vertex_fields) {
      MeshField& made = mesh.point_fields.emplace_back(MeshField{field.name, field.components, {}});
      take(field, [&](const double* x) { made.values.insert(made.values.end(), x, x + field.components); });
      field.values.release();
    }
  }

  // Ghosts stand behind own tets, by sender and ascending.
  void take_tets() {
    const PartId self(static_cast<std::size_t>(work_.rank()));
    const auto& ghosts = ghosted_.ghost_cells[0];
    const std::size_t own = ghosted_.own_cells[0];
    const auto before =
        static_cast<std::size_t>(std::ranges::count_if(ghosts, [&](const Copy& ghost) { return ghost.part < self; }));
    const CellBlock& block = part().block(CellKind::Tet);
    for (const CellField& field : part().cell_fields)
      slice_.mesh.cell_fields.push_back({field.name, field.components, {}});
    const auto take = [&](std::size_t begin, std::size_t end) {
      for (std::size_t f = 0; f < part().cell_fields.size(); ++f) {
        const CellField& field = part().cell_fields[f];
        const auto n = static_cast<std::size_t>(field.components);
        const double* const values = field.values[static_cast<std::size_t>(CellKind::Tet)].data();
        std::vector<double>& taken = slice_.mesh.cell_fields[f].values;
        taken.insert(taken.end(), values + begin * n, values + end * n);
      }
      for (std::size_t tet = begin; tet < end; ++tet) {
        const std::uint32_t* v = &block.to_vert[tet * 4];
        slice_.mesh.tet_to_vert.push_back({to_local_[v[0]], to_local_[v[1]], to_local_[v[2]], to_local_[v[3]]});
        slice_.mesh.tet_to_entity.push_back(block.to_region[tet]);
        const Copy place = tet < own ? Copy{self, static_cast<std::uint32_t>(tet)} : ghosts[tet - own];
        slice_.to_tet_number.push_back(slice_.first_tets[place.part.value] + place.local);
      }
    };
    slice_.mesh.tet_to_vert.reserve(block.size()), slice_.mesh.tet_to_entity.reserve(block.size());
    slice_.begin = before, slice_.end = before + own;
    take(own, own + before), take(0, own), take(own + before, block.size());
    part().block(CellKind::Tet) = CellBlock();
  }

  template <class Elements>
  void take_boundary(BoundaryKind kind, Elements& elements, std::vector<std::uint32_t>& entities) {
    const BoundaryBlock& block = part().block(kind);
    for (std::size_t i = 0; i < block.size(); ++i) {
      typename Elements::value_type verts;
      std::copy_n(&block.to_vert[i * verts.size()], verts.size(), verts.begin());
      if (std::ranges::none_of(verts, [&](std::uint32_t v) { return v < ghosted_.own_vertices; })) continue;
      for (std::uint32_t& v : verts) v = to_local_[v];
      elements.push_back(verts), entities.push_back(block.to_entity[i]);
    }
  }

  PartitionedMesh mesh_;
  const SharedWork& work_;
  GhostedPart ghosted_;
  std::vector<std::uint32_t> order_, to_local_;  // vertices of the part by global id, and the other way round
  MeshSlice slice_;
};

}  // namespace

MeshWithMetric gather_parts(PartitionedMesh&& mesh, PerPart<MetricField>&& metric, const SharedWork& work) {
  add_metric(mesh, std::move(metric));
  MeshWithMetric whole{copy_to_all(std::move(mesh), work), {}};
  const std::vector<double>& values = whole.mesh.point_fields.back().values;
  for (std::size_t i = 0; i < values.size(); i += kTensorEntries) whole.metric.logs.push_back(tensor_at(&values[i]));
  whole.mesh.point_fields.pop_back();
  return whole;
}

MeshSlice slice_of(PartitionedMesh&& mesh, PerPart<MetricField>&& metric, const std::vector<std::string>& fields,
                   const SharedWork& work) {
  return PartSlicer(std::move(mesh), work).run(std::move(metric), fields);
}

}  // namespace tetloom::adapt
