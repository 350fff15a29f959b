// Gmsh 4.1 and 2.2, both as text and binary, by the Gmsh reference manual.
#include <algorithm>
#include <array>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <type_traits>

#include "core/io/formats_detail.hpp"
#include "core/io/mid_node_reader_detail.hpp"
#include "core/io/msh_detail.hpp"
#include "core/io/msh_slice_detail.hpp"

namespace tetloom::detail {
namespace {

constexpr std::size_t kItemsBetweenLooks = std::size_t{1} << 20;
/// Tables of names and sides are indexed by tag. Where an entity has a larger tag than these there are none, nor beyond
/// kLeastNamedTag where they would take more than kLargestRatioOfNames times the size of the file.
constexpr std::int32_t kLargestNamedTag = 1'000'000, kLeastNamedTag = 10'000;
constexpr std::size_t kLargestRatioOfNames = 64;

/// What Gmsh calls an element type, for error messages; types that a Mesh holds are handled before.
std::string describe_type(std::int32_t type) {
  static const std::map<std::int32_t, const char*> names{
      {10, "quadrangle with 9 nodes"}, {12, "hexahedron with 27 nodes"}, {13, "prism with 18 nodes"},
      {14, "pyramid with 14 nodes"},   {21, "third-order triangle"},     {29, "third-order tetrahedron"}};
  const auto found = names.find(type);
  return found == names.end() ? "Gmsh type " + std::to_string(type)
                              : std::string(found->second) + " (Gmsh type " + std::to_string(type) + ")";
}

/// What elements of a type are, and how many mid nodes they have.
struct MshType {
  Block block;
  std::size_t mid_nodes = 0;
};

std::optional<MshType> find_type(std::int32_t type) {
  for (std::size_t b = 0; b < kBlocks; ++b) {
    const auto block = static_cast<Block>(b);
    if (type == kMshTypes[b]) return MshType{block};
    if (type == kMshTypes2[b]) return MshType{block, edges_of(block).size()};
  }
  return {};
}

class MshReader {
 public:
  explicit MshReader(const InputFile& file) : file_(file), cursor_(file, file.bytes()) {}

  Mesh read() {
    read_sections();
    return finish();
  }

  /// Instead of `read`.
  std::optional<FileSlice> read_slice(SliceFilter& filter) {
    slice_.emplace(MshSlice{filter});
    read_sections();
    slice_->end_counts();
    if (!partitions_.empty()) filter.set_unfit();
    if (!filter.is_fit()) return {};
    read_elements_at(slice_->elements_at);
    filter.begin_second_pass(mesh_);
    if (!filter.is_fit()) return {};
    read_nodes_at(slice_->nodes_at), read_elements_at(slice_->elements_at);
    return finish_slice();
  }

  /// After `read`.
  MeshParts take_parts() {
    if (lacks_parts_) file_.fail(ErrorCode::InputUnsuitable, "only some of the cells belong to partitions");
    return std::move(parts_);
  }

 private:
  void read_sections() {
    std::string_view section = next_section();
    while (section == "Comments") end_section(section), section = next_section();
    if (section != "MeshFormat")
      file_.fail(ErrorCode::InputUnreadable, "no MSH file: it does not start with $MeshFormat");
    read_format();
    end_section(section);
    while (!(section = next_section()).empty()) {
      file_.check_cancelled();
      if (section == "Comments") oriented_ |= cursor_.line() == kMshSignature;
      if (section == "PhysicalNames") read_names();
      if (section == "Entities") read_entities();
      if (section == "PartitionedEntities" && !old_) {
        MshNumbers numbers(cursor_, binary_);
        partitions_.read_section(file_, numbers);
      }
      if (section == "Nodes") read_nodes_at(cursor_.at());
      if (section == "Elements") read_elements_at(cursor_.at());
      if (section == "NodeData" || section == "ElementData") views_.read_section(cursor_, binary_, section);
      end_section(section);
    }
    if (!has_elements_) file_.fail_at_line("the file ends without elements", cursor_.at());
  }

