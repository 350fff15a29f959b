#include <algorithm>
#include <numeric>

#include "core/base/codec.hpp"
#include "core/base/lists.hpp"
#include "core/part/adjacency.hpp"
#include "threading/parts/cell_packet.hpp"
#include "threading/parts/packet_detail.hpp"

namespace tetloom::detail {
namespace {

// Collects values of which most are the same as the one before.
class EntitySet {
 public:
  void add(PackedEntity entity) {
    if (entities_.empty() || entities_.back() != entity) entities_.push_back(entity);
    if (entities_.size() > 4096) compact();
  }
  const std::vector<PackedEntity>& sorted() {
    compact();
    return entities_;
  }

 private:
  void compact() { sort_unique(entities_); }
  std::vector<PackedEntity> entities_;
};

PackedEntity pack_entity(int dim, std::uint32_t index) {
  return index == kNone ? PackedEntity() : PackedEntity(ModelEntity(dim, index));
}

}  // namespace

void put_entity(MessageWriter& writer, const PartEntity& entity) {
  writer.put(PackedEntity(entity.entity));
  writer.put(entity.has_attributes);
  put_text(writer, entity.attributes.name);
  writer.put(entity.attributes.color.has_value());
  writer.put(entity.attributes.color.value_or(Color{}));
  put_text(writer, entity.attributes.layer);
  put_text(writer, entity.attributes.group);
  writer.put(entity.attributes.tolerance);
  writer.put(entity.sides);
}

// Boundary elements by their lowest vertex. Elements of all kinds are numbered one after the other.
struct CellPacker::BoundaryIndex {
  explicit BoundaryIndex(const PartMesh& part) : first(part.vertex_count() + 1, 0), used(part.vertex_count(), false) {
    const auto for_each_element = [&](const auto& visit) {
      std::uint32_t number = 0;
      for (std::size_t kind = 0; kind < part.boundary.size(); ++kind) {
        const std::uint32_t* verts = part.boundary[kind].to_vert.data();
        for (std::size_t i = 0; i < part.boundary[kind].size(); ++i, verts += kBoundaryVertexCount[kind])
          visit(number++, std::span(verts, kBoundaryVertexCount[kind]));
      }
    };
    for_each_element([&](std::uint32_t, std::span<const std::uint32_t> verts) {
      ++first[*std::min_element(verts.begin(), verts.end()) + 1];
      for (const std::uint32_t v : verts) used[v] = true;
    });
    std::partial_sum(first.begin(), first.end(), first.begin());
    std::vector<std::uint32_t> filled(first.begin(), first.end() - 1);
    numbers.resize(first.back());
    keys.resize(first.back());
    for_each_element([&](std::uint32_t number, std::span<const std::uint32_t> verts) {
      const std::uint32_t at = filled[*std::min_element(verts.begin(), verts.end())]++;
      numbers[at] = number;
      keys[at] = key_of_verts(verts);
    });
  }

  // Calls visit(number) for the elements with exactly these vertices.
  template <class Visit>
  void find(std::span<const std::uint32_t> verts, const Visit& visit) const {
    const FaceKey key = key_of_verts(verts);
    for (std::uint32_t i = first[key[0]]; i < first[key[0] + 1]; ++i)
      if (keys[i] == key) visit(numbers[i]);
  }

