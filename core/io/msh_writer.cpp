// Gmsh 4.1, binary (Gmsh reference manual, "MSH file format"). Node and element tags follow the order of the mesh, so
// that it comes back although the format wants blocks by entity. Every entity is a physical group of its own tag,
// which carries its name; the sides of faces are the signed bounding surfaces of the volumes. Fields are views with one
// time step.
#include <array>
#include <limits>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include "core/base/grain.hpp"
#include "core/io/formats_detail.hpp"
#include "core/io/msh_detail.hpp"
#include "core/io/tag_blocks_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kLongestName = 255;

std::int32_t checked_tag(std::uint32_t index) {
  const std::uint32_t tag = tag_of_index(index);
  if (tag > static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorCode::InvalidArgument,
                "a model entity has the tag " + std::to_string(tag) + ", which the MSH format cannot hold");
  return static_cast<std::int32_t>(tag);
}

class MshWriter {
 public:
  MshWriter(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop)
      : mesh_(mesh), file_(file), loop_(loop), nodes_(mesh) {
    top_dimension_ = cell_count(mesh) > 0 ? 3 : surface_count(mesh) > 0 ? 2 : 1;
    for (int dim = 0; dim < 4; ++dim)
      points_[dim] = make_tag_blocks(mesh.points.size(), loop, [&](std::size_t i) { return point_tag(i, dim); });
    for_each_block(mesh, [&](Block block, const auto&, const auto& entities) {
      elements_[static_cast<std::size_t>(block)] = element_blocks(entities);
    });
    find_entities();
    number_groups();
  }

  /// From here on points and elements lie on entities of their parts.
  void deal(const MeshParts& parts) {
    part_count_ = parts.count;
    const MshOwners owners = find_owners(mesh_, parts, loop_);
    for (int dim = 0; dim < 4; ++dim) {
      collect_pieces(points_[dim], owners.of_points, pieces_[dim]);
      for (std::size_t block = 0; block < kBlocks; ++block)
        if (dimension_of(static_cast<Block>(block)) == dim)
          collect_pieces(elements_[block], owners.of_elements[block], pieces_[dim]);
      number_pieces(dim);
      points_[dim] = make_tag_blocks(mesh_.points.size(), loop_, [&](std::size_t i) {
        const std::int32_t tag = point_tag(i, dim);
        return tag < 0 ? tag : pieces_[dim].at({tag, owners.of_points[i]});
      });
    }
    for_each_block(mesh_, [&](Block block, const auto&, const auto& entities) {
      const auto& part_of = owners.of_elements[static_cast<std::size_t>(block)];
      elements_[static_cast<std::size_t>(block)] = make_tag_blocks(entities.size(), loop_, [&](std::size_t i) {
        return pieces_[dimension_of(block)].at({checked_tag(entities[i]), part_of[i]});
      });
    });
  }

  void write() {
    file_.write("$MeshFormat\n4.1 1 8\n");
    file_.put(std::int32_t{1});
    file_.write("\n$EndMeshFormat\n");
    file_.write("$Comments\n" + std::string(kMshSignature) + "\n$EndComments\n");
    write_names();
    write_entities();
    if (part_count_ > 0) write_pieces();
    write_nodes();
    write_elements();
    for (const MeshField& field : mesh_.point_fields) write_data("NodeData", field, 1, mesh_.points.size());
    for (const MeshField& field : mesh_.cell_fields)
      write_data("ElementData", field, 1 + mesh_.edge_to_vert.size() + surface_count(mesh_), cell_count(mesh_));
  }

 private:
  struct Entity {
    Box3 box;
    std::vector<std::int32_t> boundary;  // signed tags of faces, for regions
  };

  /// The tags of parts of entities of one dimension, by (tag, part).
  using Pieces = std::map<std::pair<std::int32_t, std::uint32_t>, std::int32_t>;

  TagBlocks element_blocks(const std::vector<std::uint32_t>& entities) const {
    return make_tag_blocks(entities.size(), loop_, [&](std::size_t i) { return checked_tag(entities[i]); });
  }

  /// Adds all (tag, part) of the items of `blocks`, without tags of their own as yet.
  void collect_pieces(const TagBlocks& blocks, const std::vector<std::uint32_t>& part_of, Pieces& pieces) const {
    for (std::size_t b = 0; b < blocks.tags.size(); ++b) {
      const auto find_parts = [&](std::size_t begin, std::size_t end, std::set<std::uint32_t>& parts) {
        for (const std::uint32_t item : blocks.items(b).subspan(begin, end - begin)) parts.insert(part_of[item]);
      };
      for (const auto& parts :
           map_blocks(loop_, blocks.items(b).size(), kCopyGrain, std::set<std::uint32_t>(), find_parts))
        for (const std::uint32_t part : parts) pieces.try_emplace({blocks.tags[b], part}, 0);
    }
  }