  bool is_counting() const { return slice_ && slice_->counts; }

  void read_nodes_at(const char* place) {
    cursor_.jump(place);
    if (is_counting() && slice_->nodes_at != nullptr) slice_->filter.set_unfit();
    if (slice_) slice_->nodes_at = place;
    old_ ? read_old_nodes() : read_nodes();
  }

  void read_elements_at(const char* place) {
    cursor_.jump(place);
    if (is_counting() && slice_->elements_at != nullptr) slice_->filter.set_unfit();
    if (slice_) slice_->elements_at = place;
    old_ ? read_old_elements() : read_elements();
    has_elements_ = true;
  }

  /// The name of the next section, empty at the end of the file.
  std::string_view next_section() {
    cursor_.skip_space();
    if (cursor_.left() == 0) return {};
    const std::string_view line = cursor_.line();
    if (line.size() < 2 || line.front() != '$') file_.fail("a section is expected", line.data());
    return line.substr(1, line.find_last_not_of(" \t"));
  }

  /// Goes to the end of the section. What was read of it lies before the cursor.
  void end_section(std::string_view section) {
    const std::string end = "$End" + std::string(section);
    const std::size_t place = cursor_.rest().find(end);
    if (place == std::string_view::npos)
      file_.fail("the section $" + std::string(section) + " has no end", cursor_.at());
    cursor_.jump(cursor_.at() + place + end.size());
    cursor_.line();
  }

  void read_format() {
    const std::string_view version = cursor_.token();
    binary_ = cursor_.parse<int>() != 0;
    const int size_bytes = cursor_.parse<int>();
    cursor_.line();
    old_ = version == "2.2" || version == "2";
    if (!old_ && version != "4.1")
      file_.fail(ErrorCode::InputUnsuitable,
                 "MSH version " + std::string(version.substr(0, 10)) + " is not supported; save it as 4.1 or 2.2");
    if (binary_ && size_bytes != 8)
      file_.fail(ErrorCode::InputUnsuitable, "binary MSH files with a size_t other than 8 bytes are not supported");
    if (binary_ && cursor_.read<std::int32_t>() != 1)
      file_.fail(ErrorCode::InputUnsuitable, "MSH files of another byte order are not supported");
  }

  void read_names() {
    const auto count = cursor_.parse<std::uint64_t>();
    cursor_.expect(count, 7);
    for (std::uint64_t i = 0; i < count; ++i) {
      const auto dim = cursor_.parse<int>();
      const auto tag = cursor_.parse<std::int32_t>();
      const std::string_view line = cursor_.line();
      const std::size_t open = line.find('"'), close = line.rfind('"');
      if (open == std::string_view::npos || open == close) file_.fail_at_line("a quoted name is expected", line.data());
      group_names_.emplace(std::pair{dim, tag}, std::string(line.substr(open + 1, close - open - 1)));
    }
  }

  void read_entities() {
    MshNumbers numbers(cursor_, binary_);
    std::array<std::uint64_t, 4> counts;
    for (std::uint64_t& count : counts) count = numbers.size();
    for (int dim = 0; dim < 4; ++dim) {
      numbers.expect(counts[dim], 1, dim == 0 ? 4 : 8);
      for (std::uint64_t i = 0; i < counts[dim]; ++i) read_entity(numbers, dim);
    }
  }

  void read_entity(MshNumbers& numbers, int dim) {
    const std::int32_t tag = numbers.integer();
    for (int point = 0; point < (dim == 0 ? 1 : 2); ++point) numbers.point();
    const std::uint64_t groups = numbers.count(1, 0);
    for (std::uint64_t i = 0; i < groups; ++i) add_to_group(dim, tag, numbers.integer());
    largest_tag_[dim] = std::max(largest_tag_[dim], tag);
    if (dim == 0) return;
    const std::uint64_t bounds = numbers.count(1, 0);
    for (std::uint64_t i = 0; i < bounds; ++i) {
      const std::int32_t bound = numbers.integer();
      if (dim == 3 && bound != 0 && bound != std::numeric_limits<std::int32_t>::min() && tag > 0)
        region_bounds_.emplace_back(tag, bound);
    }
  }