  std::vector<std::uint32_t> first, numbers;
  std::vector<FaceKey> keys;
  std::vector<bool> used;  // vertices of boundary elements
};

namespace {

// Calls visit(number) for the boundary elements that are faces or edges of a cell.
template <class Index, class Visit>
void for_each_boundary_element_of(const Index& index, const CellShape& shape, const std::uint32_t* verts,
                                  const Visit& visit) {
  std::uint32_t on_boundary = 0;
  for (std::uint32_t i = 0; i < shape.vertex_count; ++i)
    on_boundary |= static_cast<std::uint32_t>(index.used[verts[i]]) << i;
  if ((on_boundary & (on_boundary - 1)) == 0) return;
  for (const auto& edge : shape.edges()) {
    if ((on_boundary >> edge[0] & on_boundary >> edge[1] & 1) == 0) continue;
    index.find(std::array{verts[edge[0]], verts[edge[1]]}, visit);
  }
  for (const LocalFace& face : shape.faces()) {
    std::array<std::uint32_t, 4> face_verts;
    bool all = true;
    for (std::uint32_t i = 0; i < face.count; ++i) {
      face_verts[i] = verts[face.vert[i]];
      all = all && (on_boundary >> face.vert[i] & 1) != 0;
    }
    if (all) index.find(std::span(face_verts).first(face.count), visit);
  }
}

}  // namespace

CellPacker::CellPacker(const Part& part)
    : part_(part), index_(std::make_shared<const BoundaryIndex>(part.mesh)), shared_(part.mesh.vertex_count(), false) {
  for (const std::uint32_t v : part.boundary.vertices.entities) shared_[v] = true;
}

SortedCells sort_by_destination(const Destinations& destinations, std::size_t part_count) {
  std::vector<std::uint32_t> counts(part_count, 0), filled(part_count, 0);
  for (const std::uint32_t part : destinations) {
    if (part >= part_count) throw Error(ErrorCode::InvalidArgument, "a cell's destination is not one of the parts");
    ++counts[part];
  }
  SortedCells sorted;
  std::uint32_t begin = 0;
  for (std::size_t part = 0; part < part_count; ++part) {
    if (counts[part] == 0) continue;
    sorted.receivers.push_back(PartId(part));
    sorted.first.push_back(begin);
    filled[part] = begin;
    begin += counts[part];
  }
  sorted.first.push_back(begin);
  sorted.cells.resize(destinations.size());
  for (std::uint32_t cell = 0; cell < destinations.size(); ++cell) sorted.cells[filled[destinations[cell]]++] = cell;
  return sorted;
}

// Writes one packet: cells, then the vertices that they use, then boundary elements and model entities.
class CellPacker::PacketWriter {
 public:
  PacketWriter(const CellPacker& packer, Scratch& scratch, MessageWriter& writer)
      : part_(packer.part_.mesh), shared_(packer.shared_), index_(*packer.index_), scratch_(scratch), writer_(writer) {
    scratch_.verts.set_item_count(part_.vertex_count());
    scratch_.elements.set_item_count(part_.boundary[0].size() + part_.boundary[1].size() + part_.boundary[2].size());
  }
  // The scratch is clean again for the next packet.
  ~PacketWriter() { scratch_.verts.clear(), scratch_.elements.clear(); }
  PacketWriter(const PacketWriter&) = delete;
  PacketWriter& operator=(const PacketWriter&) = delete;

  // Pre: cells ascend.
  void write(std::span<const std::uint32_t> cells) {
    writer_.reserve(cells.size() * kBytesPerCell + 4096);
    std::uint32_t begin = 0;
    for (const CellKind kind : kAllCellKinds) {
      const auto end = begin + static_cast<std::uint32_t>(part_.block(kind).size());
      const auto count = std::lower_bound(cells.begin(), cells.end(), end) - cells.begin();
      put_cells(kind, begin, cells.first(static_cast<std::size_t>(count)));
      cells = cells.subspan(static_cast<std::size_t>(count));
      begin = end;
    }
    put_vertices();
    put_boundary();
    put_entities();
  }

 private:
  // Room for a tet and its share of vertices; what is reserved and not used takes no memory.
  static constexpr std::size_t kBytesPerCell = 40;

