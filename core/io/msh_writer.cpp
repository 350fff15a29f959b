// Gmsh 4.1, binary (Gmsh reference manual, "MSH file format"). Node and element tags follow the order of the mesh, so
// that it comes back although the format wants blocks by entity. Every entity is a physical group of its own tag,
// which carries its name; the sides of faces are the signed bounding surfaces of the volumes. Fields are views with one
// time step.
#include <array>
#include <limits>
#include <map>
#include <utility>

#include "core/io/formats_detail.hpp"
#include "core/io/msh_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kLongestName = 255;

/// Items in blocks by entity tag (0 for those without an entity), in their own order inside a block.
struct TagBlocks {
  std::vector<std::int32_t> tags;  // ascending
  std::vector<std::size_t> begin;  // of each block in `order`, and the end of the last
  std::vector<std::uint32_t> order;
};

/// `tag_of(i)` gives the tag of item i, or -1 to leave it out.
template <class TagOf>
TagBlocks make_blocks(std::size_t count, const TagOf& tag_of) {
  std::map<std::int32_t, std::size_t> places;  // first the size of each block, then where its next item goes
  const auto for_each_place = [&](const auto& body) {
    auto last = places.end();  // items of an entity tend to follow each other
    for (std::size_t i = 0; i < count; ++i) {
      const std::int32_t tag = tag_of(i);
      if (tag < 0) continue;
      if (last == places.end() || last->first != tag) last = places.try_emplace(tag, 0).first;
      body(last->second, i);
    }
  };
  for_each_place([](std::size_t& size, std::size_t) { ++size; });
  TagBlocks blocks;
  blocks.begin.push_back(0);
  for (auto& [tag, place] : places) {
    const std::size_t size = std::exchange(place, blocks.begin.back());
    blocks.tags.push_back(tag);
    blocks.begin.push_back(blocks.begin.back() + size);
  }
  blocks.order.resize(blocks.begin.back());
  for_each_place([&](std::size_t& place, std::size_t i) { blocks.order[place++] = static_cast<std::uint32_t>(i); });
  return blocks;
}

std::int32_t checked_tag(std::uint32_t index) {
  const std::uint32_t tag = tag_of_index(index);
  if (tag > static_cast<std::uint32_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorCode::InvalidArgument,
                "a model entity has the tag " + std::to_string(tag) + ", which the MSH format cannot hold");
  return static_cast<std::int32_t>(tag);
}

class MshWriter {
 public:
  MshWriter(const Mesh& mesh, AtomicFile& file) : mesh_(mesh), file_(file) {
    top_dimension_ = cell_count(mesh) > 0 ? 3 : surface_count(mesh) > 0 ? 2 : 1;
    for (int dim = 0; dim < 4; ++dim)
      points_[dim] = make_blocks(mesh.points.size(), [&](std::size_t i) { return point_tag(i, dim); });
    for_each_block(mesh, [&](Block block, const auto&, const auto& entities) {
      elements_[static_cast<std::size_t>(block)] = element_blocks(entities);
    });
    find_entities();
  }

