// MSH 2.2 of Gmsh, as text or binary, which more programs read than read 4.1: a physical group of its name for every
// edge, face and region, or of several that are a group. Triangles and quadrilaterals point out of the one region at
// their face. Fields are left out.
#include <map>

#include "core/io/formats_detail.hpp"
#include "core/io/msh_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "core/io/solver/number_text.hpp"

namespace tetloom::detail {
namespace {

class Msh2Writer {
 public:
  Msh2Writer(const Mesh& mesh, bool is_text, AtomicFile& file, const BlockLoop& loop)
      : mesh_(mesh), is_text_(is_text), file_(file), loop_(loop), nodes_(mesh) {}

  void write() {
    std::size_t count = 0;
    for_each_block(mesh_, [&](Block, const auto& elements, const auto&) { count += elements.size(); });
    if (std::max(count, mesh_.points.size()) > kMostNumber || largest_tag(mesh_, loop_) > kMostNumber)
      throw Error(ErrorCode::InvalidArgument, "the mesh has numbers beyond the 31 bits that MSH 2.2 allows");
    file_.write(is_text_ ? "$MeshFormat\n2.2 0 8\n" : "$MeshFormat\n2.2 1 8\n");
    if (!is_text_) file_.put(std::int32_t{1}), file_.write("\n");
    file_.write("$EndMeshFormat\n");
    write_groups();
    write_points();
    file_.write("$Elements\n" + std::to_string(count) + "\n");
    std::size_t first = 1;
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto& entities) {
      if (!elements.empty()) write_block(block, elements, entities, first);
      first += elements.size();
    });
    file_.write(is_text_ ? "$EndElements\n" : "\n$EndElements\n");
  }

 private:
  // Faces have their own tags for numbers, or the lowest of their group; regions come behind all faces, edges behind
  // all regions: gmshToFoam knows groups by their numbers alone, whatever their dimension.
  void write_groups() {
    const Groups groups = make_groups(mesh_);
    std::string lines;
    std::size_t count = 0, before = 0;
    for (const std::size_t dim : {std::size_t{2}, std::size_t{3}, std::size_t{1}}) {
      std::size_t largest = 0;
      for (const Group& group : groups[dim]) {
        largest = std::max<std::size_t>(largest, group.tags.back());
        const std::size_t number = group.tags[0] == 0 ? 0 : before + group.tags[0];
        lines += std::to_string(dim) + " " + std::to_string(number) + " \"" + group.name + "\"\n";
        ++count;
        for (const std::uint32_t tag : group.tags) number_of_[dim][tag] = static_cast<std::uint32_t>(number);
      }
      before += largest;
    }
    if (before > kMostNumber)
      throw Error(ErrorCode::InvalidArgument, "the mesh has tags beyond the 31 bits that MSH 2.2 allows");
    if (count > 0) file_.write("$PhysicalNames\n" + std::to_string(count) + "\n" + lines + "$EndPhysicalNames\n");
  }

  // A point with its number, as a binary file has it.
  using PointRecord = std::array<char, sizeof(std::int32_t) + sizeof(Vec3)>;

  void write_points() {
    file_.write("$Nodes\n" + std::to_string(mesh_.points.size()) + "\n");
    if (is_text_) {
      const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
        for (std::size_t v = begin; v < end; ++v) {
          out = print(out, v + 1, ' ');
          for (int axis = 0; axis < 3; ++axis) out = print(out, mesh_.points[v][axis], axis < 2 ? ' ' : '\n');
        }
        return out;
      };
      file_.write_lines(mesh_.points.size(), kIntegerBytes + 3 * kRealBytes, print_block, loop_);
    } else {
      const auto record_of = [&](std::size_t v) {
        PointRecord record;
        const auto number = static_cast<std::int32_t>(v + 1);
        std::memcpy(record.data(), &number, sizeof number);
        std::memcpy(record.data() + sizeof number, &mesh_.points[v], sizeof(Vec3));
        return record;
      };
      file_.put_each(mesh_.points.size(), record_of, loop_);
      file_.write("\n");
    }
    file_.write("$EndNodes\n");
  }

  // The group and the entity of an element.
  std::array<std::uint32_t, 2> tags_of(Block block, std::uint32_t entity) const {
    const std::uint32_t tag = tag_of_index(entity);
    return {number_of_[static_cast<std::size_t>(dimension_of(block))].at(tag), tag};
  }

  // Elements of one kind, whose numbers begin at `first`.
  template <class Element>
  void write_block(Block block, const std::vector<Element>& elements, const std::vector<std::uint32_t>& entities,
                   std::size_t first) {
    const std::int32_t type = (nodes_.are_second_order() ? kMshTypes2 : kMshTypes)[static_cast<std::size_t>(block)];
    const auto nodes_of = [&](std::size_t e) {
      return nodes_.of(turned_outwards(mesh_, dimension_of(block), elements[e], entities[e]), msh_edges_of(block));
    };
    if (is_text_) {
      const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
        for (std::size_t e = begin; e < end; ++e) {
          out = print(out, first + e, ' ');
          out = print(print(out, type, ' '), 2, ' ');
          for (const std::uint32_t tag : tags_of(block, entities[e])) out = print(out, tag, ' ');
          const NodeList own = nodes_of(e);
          for (std::size_t i = 0; i < own.size(); ++i)
            out = print(out, std::uint64_t{own[i]} + 1, i + 1 < own.size() ? ' ' : '\n');
        }
        return out;
      };
      return file_.write_lines(elements.size(), (nodes_.count(block) + 5) * kIntegerBytes, print_block, loop_);
    }
    for (const std::int32_t value : {type, static_cast<std::int32_t>(elements.size()), std::int32_t{2}})
      file_.put(value);
    const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
      const auto put = [&out](std::size_t number) {
        const auto value = static_cast<std::int32_t>(number);
        std::memcpy(out, &value, sizeof value);
        out += sizeof value;
      };
      for (std::size_t e = begin; e < end; ++e) {
        put(first + e);
        for (const std::uint32_t tag : tags_of(block, entities[e])) put(tag);
        for (const std::uint32_t node : nodes_of(e)) put(node + std::size_t{1});
      }
    };
    file_.write_records(elements.size(), (3 + nodes_.count(block)) * sizeof(std::int32_t), encode, loop_);
  }

  const Mesh& mesh_;
  bool is_text_;
  AtomicFile& file_;
  const BlockLoop& loop_;
  ElementNodes nodes_;
  std::array<std::map<std::uint32_t, std::uint32_t>, 4> number_of_;  // of the group, by dimension and tag
};

}  // namespace

void write_msh2_text(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  Msh2Writer(mesh, true, file, loop).write();
}

void write_msh2_binary(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  Msh2Writer(mesh, false, file, loop).write();
}

}  // namespace tetloom::detail