  /// The tag of point `i` among the entities of dimension `dim`, -1 when it lies on one of another dimension. Points
  /// without an entity lie on the entity 0 of the mesh's own dimension.
  std::int32_t point_tag(std::size_t i, int dim) const {
    const ModelEntity entity = entity_of_point(mesh_, i);
    if (!entity.valid()) return dim == top_dimension_ ? 0 : -1;
    return entity.dim == dim ? checked_tag(entity.index) : -1;
  }

  /// Adds the points that add_item(item, box) adds for all items of each block.
  template <class AddItem>
  void add_boxes(int dim, const TagBlocks& blocks, const AddItem& add_item) {
    for (std::size_t b = 0; b < blocks.tags.size(); ++b) {
      const auto add_items = [&](std::size_t begin, std::size_t end, Box3& box) {
        Box3 of_items;
        for (const std::uint32_t item : blocks.items(b).subspan(begin, end - begin)) add_item(item, of_items);
        box = of_items;
      };
      Box3& box = entities_[dim][blocks.tags[b]].box;
      for (const Box3& of_items : map_blocks(loop_, blocks.items(b).size(), kCopyGrain, Box3{}, add_items))
        unite(box, of_items);
    }
  }
  /// Also where coordinates that are not numbers have left some of the axes of `other` empty.
  static void unite(Box3& box, const Box3& other) {
    for (int axis = 0; axis < 3; ++axis) {
      if (other.lo[axis] < box.lo[axis]) box.lo[axis] = other.lo[axis];
      if (other.hi[axis] > box.hi[axis]) box.hi[axis] = other.hi[axis];
    }
  }