  /// An entity takes the name of its first group that has one.
  void add_to_group(int dim, std::int32_t tag, std::int32_t group) {
    const auto name = group_names_.find({dim, group});
    if (name != group_names_.end()) entity_names_.emplace(std::pair{dim, tag}, name->second);
  }

  void read_nodes() {
    MshNumbers numbers(cursor_, binary_);
    const std::uint64_t blocks = numbers.size(), total = numbers.size();
    numbers.size(), numbers.size();
    numbers.expect(total, 0, 4);
    numbers.expect(blocks, 3, 1);
    reserve_nodes(total);
    for (std::uint64_t block = 0; block < blocks; ++block) {
      file_.check_cancelled();
      const std::int32_t dim = numbers.integer(), tag = numbers.integer();
      if (dim < 0 || dim > 3) file_.fail("an entity has the dimension " + std::to_string(dim), numbers.at());
      const std::int32_t parameters = numbers.integer() != 0 ? dim : 0;
      const std::uint64_t count = numbers.count(0, 4 + static_cast<std::size_t>(parameters));
      const ModelEntity entity = entity_of(dim, tag);
      Cursor tags_at = cursor_;
      MshNumbers tags(tags_at, binary_);
      for (std::uint64_t i = 0; i < count; ++i) add_tag(numbers.size());
      for (std::uint64_t i = 0; i < count; ++i) {
        add_point(slice_ ? tags.size() : 0, numbers.point(), entity);
        look_up(i);
        for (std::int32_t p = 0; p < parameters; ++p) numbers.real();
      }
    }
    finish_nodes();
  }

  ModelEntity entity_of(std::int32_t dim, std::int32_t tag) const {
    if (const MshPartitions::Entity* of_part = partitions_.find(dim, tag))
      dim = of_part->parent_dim, tag = of_part->parent_tag;
    const std::uint32_t index = index_of_tag(tag);
    return index == ModelFaceId::kNone || dim < 0 || dim > 3 ? ModelEntity{} : ModelEntity(dim, index);
  }

  void add_tag(std::uint64_t tag) {
    if (!slice_) tags_.push_back(tag);
    if (is_counting()) slice_->nodes.add(tag);
  }
  /// `tag` is looked at for slices alone.
  void add_point(std::uint64_t tag, const Vec3& point, ModelEntity entity) {
    if (slice_) {
      if (!slice_->keeps_node(tag)) return;
      tags_.push_back(tag);
    }
    mesh_.points.push_back(point);
    mesh_.point_to_entity.push_back(entity);
  }
  void look_up(std::uint64_t item) const {
    if (item % kItemsBetweenLooks != 0) return;
    file_.check_cancelled();
    if (slice_) file_.let_go();
  }

  void reserve_nodes(std::uint64_t count) {
    if (slice_) return;
    if (!mesh_.points.empty()) file_.fail("a second section of nodes", cursor_.at());
    mesh_.points.reserve(count);
    mesh_.point_to_entity.reserve(count);
    tags_.reserve(count);
  }
  void finish_nodes() {
    if (mesh_.points.size() >= 0xffffffffu) file_.fail(ErrorCode::InputUnsuitable, "the file has too many nodes");
    nodes_.finish(file_, std::move(tags_), mesh_.points, mesh_.point_to_entity);
    tags_.clear();
  }

  template <class Element>
  void read_block(MshNumbers& numbers, std::uint64_t count, MshType type, std::uint32_t index,
                  std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    numbers.expect(count, 0, Element().size() + type.mid_nodes + 1);
    if (!slice_) reserve_more(elements, count), reserve_more(entities, count);
    for (std::uint64_t i = 0; i < count; ++i) {
      look_up(i);
      const std::uint64_t tag = numbers.size();
      add_element(tag, read_nodes_of<Element>(numbers, type), type.block, index, elements, entities);
    }
  }

