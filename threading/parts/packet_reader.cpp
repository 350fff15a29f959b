#include <algorithm>
#include <unordered_map>
#include <unordered_set>

#include "core/base/codec.hpp"
#include "core/part/adjacency.hpp"
#include "threading/parts/cell_packet.hpp"
#include "threading/parts/packet_detail.hpp"

namespace tetloom::detail {
namespace {

// A packet's arrays where they lie.
struct PacketView {
  std::array<PacketCells, kCellKinds> cells;
  std::array<std::vector<std::span<const double>>, kCellKinds> cell_values;
  PacketVerts verts;
  std::span<const PackedEntity> vert_entities;
  std::span<const std::uint8_t> shared;
  std::vector<std::span<const double>> vert_values;
  std::array<std::span<const std::uint32_t>, 3> boundary_verts, boundary_entities;
  std::vector<PartEntity> entities;
};

PacketView view_packet(MessageReader& reader, const PartitionedMesh& mesh) {
  PacketView view;
  for (std::size_t kind = 0; kind < kCellKinds; ++kind) {
    view.cells[kind] = PacketCells(reader);
    for (std::size_t f = 0; f < mesh.cell_fields.size(); ++f)
      view.cell_values[kind].push_back(reader.get_view<double>());
  }
  view.verts = PacketVerts(reader);
  view.vert_entities = reader.get_view<PackedEntity>();
  view.shared = reader.get_view<std::uint8_t>();
  for (std::size_t f = 0; f < mesh.vertex_fields.size(); ++f) view.vert_values.push_back(reader.get_view<double>());
  for (std::size_t kind = 0; kind < 3; ++kind) {
    view.boundary_verts[kind] = reader.get_view<std::uint32_t>();
    view.boundary_entities[kind] = reader.get_view<std::uint32_t>();
  }
  const auto count = reader.get<std::uint64_t>();
  for (std::uint64_t i = 0; i < count; ++i) view.entities.push_back(get_entity(reader));
  return view;
}

struct KeyHash {
  std::size_t operator()(const FaceKey& key) const {
    std::uint64_t hash = 0;
    for (const std::uint32_t v : key) hash = (hash ^ v) * 0x9e3779b97f4a7c15u;
    return static_cast<std::size_t>(hash ^ hash >> 32);
  }
};

class PartBuilder {
 public:
  // A part of packets alone. Where there is one, all its vertices are new.
  PartBuilder(const PartitionedMesh& mesh, bool several) : merge_(several ? Merge::OnPartBoundaries : Merge::Nothing) {
    for (const FieldInfo& info : mesh.vertex_fields) part_.vertex_fields.push_back({info.name, info.components, {}});
    for (const FieldInfo& info : mesh.cell_fields) part_.cell_fields.push_back({info.name, info.components, {}});
  }

  // A part that packets are added to.
  explicit PartBuilder(Part&& part) : merge_(Merge::Everything), part_(std::move(part.mesh)) {
    for (const std::uint32_t v : part.boundary.vertices.entities) shared_.emplace(part_.vert_to_global[v], v);
    for (std::size_t kind = 0; kind < 3; ++kind) {
      const std::size_t n = kBoundaryVertexCount[kind];
      const auto verts = part_.boundary[kind].to_vert.span();
      for (std::size_t i = 0; i < verts.size(); i += n) is_new_element(verts.subspan(i, n));
    }
  }

  void reserve(std::span<const PacketView> packets) {
    std::size_t verts = 0;
    std::array<std::size_t, kCellKinds> cells{};
    for (const PacketView& packet : packets) {
      verts += packet.verts.size();
      for (std::size_t kind = 0; kind < kCellKinds; ++kind) cells[kind] += packet.cells[kind].size();
    }
    part_.points.reserve(verts);
    part_.vert_to_entity.reserve(verts);
    part_.vert_to_global.reserve(verts);
    for (std::size_t kind = 0; kind < kCellKinds; ++kind) {
      part_.cells[kind].to_vert.reserve(cells[kind] * shape_of(kAllCellKinds[kind]).vertex_count);
      part_.cells[kind].to_region.reserve(cells[kind]);
    }
  }

  void add(const PacketView& packet) {
    add_vertices(packet);
    for (std::size_t kind = 0; kind < kCellKinds; ++kind) add_cells(packet, kind);
    for (std::size_t kind = 0; kind < 3; ++kind) add_boundary(packet, kind);
    part_.entities.insert(part_.entities.end(), packet.entities.begin(), packet.entities.end());
  }

  /// The numbers in the part of the vertices of the last packet.
  std::span<const std::uint32_t> locals() const { return local_; }

  PartMesh take() {
    std::stable_sort(part_.entities.begin(), part_.entities.end(),
                     [](const PartEntity& a, const PartEntity& b) { return a.entity < b.entity; });
    const auto same = [](const PartEntity& a, const PartEntity& b) { return a.entity == b.entity; };
    part_.entities.erase(std::unique(part_.entities.begin(), part_.entities.end(), same), part_.entities.end());
    part_.points.shrink_to_fit();
    part_.vert_to_entity.shrink_to_fit();
    part_.vert_to_global.shrink_to_fit();
    for (VertexField& field : part_.vertex_fields) field.values.shrink_to_fit();
    for (CellField& field : part_.cell_fields)
      for (auto& values : field.values) values.shrink_to_fit();
    for (BoundaryBlock& block : part_.boundary) {
      block.to_vert.shrink_to_fit();
      block.to_entity.shrink_to_fit();
    }
    return std::move(part_);
  }