  void find_entities() {
    for (int dim = 0; dim < 4; ++dim)
      add_boxes(dim, points_[dim], [&](std::uint32_t point, Box3& box) { box.add(mesh_.points[point]); });
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) {
      add_boxes(dimension_of(block), elements_[static_cast<std::size_t>(block)], [&](std::uint32_t e, Box3& box) {
        for (const std::uint32_t v : elements[e]) box.add(mesh_.points[v]);
      });
    });
    for (const auto& [tag, face] : entities_[2]) {
      if (tag == 0 || static_cast<std::size_t>(tag) > mesh_.face_to_sides.size()) continue;
      const FaceSides& sides = mesh_.face_to_sides[static_cast<std::size_t>(tag) - 1];
      // The boundary of a volume is oriented outwards, so a face whose normal points into it counts backwards.
      if (sides.back.valid()) add_to_boundary(checked_tag(sides.back.value), tag, face.box);
      if (sides.front.valid()) add_to_boundary(checked_tag(sides.front.value), -tag, face.box);
    }
  }
  void add_to_boundary(std::int32_t region, std::int32_t signed_face, const Box3& box) {
    Entity& entity = entities_[3][region];
    entity.boundary.push_back(signed_face);
    entity.box.add(box);
  }

  std::string name_of(int dim, std::int32_t tag) const {
    const std::vector<EntityAttributes>& table = mesh_.entities[dim];
    if (tag == 0 || static_cast<std::size_t>(tag) > table.size()) return {};
    return printable(table[static_cast<std::size_t>(tag) - 1].name);
  }
  /// A name as the format can hold it: in one line, without quotes, not longer than Gmsh reads.
  static std::string printable(std::string name) {
    for (char& c : name)
      if (c == '"')
        c = '\'';
      else if (static_cast<unsigned char>(c) < ' ')
        c = ' ';
    if (name.size() > kLongestName) {
      std::size_t end = kLongestName;
      while (end > 0 && (static_cast<unsigned char>(name[end]) & 0xc0) == 0x80) --end;  // not inside of a character
      name.resize(end);
    }
    return name;
  }

  void write_names() {
    std::string lines;
    std::size_t count = 0;
    for (int dim = 0; dim < 4; ++dim)
      for (const auto& [tag, entity] : entities_[dim]) {
        const std::string name = name_of(dim, tag);
        if (name.empty()) continue;
        ++count;
        lines += std::to_string(dim) + " " + std::to_string(tag) + " \"" + name + "\"\n";
      }
    for (int dim = 0; dim < 4; ++dim)
      for (const auto& [name, tag] : group_tags_[dim]) {
        ++count;
        lines += std::to_string(dim) + " " + std::to_string(tag) + " \"" + name + "\"\n";
      }
    if (count == 0) return;
    file_.write("$PhysicalNames\n" + std::to_string(count) + "\n" + lines + "$EndPhysicalNames\n");
  }

  std::string group_of(int dim, std::int32_t tag) const {
    const std::vector<EntityAttributes>& table = mesh_.entities[dim];
    if (tag == 0 || static_cast<std::size_t>(tag) > table.size()) return {};
    return printable(table[static_cast<std::size_t>(tag) - 1].group);
  }

  /// Physical groups of several entities have tags behind those of the entities.
  void number_groups() {
    for (int dim = 0; dim < 4; ++dim) {
      std::int64_t next = entities_[dim].empty() ? 0 : entities_[dim].rbegin()->first;
      for (const auto& [tag, entity] : entities_[dim]) {
        const std::string name = group_of(dim, tag);
        if (name.empty() || !group_tags_[dim].try_emplace(name, static_cast<std::int32_t>(next + 1)).second) continue;
        if (++next > std::numeric_limits<std::int32_t>::max())
          throw Error(ErrorCode::InvalidArgument, "the groups of model entities are too many for an MSH file");
      }
    }
  }

  /// The physical groups of an entity: that of its own, and the one that it is in with others.
  void put_groups(int dim, std::int32_t tag) {
    const std::string group = group_of(dim, tag);
    file_.put(std::uint64_t{tag != 0} + std::uint64_t{!group.empty()});
    if (tag != 0) file_.put(tag);
    if (!group.empty()) file_.put(group_tags_[dim].at(group));
  }

  void write_entities() {
    file_.write("$Entities\n");
    for (const auto& table : entities_) file_.put(std::uint64_t{table.size()});
    for (int dim = 0; dim < 4; ++dim)
      for (const auto& [tag, entity] : entities_[dim]) {
        file_.put(tag);
        const Box3 box = entity.box.empty() ? Box3{{0, 0, 0}, {0, 0, 0}} : entity.box;
        file_.put(box.lo);
        if (dim > 0) file_.put(box.hi);
        put_groups(dim, tag);
        if (dim == 0) continue;
        file_.put(std::uint64_t{entity.boundary.size()});
        for (const std::int32_t face : entity.boundary) file_.put(face);
      }
    file_.write("\n$EndEntities\n");
  }

  /// Tags behind those of the model's own entities.
  void number_pieces(int dim) {
    std::int64_t tag = entities_[dim].empty() ? 0 : entities_[dim].rbegin()->first;
    for (auto& [key, piece] : pieces_[dim]) {
      if (++tag > std::numeric_limits<std::int32_t>::max())
        throw Error(ErrorCode::InvalidArgument, "the parts of model entities are too many for an MSH file");
      piece = static_cast<std::int32_t>(tag);
    }
  }

  void write_pieces() {
    file_.write("$PartitionedEntities\n");
    file_.put(std::uint64_t{part_count_});
    file_.put(std::uint64_t{0});  // ghost entities
    for (const auto& table : pieces_) file_.put(std::uint64_t{table.size()});
    for (std::int32_t dim = 0; dim < 4; ++dim)
      for (const auto& [key, piece] : pieces_[dim]) {
        const auto& [parent, part] = key;
        for (const std::int32_t x : {piece, dim, parent}) file_.put(x);
        file_.put(std::uint64_t{1});
        file_.put(static_cast<std::int32_t>(part + 1));
        const Box3& box = entities_[dim].at(parent).box;
        file_.put(box.lo);
        if (dim > 0) file_.put(box.hi);
        put_groups(dim, parent);
        if (dim > 0) file_.put(std::uint64_t{0});  // bounding entities
      }
    file_.write("\n$EndPartitionedEntities\n");
  }

  void write_nodes() {
    std::uint64_t blocks = 0;
    for (const TagBlocks& of_dim : points_) blocks += of_dim.tags.size();
    file_.write("$Nodes\n");
    for (const std::uint64_t x :
         {blocks, std::uint64_t{mesh_.points.size()}, std::uint64_t{1}, std::uint64_t{mesh_.points.size()}})
      file_.put(x);
    for (std::int32_t dim = 0; dim < 4; ++dim) {
      const TagBlocks& of_dim = points_[dim];
      for (std::size_t b = 0; b < of_dim.tags.size(); ++b) {
        for (const std::int32_t x : {dim, of_dim.tags[b], 0}) file_.put(x);
        const std::span<const std::uint32_t> points = of_dim.items(b);
        file_.put(std::uint64_t{points.size()});
        file_.put_each(
            points.size(), [&](std::size_t i) { return std::uint64_t{points[i]} + 1; }, loop_);
        file_.put_each(
            points.size(), [&](std::size_t i) { return mesh_.points[points[i]]; }, loop_);
      }
    }
    file_.write("\n$EndNodes\n");
  }

  /// Elements of one kind, numbered from `first_tag` on in the order of the mesh.
  template <class Element>
  void write_blocks(Block block, std::uint64_t first_tag, const std::vector<Element>& elements) {
    const auto index = static_cast<std::size_t>(block);
    const std::int32_t type = (nodes_.are_second_order() ? kMshTypes2 : kMshTypes)[index];
    const TagBlocks& blocks = elements_[index];
    for (std::size_t b = 0; b < blocks.tags.size(); ++b) {
      for (const std::int32_t x : {std::int32_t{dimension_of(block)}, blocks.tags[b], type}) file_.put(x);
      const std::span<const std::uint32_t> items = blocks.items(b);
      file_.put(std::uint64_t{items.size()});
      const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
        const auto put = [&out](std::uint64_t number) {
          std::memcpy(out, &number, sizeof number);
          out += sizeof number;
        };
        for (std::size_t i = begin; i < end; ++i) {
          put(first_tag + items[i]);
          for (const std::uint32_t node : nodes_.of(elements[items[i]], msh_edges_of(block)))
            put(std::uint64_t{node} + 1);
        }
      };
      file_.write_records(items.size(), (1 + nodes_.count(block)) * sizeof(std::uint64_t), encode, loop_);
    }
  }

  /// Points as elements, numbered from `first_tag` on in the order of the file.
  void write_points(std::uint64_t first_tag) {
    for (std::size_t b = 0; b < points_[0].tags.size(); ++b) {
      for (const std::int32_t x : {0, points_[0].tags[b], kMshPoint}) file_.put(x);
      const std::span<const std::uint32_t> items = points_[0].items(b);
      file_.put(std::uint64_t{items.size()});
      const auto record_of = [&](std::size_t i) {
        return std::array<std::uint64_t, 2>{first_tag + i, std::uint64_t{items[i]} + 1};
      };
      file_.put_each(items.size(), record_of, loop_);
      first_tag += items.size();
    }
  }

  void write_elements() {
    std::uint64_t blocks = points_[0].tags.size(), elements = 0;
    for (const TagBlocks& of_type : elements_) blocks += of_type.tags.size(), elements += of_type.size();
    const std::uint64_t total = elements + points_[0].size();
    file_.write("$Elements\n");
    for (const std::uint64_t x : {blocks, total, std::uint64_t{1}, total}) file_.put(x);
    write_points(1 + elements);
    std::uint64_t first_tag = 1;
    for_each_block(mesh_, [&](Block block, const auto& of_type, const auto&) {
      write_blocks(block, first_tag, of_type);
      first_tag += of_type.size();
    });
    file_.write("\n$EndElements\n");
  }

  /// A field on nodes or elements with consecutive tags, as a view with a single time step.
  void write_data(const std::string& section, const MeshField& field, std::uint64_t first_tag, std::uint64_t count) {
    if (first_tag + count > static_cast<std::uint64_t>(std::numeric_limits<std::int32_t>::max()))
      throw Error(ErrorCode::InvalidArgument, "the mesh is too large for fields in an MSH file");
    file_.write("$" + section + "\n1\n\"" + printable(field.name) + "\"\n1\n0\n3\n0\n" +
                std::to_string(field.components) + "\n" + std::to_string(count) + "\n");
    const std::size_t bytes = static_cast<std::size_t>(field.components) * sizeof(double);
    const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
      const char* values = reinterpret_cast<const char*>(field.values.data()) + begin * bytes;
      for (std::size_t i = begin; i < end; ++i, values += bytes, out += 4 + bytes) {
        const auto tag = static_cast<std::int32_t>(first_tag + i);
        std::memcpy(out, &tag, 4);
        std::memcpy(out + 4, values, bytes);
      }
    };
    file_.write_records(count, 4 + bytes, encode, loop_);
    file_.write("\n$End" + section + "\n");
  }

  const Mesh& mesh_;
  AtomicFile& file_;
  const BlockLoop& loop_;
  ElementNodes nodes_;
  int top_dimension_;
  std::array<TagBlocks, 4> points_;
  std::array<TagBlocks, kBlocks> elements_;
  std::array<std::map<std::int32_t, Entity>, 4> entities_;
  std::array<std::map<std::string, std::int32_t>, 4> group_tags_;
  std::uint32_t part_count_ = 0;  // 0: in no parts
  std::array<Pieces, 4> pieces_;
};

void require_representable(const Mesh& mesh, const BlockLoop& loop) {
  checked_tag(index_of_tag(static_cast<std::int64_t>(largest_tag(mesh, loop))));
  for_each_block(mesh, [](Block, const auto& elements, const auto&) {
    if (elements.size() > 0xffffffffu)
      throw Error(ErrorCode::InvalidArgument, "the mesh has too many elements for one MSH file");
  });
}

}  // namespace

void write_msh(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  require_representable(mesh, loop);
  MshWriter(mesh, file, loop).write();
}

void write_partitioned_msh(const Mesh& mesh, const MeshParts& parts, AtomicFile& file, const BlockLoop& loop) {
  require_representable(mesh, loop);
  MshWriter writer(mesh, file, loop);
  writer.deal(parts);
  writer.write();
}

}  // namespace tetloom::detail
