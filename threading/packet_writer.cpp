#include <algorithm>
#include <numeric>

#include "threading/packet_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

void put_text(MessageWriter& writer, const std::string& text) {
  writer.put_array(std::span<const char>(text.data(), text.size()));
}

void put_entity(MessageWriter& writer, const PartEntity& entity) {
  writer.put(PackedEntity(entity.entity));
  writer.put(entity.has_attributes);
  put_text(writer, entity.attributes.name);
  writer.put(entity.attributes.color.has_value());
  writer.put(entity.attributes.color.value_or(Color{}));
  put_text(writer, entity.attributes.layer);
  writer.put(entity.attributes.tolerance);
  writer.put(entity.sides);
}

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
  void compact() {
    std::sort(entities_.begin(), entities_.end());
    entities_.erase(std::unique(entities_.begin(), entities_.end()), entities_.end());
  }
  std::vector<PackedEntity> entities_;
};

PackedEntity pack_entity(int dim, std::uint32_t index) {
  return index == kNone ? PackedEntity() : PackedEntity(ModelEntity(dim, index));
}

}  // namespace

// Boundary elements by their lowest vertex. Elements of all kinds are numbered one after the other.
struct PartPacker::BoundaryIndex {
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
      keys[at] = key_of(verts);
    });
  }

  static FaceKey key_of(std::span<const std::uint32_t> verts) {
    FaceKey key{kNone, kNone, kNone, kNone};
    std::copy(verts.begin(), verts.end(), key.begin());
    std::sort(key.begin(), key.end());
    return key;
  }

  // Calls visit(number) for the elements with exactly these vertices.
  template <class Visit>
  void find(std::span<const std::uint32_t> verts, const Visit& visit) const {
    const FaceKey key = key_of(verts);
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

PartPacker::PartPacker(const Part& part, const Destinations& destinations, std::size_t part_count) : part_(part) {
  if (destinations.size() != part.mesh.cell_count())
    throw Error(ErrorCode::InvalidArgument, "a list of destinations is not as long as its part has cells");
  sort_by_destination(destinations, part_count);
  index_ = std::make_shared<const BoundaryIndex>(part.mesh);
  shared_.assign(part.mesh.vertex_count(), false);
  for (const std::uint32_t v : part.boundary.vertices.entities) shared_[v] = true;
}

void PartPacker::sort_by_destination(const Destinations& destinations, std::size_t part_count) {
  std::vector<std::uint32_t> counts(part_count, 0);
  for (const std::uint32_t part : destinations) {
    if (part >= part_count) throw Error(ErrorCode::InvalidArgument, "a cell's destination is not one of the parts");
    ++counts[part];
  }
  std::vector<std::uint32_t> filled(part_count, 0);
  std::uint32_t begin = 0;
  for (std::size_t part = 0; part < part_count; ++part) {
    if (counts[part] == 0) continue;
    receivers_.push_back(PartId(part));
    first_.push_back(begin);
    filled[part] = begin;
    begin += counts[part];
  }
  first_.push_back(begin);
  order_.resize(destinations.size());
  for (std::uint32_t cell = 0; cell < destinations.size(); ++cell) order_[filled[destinations[cell]]++] = cell;
}

Bytes PartPacker::pack(std::size_t k, Scratch& scratch) const {
  const PartMesh& part = part_.mesh;
  const std::span<const std::uint32_t> order(order_.data() + first_[k], cell_count(k));
  if (scratch.local.empty()) {
    scratch.local.assign(part.vertex_count(), kNone);
    scratch.taken.assign(part.boundary[0].size() + part.boundary[1].size() + part.boundary[2].size(), false);
  }
  EntitySet entities;
  MessageWriter writer;
  writer.reserve(order.size() * 40 + 4096);
  std::size_t begin = 0;
  std::size_t kind_begin = 0;
  for (const CellKind kind : kAllCellKinds) {
    const CellBlock& block = part.block(kind);
    const CellShape& shape = shape_of(kind);
    const auto is_before = [&](std::uint32_t cell) { return cell < kind_begin + block.size(); };
    const std::size_t count =
        static_cast<std::size_t>(
            std::partition_point(order.begin() + static_cast<std::ptrdiff_t>(begin), order.end(), is_before) -
            order.begin()) -
        begin;
    const auto cells = order.subspan(begin, count);
    std::uint32_t* out = writer.put_room<std::uint32_t>(count * shape.vertex_count).data();
    for (const std::uint32_t cell : cells) {
      const std::uint32_t* verts = block.to_vert.data() + (cell - kind_begin) * shape.vertex_count;
      for (std::uint32_t i = 0; i < shape.vertex_count; ++i) {
        std::uint32_t& local = scratch.local[verts[i]];
        if (local == kNone) {
          local = static_cast<std::uint32_t>(scratch.verts.size());
          scratch.verts.push_back(verts[i]);
        }
        *out++ = local;
      }
      for_each_boundary_element_of(*index_, shape, verts, [&](std::uint32_t element) {
        if (scratch.taken[element]) return;
        scratch.taken[element] = true;
        scratch.boundary.push_back(element);
      });
    }
    const std::span<std::uint32_t> regions = writer.put_room<std::uint32_t>(count);
    for (std::size_t i = 0; i < count; ++i) {
      regions[i] = block.to_region[cells[i] - kind_begin];
      entities.add(pack_entity(3, regions[i]));
    }
    for (const CellField& field : part.cell_fields) {
      const auto n = static_cast<std::size_t>(field.components);
      const auto& values = field.values[static_cast<std::size_t>(kind)];
      double* room = writer.put_room<double>(count * n).data();
      for (const std::uint32_t cell : cells) room = std::copy_n(values.data() + (cell - kind_begin) * n, n, room);
    }
    begin += count;
    kind_begin += block.size();
  }

  const auto gather = [&]<class T>(const GrowingArray<T>& values) {
    T* room = writer.put_room<T>(scratch.verts.size()).data();
    for (const std::uint32_t v : scratch.verts) *room++ = values[v];
  };
  gather(part.points);
  gather(part.vert_to_entity);
  gather(part.vert_to_global);
  std::uint8_t* shared = writer.put_room<std::uint8_t>(scratch.verts.size()).data();
  for (const std::uint32_t v : scratch.verts) {
    *shared++ = shared_[v];
    entities.add(part.vert_to_entity[v]);
  }
  for (const VertexField& field : part.vertex_fields) {
    const auto n = static_cast<std::size_t>(field.components);
    double* room = writer.put_room<double>(scratch.verts.size() * n).data();
    for (const std::uint32_t v : scratch.verts) room = std::copy_n(field.values.data() + v * n, n, room);
  }

  std::sort(scratch.boundary.begin(), scratch.boundary.end());
  begin = 0;
  kind_begin = 0;
  for (std::size_t kind = 0; kind < part.boundary.size(); ++kind) {
    const BoundaryBlock& block = part.boundary[kind];
    std::size_t end = begin;
    while (end < scratch.boundary.size() && scratch.boundary[end] < kind_begin + block.size()) ++end;
    const std::uint32_t n = kBoundaryVertexCount[kind];
    std::uint32_t* out = writer.put_room<std::uint32_t>((end - begin) * n).data();
    for (std::size_t i = begin; i < end; ++i)
      for (std::uint32_t j = 0; j < n; ++j)
        *out++ = scratch.local[block.to_vert[(scratch.boundary[i] - kind_begin) * n + j]];
    const auto indices = writer.put_room<std::uint32_t>(end - begin);
    for (std::size_t i = begin; i < end; ++i) {
      indices[i - begin] = block.to_entity[scratch.boundary[i] - kind_begin];
      entities.add(pack_entity(kind == 0 ? 1 : 2, indices[i - begin]));
    }
    begin = end;
    kind_begin += block.size();
  }

  std::vector<const PartEntity*> known;
  for (const PackedEntity entity : entities.sorted()) {
    const auto it = std::lower_bound(part.entities.begin(), part.entities.end(), entity.unpack(),
                                     [](const PartEntity& a, ModelEntity b) { return a.entity < b; });
    if (it != part.entities.end() && it->entity == entity.unpack()) known.push_back(&*it);
  }
  writer.put(static_cast<std::uint64_t>(known.size()));
  for (const PartEntity* entity : known) put_entity(writer, *entity);

  for (const std::uint32_t v : scratch.verts) scratch.local[v] = kNone;
  for (const std::uint32_t element : scratch.boundary) scratch.taken[element] = false;
  scratch.verts.clear();
  scratch.boundary.clear();
  return writer.take();
}

}  // namespace tetloom::detail
