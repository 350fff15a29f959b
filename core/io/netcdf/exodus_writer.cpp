// Exodus II (Schoof, Yarberry 1994; as the library of release 6 writes it, in netCDF): a block of elements for every
// region and kind of cells, a side set and a node set for every face, node sets for edges and vertices. Meshes without
// cells have blocks for faces, those without faces blocks for edges. No fields.
#include <algorithm>
#include <cstring>
#include <limits>
#include <set>
#include <type_traits>

#include "core/io/element_nodes_detail.hpp"
#include "core/io/netcdf/netcdf_writer_detail.hpp"
#include "core/io/solver/cell_faces.hpp"
#include "core/io/solver/groups.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

constexpr std::array<const char*, kBlocks> kExodusTypes{"BAR2", "TRI3", "QUAD4", "TETRA", "PYRAMID", "WEDGE", "HEX"};
constexpr std::array<const char*, kBlocks> kExodusTypes2{"BAR3",      "TRI6",    "QUAD8", "TETRA10",
                                                         "PYRAMID13", "WEDGE15", "HEX20"};
/// Behind the name of a region that has several kinds of cells, of all but the first.
constexpr std::array<const char*, kBlocks> kBlockSuffixes{"edges",    "triangles", "quads", "tets",
                                                          "pyramids", "prisms",    "hexes"};
/// Numbers of element faces, by kind of cell and by face in kCellShapes.
constexpr std::array<std::array<std::int32_t, 6>, kCellKinds> kSides{
    {{2, 3, 1, 4, 0, 0}, {5, 1, 2, 3, 4, 0}, {4, 5, 1, 2, 3, 0}, {5, 6, 1, 2, 3, 4}}};
constexpr std::size_t kNameBytes = 256;  // with a zero behind, as the library has them
constexpr float kVersion = 8.03f;

class ExodusWriter {
 public:
  ExodusWriter(const Mesh& mesh, const BlockLoop& loop)
      : mesh_(mesh), loop_(loop), groups_(make_groups(mesh)), nodes_(mesh) {}

  void write(AtomicFile& file) {
    make_blocks();
    make_sets();
    put_heads();
    add_points();
    add_blocks();
    add_side_sets();
    add_node_sets();
    const NetcdfForm form = out_.needed_form();
    out_.write(file, form);
  }

 private:
  struct ElementBlock {
    std::string name;
    Block block;
    std::span<const std::uint32_t> members;  // of a group
    std::size_t before;                      // elements of the dimension before those of the kind
  };
  struct SideSet {
    std::string name;
    std::vector<std::int32_t> elements, sides;
  };
  struct NodeSet {
    std::string name;
    std::vector<std::uint32_t> points;
  };