  void put_cells(CellKind kind, std::uint32_t begin, std::span<const std::uint32_t> cells) {
    const CellBlock& block = part_.block(kind);
    const CellShape& shape = shape_of(kind);
    put_packet_cells(writer_, block, shape.vertex_count, cells, begin,
                     [&](std::uint32_t v) { return scratch_.verts.add(v); });
    for (const std::uint32_t cell : cells) {
      for_each_boundary_element_of(index_, shape, block.to_vert.data() + std::size_t{cell - begin} * shape.vertex_count,
                                   [&](std::uint32_t element) { scratch_.elements.add(element); });
      entities_.add(pack_entity(3, block.to_region[cell - begin]));
    }
    for (const CellField& field : part_.cell_fields) {
      const auto n = static_cast<std::size_t>(field.components);
      const auto& values = field.values[static_cast<std::size_t>(kind)];
      double* room = writer_.put_room<double>(cells.size() * n).data();
      for (const std::uint32_t cell : cells) room = std::copy_n(values.data() + (cell - begin) * n, n, room);
    }
  }

  void put_vertices() {
    const std::span<const std::uint32_t> verts = scratch_.verts.items();
    put_packet_verts(writer_, verts, part_.points, [&](std::uint32_t v) { return part_.vert_to_global[v]; });
    writer_.put_each(verts, [&](std::uint32_t v) { return part_.vert_to_entity[v]; });
    writer_.put_each(verts, [&](std::uint32_t v) { return std::uint8_t{shared_[v]}; });
    for (const std::uint32_t v : verts) entities_.add(part_.vert_to_entity[v]);
    for (const VertexField& field : part_.vertex_fields) {
      const auto n = static_cast<std::size_t>(field.components);
      double* room = writer_.put_room<double>(verts.size() * n).data();
      for (const std::uint32_t v : verts) room = std::copy_n(field.values.data() + v * n, n, room);
    }
  }

  void put_boundary() {
    scratch_.elements.sort();
    std::span<const std::uint32_t> elements = scratch_.elements.items();
    std::uint32_t begin = 0;
    for (std::size_t kind = 0; kind < part_.boundary.size(); ++kind) {
      const auto end = begin + static_cast<std::uint32_t>(part_.boundary[kind].size());
      const auto count = std::lower_bound(elements.begin(), elements.end(), end) - elements.begin();
      put_elements(kind, begin, elements.first(static_cast<std::size_t>(count)));
      elements = elements.subspan(static_cast<std::size_t>(count));
      begin = end;
    }
  }

  void put_elements(std::size_t kind, std::uint32_t begin, std::span<const std::uint32_t> elements) {
    const BoundaryBlock& block = part_.boundary[kind];
    const std::uint32_t n = kBoundaryVertexCount[kind];
    std::uint32_t* out = writer_.put_room<std::uint32_t>(elements.size() * n).data();
    for (const std::uint32_t element : elements)
      for (std::uint32_t j = 0; j < n; ++j)
        *out++ = scratch_.verts[block.to_vert[std::size_t{element - begin} * n + j]];
    std::uint32_t* entity = writer_.put_room<std::uint32_t>(elements.size()).data();
    for (const std::uint32_t element : elements) {
      *entity = block.to_entity[element - begin];
      entities_.add(pack_entity(kind == 0 ? 1 : 2, *entity++));
    }
  }

  void put_entities() {
    std::vector<const PartEntity*> known;
    for (const PackedEntity entity : entities_.sorted()) {
      const auto it = std::lower_bound(part_.entities.begin(), part_.entities.end(), entity.unpack(),
                                       [](const PartEntity& a, ModelEntity b) { return a.entity < b; });
      if (it != part_.entities.end() && it->entity == entity.unpack()) known.push_back(&*it);
    }
    writer_.put(static_cast<std::uint64_t>(known.size()));
    for (const PartEntity* entity : known) put_entity(writer_, *entity);
  }

  const PartMesh& part_;
  const std::vector<bool>& shared_;
  const BoundaryIndex& index_;
  Scratch& scratch_;
  MessageWriter& writer_;
  EntitySet entities_;
};

void CellPacker::pack(std::span<const std::uint32_t> cells, Scratch& scratch, MessageWriter& writer,
                      std::vector<std::uint32_t>* verts) const {
  PacketWriter packet(*this, scratch, writer);
  packet.write(cells);
  if (verts != nullptr) verts->assign(scratch.verts.items().begin(), scratch.verts.items().end());
}

}  // namespace tetloom::detail