  template <class Element>
  void add_element(std::uint64_t tag, const Element& element, Block block, std::uint32_t index,
                   std::vector<Element>& elements, std::vector<std::uint32_t>& entities) {
    if (slice_ && !slice_->keeps(tag, element, block)) return;
    element_tags_[static_cast<std::size_t>(block)].push_back(tag);
    elements.push_back(element);
    entities.push_back(index);
  }

  std::uint32_t find_node(std::uint64_t tag) const {
    if (!slice_) return nodes_.find(tag);
    return slice_->number_of(tag);
  }

  template <class Element>
  Element read_nodes_of(MshNumbers& numbers, MshType type) {
    Element element;
    for (std::uint32_t& v : element) v = find_node(number_of(numbers));
    std::array<std::uint32_t, kMostNodes> mids;
    for (std::size_t i = 0; i < type.mid_nodes; ++i) mids[i] = find_node(number_of(numbers));
    if (slice_ && type.mid_nodes > 0) slice_->filter.set_unfit();
    if (!slice_ && type.mid_nodes > 0)
      mids_.add(element, msh_edges_of(type.block), std::span(mids).first(type.mid_nodes));
    return element;
  }

  void read_elements() {
    MshNumbers numbers(cursor_, binary_);
    const std::uint64_t blocks = numbers.size();
    for (int i = 0; i < 3; ++i) numbers.size();
    numbers.expect(blocks, 3, 1);
    for (std::uint64_t block = 0; block < blocks; ++block) {
      const std::int32_t dim = numbers.integer(), tag = numbers.integer();
      const std::uint32_t index = index_of_tag(tag);
      const std::int32_t type = numbers.integer();
      const std::uint64_t count = numbers.size();
      const std::optional<MshType> of_type = find_type(type);
      const MshPartitions::Entity* of_part = partitions_.find(dim, tag);
      if (of_type && of_part != nullptr && of_part->parent_dim != dim)
        pass_over(numbers, count, 1 + vertices_of(of_type->block) + of_type->mid_nodes);
      else if (of_type)
        visit_block(mesh_, of_type->block, [&](auto& elements, auto& entities) {
          read_block(numbers, count, *of_type, index, elements, entities);
        });
      else if (type == kMshPoint)
        for (std::uint64_t i = 0; i < count; ++i) numbers.size(), numbers.size();
      else
        refuse_elements(file_, describe_type(type));
    }
  }

  /// Elements between parts, inside of a model entity of a higher dimension.
  void pass_over(MshNumbers& numbers, std::uint64_t count, std::size_t numbers_each) {
    numbers.expect(count, 0, numbers_each);
    for (std::uint64_t i = 0; i < count * numbers_each; ++i) numbers.size();
  }

  /// The number of a node or an element: binary files of version 2.2 have 32 bits for it.
  std::uint64_t number_of(MshNumbers& numbers) const {
    return old_ && binary_ ? static_cast<std::uint32_t>(numbers.integer()) : numbers.size();
  }

  /// How many items a section of version 2.2 has, which also stands as text in binary files, in a line of its own.
  std::uint64_t old_count() {
    const auto count = cursor_.parse<std::uint64_t>();
    if (binary_) cursor_.line();
    return count;
  }

  void read_old_nodes() {
    const std::uint64_t count = old_count();
    MshNumbers numbers(cursor_, binary_);
    numbers.expect(count, 1, 3);
    reserve_nodes(count);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t tag = number_of(numbers);
      add_tag(tag);
      add_point(tag, numbers.point(), {});
      look_up(i);
    }
    finish_nodes();
  }

  void read_old_elements() {
    const std::uint64_t count = old_count();
    MshNumbers numbers(cursor_, binary_);
    numbers.expect(count, binary_ ? 2 : 4, 0);
    for (std::uint64_t done = 0; done < count;) {
      file_.check_cancelled();
      if (slice_) file_.let_go();
      done += binary_ ? read_old_block(numbers, count - done) : read_old_lines(numbers, count - done);
    }
  }