 private:
  // Which vertices may be there already: none, those that lay on a part boundary before, or any.
  enum class Merge { Nothing, OnPartBoundaries, Everything };

  bool may_be_known(const PacketView& packet, std::size_t vert) const {
    return merge_ == Merge::Everything || (merge_ == Merge::OnPartBoundaries && packet.shared[vert] != 0);
  }

  void add_vertices(const PacketView& packet) {
    local_.resize(packet.verts.size());
    for (std::size_t i = 0; i < local_.size(); ++i) {
      if (may_be_known(packet, i)) {
        const auto next = static_cast<std::uint32_t>(part_.vertex_count());
        const auto [it, is_new] = shared_.try_emplace(packet.verts.keys[i], next);
        local_[i] = it->second;
        if (!is_new) continue;
      } else {
        local_[i] = static_cast<std::uint32_t>(part_.vertex_count());
      }
      part_.points.push_back(packet.verts.points[i]);
      part_.vert_to_entity.push_back(packet.vert_entities[i]);
      part_.vert_to_global.push_back(packet.verts.keys[i]);
      for (std::size_t f = 0; f < part_.vertex_fields.size(); ++f) {
        VertexField& field = part_.vertex_fields[f];
        const auto n = static_cast<std::size_t>(field.components);
        field.values.append(packet.vert_values[f].subspan(i * n, n));
      }
    }
  }

  void add_cells(const PacketView& packet, std::size_t kind) {
    CellBlock& block = part_.cells[kind];
    const PacketCells& cells = packet.cells[kind];
    const std::size_t before = block.to_vert.size();
    block.to_vert.resize_for_overwrite(before + cells.to_place.size());
    cells.put_verts(local_, 0, cells.size(), block.to_vert.data() + before);
    block.to_region.append(cells.to_region);
    for (std::size_t f = 0; f < part_.cell_fields.size(); ++f)
      part_.cell_fields[f].values[kind].append(packet.cell_values[kind][f]);
  }

  void add_boundary(const PacketView& packet, std::size_t kind) {
    BoundaryBlock& block = part_.boundary[kind];
    const std::size_t n = kBoundaryVertexCount[kind];
    for (std::size_t i = 0; i < packet.boundary_entities[kind].size(); ++i) {
      std::array<std::uint32_t, 4> verts{};
      bool known = true;
      for (std::size_t j = 0; j < n; ++j) {
        const std::uint32_t v = packet.boundary_verts[kind][i * n + j];
        verts[j] = local_[v];
        known = known && may_be_known(packet, v);
      }
      if (known && !is_new_element(std::span(verts).first(n))) continue;
      block.to_vert.append(std::span<const std::uint32_t>(verts).first(n));
      block.to_entity.push_back(packet.boundary_entities[kind][i]);
    }
  }

  bool is_new_element(std::span<const std::uint32_t> verts) { return elements_.insert(key_of_verts(verts)).second; }

  const Merge merge_;
  PartMesh part_;
  std::vector<std::uint32_t> local_;                         // of the vertices of the packet at hand
  std::unordered_map<std::uint64_t, std::uint32_t> shared_;  // local vertex by global id; never walked through
  std::unordered_set<FaceKey, KeyHash> elements_;            // on old part boundaries; never walked through
};

}  // namespace

PartEntity get_entity(MessageReader& reader) {
  PartEntity entity;
  entity.entity = reader.get<PackedEntity>().unpack();
  entity.has_attributes = reader.get<bool>();
  entity.attributes.name = get_text(reader);
  const bool has_color = reader.get<bool>();
  const Color color = reader.get<Color>();
  if (has_color) entity.attributes.color = color;
  entity.attributes.layer = get_text(reader);
  entity.attributes.group = get_text(reader);
  entity.attributes.tolerance = reader.get<double>();
  entity.sides = reader.get<FaceSides>();
  return entity;
}

PartMesh merge_packets(std::span<Message> packets, const PartitionedMesh& mesh) {
  std::vector<PacketView> views;
  for (const Message& packet : packets) {
    MessageReader reader(packet.bytes);
    views.push_back(view_packet(reader, mesh));
  }
  PartBuilder builder(mesh, packets.size() > 1);
  builder.reserve(views);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    builder.add(views[i]);
    packets[i].bytes = Bytes();
  }
  return builder.take();
}

PartMesh merge_packets(std::size_t count, const std::function<Bytes(std::size_t)>& next, const PartitionedMesh& mesh) {
  PartBuilder builder(mesh, count > 1);
  for (std::size_t i = 0; i < count; ++i) {
    const Bytes bytes = next(i);
    MessageReader reader(bytes);
    builder.add(view_packet(reader, mesh));
  }
  return builder.take();
}

PartMesh unpack_part(std::span<Message> packets, const PartitionedMesh& mesh) {
  PartMesh part = merge_packets(packets, mesh);
  connect_cells(part);
  return part;
}

PartMesh extend_part(Part&& part, std::span<Message> messages, const PartitionedMesh& mesh,
                     const std::function<void(const AddedPacket&)>& visit) {
  PartBuilder builder(std::move(part));
  for (Message& message : messages) {
    MessageReader reader(message.bytes);
    const PacketView packet = view_packet(reader, mesh);
    builder.add(packet);
    std::array<std::size_t, kCellKinds> cells{};
    for (std::size_t kind = 0; kind < kCellKinds; ++kind) cells[kind] = packet.cells[kind].size();
    visit({message.from, cells, builder.locals(), reader});
    message.bytes = Bytes();
  }
  return builder.take();
}

}  // namespace tetloom::detail