  /// From here on points and elements lie on entities of their parts.
  void deal(const MeshParts& parts) {
    part_count_ = parts.count;
    const MshOwners owners = find_owners(mesh_, parts);
    for (int dim = 0; dim < 4; ++dim) {
      const auto collect = [&](const TagBlocks& blocks, const std::vector<std::uint32_t>& part_of) {
        for (std::size_t b = 0; b < blocks.tags.size(); ++b)
          for (std::size_t i = blocks.begin[b]; i < blocks.begin[b + 1]; ++i)
            pieces_[dim].try_emplace({blocks.tags[b], part_of[blocks.order[i]]}, 0);
      };
      collect(points_[dim], owners.of_points);
      for (std::size_t block = 0; block < kBlocks; ++block)
        if (dimension_of(static_cast<Block>(block)) == dim) collect(elements_[block], owners.of_elements[block]);
      number_pieces(dim);
      points_[dim] = make_blocks(mesh_.points.size(), [&](std::size_t i) {
        const std::int32_t tag = point_tag(i, dim);
        return tag < 0 ? tag : pieces_[dim].at({tag, owners.of_points[i]});
      });
    }
    for_each_block(mesh_, [&](Block block, const auto&, const auto& entities) {
      const auto& part_of = owners.of_elements[static_cast<std::size_t>(block)];
      elements_[static_cast<std::size_t>(block)] = make_blocks(entities.size(), [&](std::size_t i) {
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

  static TagBlocks element_blocks(const std::vector<std::uint32_t>& entities) {
    return make_blocks(entities.size(), [&](std::size_t i) { return checked_tag(entities[i]); });
  }

  /// The tag of point `i` among the entities of dimension `dim`, -1 when it lies on one of another dimension. Points
  /// without an entity lie on the entity 0 of the mesh's own dimension.
  std::int32_t point_tag(std::size_t i, int dim) const {
    const ModelEntity entity = entity_of_point(mesh_, i);
    if (!entity.valid()) return dim == top_dimension_ ? 0 : -1;
    return entity.dim == dim ? checked_tag(entity.index) : -1;
  }

  template <class Element>
  void add_boxes(Block block, const std::vector<Element>& elements) {
    const int dim = dimension_of(block);
    const TagBlocks& blocks = elements_[static_cast<std::size_t>(block)];
    for (std::size_t b = 0; b < blocks.tags.size(); ++b) {
      Box3& box = entities_[dim][blocks.tags[b]].box;
      for (std::size_t i = blocks.begin[b]; i < blocks.begin[b + 1]; ++i)
        for (const std::uint32_t v : elements[blocks.order[i]]) box.add(mesh_.points[v]);
    }
  }

  void find_entities() {
    for (int dim = 0; dim < 4; ++dim)
      for (std::size_t b = 0; b < points_[dim].tags.size(); ++b) {
        Box3& box = entities_[dim][points_[dim].tags[b]].box;
        for (std::size_t i = points_[dim].begin[b]; i < points_[dim].begin[b + 1]; ++i)
          box.add(mesh_.points[points_[dim].order[i]]);
      }
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) { add_boxes(block, elements); });
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
    if (count == 0) return;
    file_.write("$PhysicalNames\n" + std::to_string(count) + "\n" + lines + "$EndPhysicalNames\n");
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
        file_.put(std::uint64_t{tag != 0});
        if (tag != 0) file_.put(tag);
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
        file_.put(std::uint64_t{parent != 0});
        if (parent != 0) file_.put(parent);
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
        file_.put(std::uint64_t{of_dim.begin[b + 1] - of_dim.begin[b]});
        for (std::size_t i = of_dim.begin[b]; i < of_dim.begin[b + 1]; ++i)
          file_.put(std::uint64_t{of_dim.order[i]} + 1);
        for (std::size_t i = of_dim.begin[b]; i < of_dim.begin[b + 1]; ++i) file_.put(mesh_.points[of_dim.order[i]]);
      }
    }
    file_.write("\n$EndNodes\n");
  }

  /// Elements of one type, numbered from `first_tag` on in the order of the mesh, or of the file for points.
  template <class VerticesOf>
  void write_blocks(const TagBlocks& blocks, std::int32_t dim, std::int32_t type, std::uint64_t first_tag,
                    const VerticesOf& vertices_of) {
    for (std::size_t b = 0; b < blocks.tags.size(); ++b) {
      for (const std::int32_t x : {dim, blocks.tags[b], type}) file_.put(x);
      file_.put(std::uint64_t{blocks.begin[b + 1] - blocks.begin[b]});
      for (std::size_t i = blocks.begin[b]; i < blocks.begin[b + 1]; ++i) {
        file_.put(first_tag + (dim == 0 ? i : blocks.order[i]));
        for (const std::uint32_t v : vertices_of(blocks.order[i])) file_.put(std::uint64_t{v} + 1);
      }
    }
  }

  void write_elements() {
    std::uint64_t blocks = points_[0].tags.size(), elements = 0;
    for (const TagBlocks& of_type : elements_) blocks += of_type.tags.size(), elements += of_type.order.size();
    const std::uint64_t total = elements + points_[0].order.size();
    file_.write("$Elements\n");
    for (const std::uint64_t x : {blocks, total, std::uint64_t{1}, total}) file_.put(x);
    write_blocks(points_[0], 0, kMshPoint, 1 + elements, [](std::uint32_t i) { return std::array{i}; });
    std::uint64_t first_tag = 1;
    for_each_block(mesh_, [&](Block block, const auto& of_type, const auto&) {
      const auto index = static_cast<std::size_t>(block);
      write_blocks(elements_[index], dimension_of(block), kMshTypes[index], first_tag,
                   [&](std::uint32_t i) { return of_type[i]; });
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
    const auto components = static_cast<std::size_t>(field.components);
    for (std::size_t i = 0; i < count; ++i) {
      file_.put(static_cast<std::int32_t>(first_tag + i));
      file_.write(field.values.data() + i * components, components * sizeof(double));
    }
    file_.write("\n$End" + section + "\n");
  }

  const Mesh& mesh_;
  AtomicFile& file_;
  int top_dimension_;
  std::array<TagBlocks, 4> points_;
  std::array<TagBlocks, kBlocks> elements_;
  std::array<std::map<std::int32_t, Entity>, 4> entities_;
  std::uint32_t part_count_ = 0;                                                          // 0: in no parts
  std::array<std::map<std::pair<std::int32_t, std::uint32_t>, std::int32_t>, 4> pieces_;  // of (tag, part), their tags
};

void require_countable(const Mesh& mesh) {
  for_each_block(mesh, [](Block, const auto& elements, const auto&) {
    if (elements.size() > 0xffffffffu)
      throw Error(ErrorCode::InvalidArgument, "the mesh has too many elements for one MSH file");
  });
}

}  // namespace

void write_msh(const Mesh& mesh, AtomicFile& file) {
  require_countable(mesh);
  MshWriter(mesh, file).write();
}

void write_partitioned_msh(const Mesh& mesh, const MeshParts& parts, AtomicFile& file) {
  require_countable(mesh);
  MshWriter writer(mesh, file);
  writer.deal(parts);
  writer.write();
}

}  // namespace tetloom::detail