  /// Lines of id, type, number-of-tags, physical, geometrical, …, nodes; at most kItemsBetweenLooks of them.
  std::uint64_t read_old_lines(MshNumbers& numbers, std::uint64_t most) {
    const std::uint64_t count = std::min<std::uint64_t>(most, kItemsBetweenLooks);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::uint64_t id = numbers.size();
      const std::int32_t type = numbers.integer();
      read_old_element(numbers, id, type, numbers.count(1, 0));
    }
    return count;
  }

  /// The type, the number of elements and that of their tags, which a binary file has once for several elements.
  std::uint64_t read_old_block(MshNumbers& numbers, std::uint64_t most) {
    const std::int32_t type = numbers.integer(), count = numbers.integer(), tags = numbers.integer();
    if (count < 1 || static_cast<std::uint64_t>(count) > most || tags < 0)
      file_.fail("a block of elements with counts that make no sense", numbers.at());
    numbers.expect(static_cast<std::uint64_t>(count), 2, 0);
    numbers.expect(static_cast<std::uint64_t>(tags), 1, 0);
    for (std::int32_t i = 0; i < count; ++i)
      read_old_element(numbers, number_of(numbers), type, static_cast<std::uint64_t>(tags));
    return static_cast<std::uint64_t>(count);
  }

  void read_old_element(MshNumbers& numbers, std::uint64_t id, std::int32_t type, std::uint64_t tag_count) {
    std::int32_t group = 0, tag = 0;
    for (std::uint64_t i = 0; i < tag_count; ++i) {
      const std::int32_t value = numbers.integer();
      if (i == 0) group = value;
      if (i == 1) tag = value;
    }
    const std::optional<MshType> of_type = find_type(type);
    const auto add = [&](auto& elements, auto& entities) {
      using Element = typename std::remove_reference_t<decltype(elements)>::value_type;
      add_element(id, read_nodes_of<Element>(numbers, *of_type), of_type->block, index_of_tag(tag), elements, entities);
      const int dim = dimension_of(of_type->block);
      add_to_group(dim, tag, group);
      largest_tag_[dim] = std::max(largest_tag_[dim], tag);
    };
    if (of_type) return visit_block(mesh_, of_type->block, add);
    if (type != kMshPoint) refuse_elements(file_, describe_type(type));
    const std::uint32_t node = find_node(number_of(numbers));
    if (!slice_ || slice_->counts) corners_.push_back({node, index_of_tag(tag)});
    add_to_group(0, tag, group);
    largest_tag_[0] = std::max(largest_tag_[0], tag);
  }

  /// Whether the file is large enough for tables of the entities of a dimension.
  bool can_name(int dim) const {
    const std::size_t room = kLargestRatioOfNames * file_.bytes().size() / sizeof(EntityAttributes);
    const auto largest = std::clamp<std::size_t>(room, kLeastNamedTag, kLargestNamedTag);
    return largest_tag_[dim] <= static_cast<std::int32_t>(largest);
  }

  void set_names() {
    for (const auto& [key, name] : entity_names_) {
      const auto& [dim, tag] = key;
      if (dim < 0 || dim > 3 || tag <= 0 || !can_name(dim)) continue;
      std::vector<EntityAttributes>& table = mesh_.entities[static_cast<std::size_t>(dim)];
      table.resize(static_cast<std::size_t>(largest_tag_[dim]));
      table[static_cast<std::size_t>(tag) - 1].name = name;
    }
  }

  void set_sides() {
    if (!oriented_ || region_bounds_.empty() || !can_name(2)) return;
    mesh_.face_to_sides.resize(static_cast<std::size_t>(std::max(largest_tag_[2], 0)));
    for (const auto& [region, face] : region_bounds_) {
      const auto index = static_cast<std::size_t>(std::abs(face)) - 1;
      if (index >= mesh_.face_to_sides.size()) continue;
      FaceSides& sides = mesh_.face_to_sides[index];
      (face > 0 ? sides.back : sides.front) = ModelRegionId(static_cast<std::size_t>(region) - 1);
    }
  }