  // Numbers of elements are places in the blocks.
  void make_blocks() {
    const std::size_t cells = cell_count(mesh_), faces = surface_count(mesh_);
    dim_ = cells > 0 ? 3 : faces > 0 ? 2 : 1;
    numbers_.resize(cells > 0 ? cells : faces > 0 ? faces : mesh_.edge_to_vert.size());
    std::set<std::string> taken;
    for (const Group& group : groups_[static_cast<std::size_t>(dim_)]) taken.insert(lower_case(group.name));
    std::int32_t next = 0;
    for (const Group& group : groups_[static_cast<std::size_t>(dim_)]) {
      std::string name = group.name;
      std::size_t before = 0;
      for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) {
        if (dimension_of(block) != dim_) return;
        const auto begin = std::ranges::lower_bound(group.elements, before);
        const auto end = std::ranges::lower_bound(group.elements, before + elements.size());
        if (begin != end) {
          if (begin != group.elements.begin())
            name = own_name(group.name + "_" + kBlockSuffixes[static_cast<std::size_t>(block)], taken);
          blocks_.push_back({name, block, std::span(begin, end), before});
        }
        before += elements.size();
      });
      for (const std::uint32_t element : group.elements) numbers_[element] = ++next;
    }
  }

  // Of a face between two regions, the sides of the region with the lower tag.
  void make_sets() {
    for (int dim = dim_ - 1; dim >= 0; --dim)
      for (const Group& group : groups_[static_cast<std::size_t>(dim)])
        node_sets_.push_back({group.name, points_of(mesh_, nodes_, dim, group)});
    if (dim_ < 3) return;
    const CellFaces faces(mesh_, loop_, FacesOf::Surface);
    for (const Group& group : groups_[2]) {
      SideSet set{group.name, {}, {}};
      for (const std::uint32_t element : group.elements) {
        const std::uint32_t face = faces.find_side(element);
        if (face == kNone) continue;
        const std::uint32_t cell = faces.cell(face);
        set.elements.push_back(numbers_[cell]);
        set.sides.push_back(kSides[static_cast<std::size_t>(faces.kind_of_cell(cell))][faces.local(face)]);
      }
      if (!set.elements.empty()) side_sets_.push_back(std::move(set));
    }
  }

  void put_heads() {
    out_.put("api_version", kVersion);
    out_.put("version", kVersion);
    out_.put("floating_point_word_size", 8);
    out_.put("file_size", 1);
    out_.put("maximum_name_length", static_cast<std::int32_t>(kNameBytes - 1));
    out_.put("int64_status", 0);
    out_.put("title", std::string("tetloom"));
    names_ = out_.add_dimension("len_name", kNameBytes);
    out_.add_variable("time_whole", NetcdfType::Float64, {out_.add_growing_dimension("time_step")});
  }

  void add_points() {
    const std::size_t count = mesh_.points.size();
    const auto axes = out_.add_dimension("num_dim", 3), points = out_.add_dimension("num_nodes", count);
    for (int axis = 0; axis < 3; ++axis)
      out_.add_variable(
          std::string("coord") + "xyz" [axis], NetcdfType::Float64, { points },
          [this, count, axis](AtomicFile& file) {
            put_big_endian(
                file, count, [&](std::size_t v) { return mesh_.points[v][axis]; }, loop_);
          });
    out_.add_texts("coor_names", axes, names_, {"x", "y", "z"});
  }

  /// The dimension of a list of blocks or sets; their states, numbers and names.
  template <class Item>
  void add_list(const std::string& dimension, const std::string& prefix, const std::string& states,
                const std::vector<Item>& items) {
    const auto count = out_.add_dimension(dimension, items.size());
    std::vector<std::int32_t> numbers;
    std::vector<std::string> names;
    for (const Item& item : items) {
      numbers.push_back(static_cast<std::int32_t>(numbers.size() + 1));
      names.push_back(item.name);
    }
    out_.add_integers(prefix + states, count, std::vector<std::int32_t>(items.size(), 1));
    out_.add_integers(prefix + "_prop1", count, std::move(numbers));
    out_.put_on_variable("name", "ID");
    out_.add_texts(prefix + "_names", count, names_, names);
  }

  void add_blocks() {
    out_.add_dimension("num_elem", numbers_.size());
    add_list("num_el_blk", "eb", "_status", blocks_);
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const ElementBlock& block = blocks_[i];
      const std::string number = std::to_string(i + 1);
      const auto count = out_.add_dimension("num_el_in_blk" + number, block.members.size()),
                 size = out_.add_dimension("num_nod_per_el" + number, nodes_.count(block.block));
      out_.add_variable("connect" + number, NetcdfType::Int32, {count, size}, [this, block](AtomicFile& file) {
        visit_block(mesh_, block.block,
                    [&](const auto& elements, const auto& entities) { put_nodes(file, block, elements, entities); });
      });
      const auto& types = nodes_.are_second_order() ? kExodusTypes2 : kExodusTypes;
      out_.put_on_variable("elem_type", types[static_cast<std::size_t>(block.block)]);
    }
  }

  template <class Elements>
  void put_nodes(AtomicFile& file, const ElementBlock& block, const Elements& elements,
                 const std::vector<std::uint32_t>& entities) const {
    const std::span<const LocalEdge> edges = edges_up_first(block.block);
    const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t e = block.members[i] - block.before;
        for (const std::uint32_t v : nodes_.of(turned_outwards(mesh_, dim_, elements[e], entities[e]), edges)) {
          const std::uint32_t number = byte_swapped(v + 1);
          std::memcpy(out, &number, sizeof(number));
          out += sizeof(number);
        }
      }
    };
    file.write_records(block.members.size(), nodes_.count(block.block) * sizeof(std::uint32_t), encode, loop_);
  }

  void add_side_sets() {
    if (side_sets_.empty()) return;
    add_list("num_side_sets", "ss", "_status", side_sets_);
    for (std::size_t i = 0; i < side_sets_.size(); ++i) {
      const std::string number = std::to_string(i + 1);
      const auto count = out_.add_dimension("num_side_ss" + number, side_sets_[i].elements.size());
      add_numbers("elem_ss" + number, count, side_sets_[i].elements, 0);
      add_numbers("side_ss" + number, count, side_sets_[i].sides, 0);
    }
  }

  void add_node_sets() {
    if (node_sets_.empty()) return;
    add_list("num_node_sets", "ns", "_status", node_sets_);
    for (std::size_t i = 0; i < node_sets_.size(); ++i) {
      const std::string number = std::to_string(i + 1);
      add_numbers("node_ns" + number, out_.add_dimension("num_nod_ns" + number, node_sets_[i].points.size()),
                  node_sets_[i].points, 1);
    }
  }

  template <class Number>
  void add_numbers(const std::string& name, NetcdfWriter::Dimension count, const std::vector<Number>& numbers,
                   std::type_identity_t<Number> more) {
    out_.add_variable(name, NetcdfType::Int32, {count}, [this, &numbers, more](AtomicFile& file) {
      put_big_endian(
          file, numbers.size(), [&](std::size_t i) { return numbers[i] + more; }, loop_);
    });
  }

  const Mesh& mesh_;
  const BlockLoop& loop_;
  Groups groups_;
  ElementNodes nodes_;
  NetcdfWriter out_;
  NetcdfWriter::Dimension names_ = 0;
  int dim_ = 3;                        // of the elements in blocks
  std::vector<std::int32_t> numbers_;  // of those elements, from 1
  std::vector<ElementBlock> blocks_;
  std::vector<SideSet> side_sets_;
  std::vector<NodeSet> node_sets_;
};

}  // namespace

void write_exodus(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  const std::size_t most = std::max({mesh.points.size(), cell_count(mesh), surface_count(mesh)});
  if (most > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorCode::InvalidArgument, "Exodus files are written with at most 2^31 - 1 points and elements");
  ExodusWriter(mesh, loop).write(file);
}

}  // namespace tetloom::detail