  /// Until here, elements have the entities of parts. Those become parts and entities of the model.
  void replace_partitioned() {
    parts_.count = partitions_.count();
    for_each_block(mesh_, [&](Block block, const auto&, std::vector<std::uint32_t>& entities) {
      const int dim = dimension_of(block);
      for (std::uint32_t& entity : entities) {
        const MshPartitions::Entity* of_part = partitions_.find(dim, static_cast<std::int32_t>(tag_of_index(entity)));
        if (dim == 3 && of_part == nullptr) lacks_parts_ = true;
        if (dim == 3) parts_.cell_to_part.push_back(of_part == nullptr ? 0 : of_part->part);
        if (of_part != nullptr) entity = index_of_tag(of_part->parent_tag);
      }
    });
  }

  Mesh finish() {
    check_read_mesh(file_, mesh_);
    for (const Corner& corner : corners_)
      if (corner.point >= mesh_.points.size())
        file_.fail(ErrorCode::InputUnreadable, "a point element refers to a node that is not there");
    if (old_) classify_points(mesh_, corners_);
    for_each_block(mesh_, [&](Block block, auto& elements, auto& entities) {
      restore_order(elements, entities, element_tags_[static_cast<std::size_t>(block)]);
    });
    if (!partitions_.empty()) replace_partitioned();
    views_.add_fields(mesh_, carriers());
    mids_.finish(file_, mesh_, old_);
    set_names();
    set_sides();
    return std::move(mesh_);
  }

  std::optional<FileSlice> finish_slice() {
    restore_order(mesh_.tet_to_vert, mesh_.tet_to_entity, element_tags_[static_cast<std::size_t>(Block::Tet)]);
    views_.add_fields(mesh_, carriers());
    set_names();
    set_sides();
    return slice_->filter.finish(std::move(mesh_), corners_, !old_);
  }

  MshCarriers carriers() const {
    return {element_tags_, [this](std::uint64_t tag) { return find_carrier(tag); },
            [this](std::uint64_t tag) { return slice_ && slice_->tets.has(tag); }};
  }

  std::optional<std::size_t> find_carrier(std::uint64_t tag) const {
    const std::uint32_t node = find_node(tag);
    if (node == kNone || (!slice_ && node >= mesh_.points.size())) return {};
    return slice_ ? slice_->filter.local_of(node) : node;
  }

  const InputFile& file_;
  Cursor cursor_;
  bool binary_ = false, old_ = false, oriented_ = false, has_elements_ = false;
  Mesh mesh_;
  MshPartitions partitions_;
  MeshParts parts_;
  bool lacks_parts_ = false;
  NodeTags nodes_;
  std::vector<std::uint64_t> tags_;
  std::optional<MshSlice> slice_;
  std::array<std::vector<std::uint64_t>, kBlocks> element_tags_;
  MshViews views_{file_};
  std::vector<Corner> corners_;
  MidNodeReader mids_;
  std::map<std::pair<int, std::int32_t>, std::string> group_names_, entity_names_;
  std::array<std::int32_t, 4> largest_tag_{};
  std::vector<std::pair<std::int32_t, std::int32_t>> region_bounds_;  // region tag, signed face tag
};

}  // namespace

Mesh read_msh(const InputFile& file) { return MshReader(file).read(); }

std::optional<FileSlice> read_msh_slice(const InputFile& file, SliceFilter& filter) {
  return MshReader(file).read_slice(filter);
}

Mesh read_partitioned_msh(const InputFile& file, MeshParts& parts) {
  MshReader reader(file);
  Mesh mesh = reader.read();
  parts = reader.take_parts();
  return mesh;
}

}  // namespace tetloom::detail
