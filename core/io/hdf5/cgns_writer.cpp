// CGNS 3.4 in HDF5, as "SIDS-to-HDF5 File Mapping" describes it: one base with one unstructured zone. Every region,
// face and edge is a section for each kind of its elements, every face a boundary condition and a family as well.
// Sections of cells come first, then those of faces, then those of edges.
#include <limits>
#include <set>

#include "core/io/hdf5/cgns_detail.hpp"
#include "core/io/hdf5/hdf5_writer_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

const std::string kBase = "/Base", kZone = "/Base/Zone";

class CgnsWriter {
 public:
  CgnsWriter(const Mesh& mesh, const BlockLoop& loop)
      : mesh_(mesh), loop_(loop), groups_(make_groups(mesh)), nodes_(mesh) {}

  void write(AtomicFile& file) {
    add_root();
    add_zone();
    add_coordinates();
    for (const int dim : {3, 2, 1})
      for (const Group& group : groups_[static_cast<std::size_t>(dim)]) add_group(dim, group);
    add_conditions();
    out_.write(file);
  }

 private:
  struct Condition {
    std::string name;
    std::int32_t first, last;  // elements
  };

  // A node: a group that says what it is.
  std::string node(const std::string& parent, const std::string& name, const std::string& label, const char* type) {
    const std::string path = parent + "/" + name;
    constexpr std::array<std::int32_t, 1> kFlags{1};
    out_.add_group(path);
    put_identity(path, name, label, type);
    out_.put(path, "flags", std::span<const std::int32_t>(kFlags));
    return path;
  }
  void put_identity(const std::string& path, const std::string& name, const std::string& label, const char* type) {
    out_.put(path, "name", name, kCgnsNameBytes + 1);
    out_.put(path, "label", label, kCgnsNameBytes + 1);
    out_.put(path, "type", type, 3);
  }
  void text_node(const std::string& parent, const std::string& name, const std::string& label, std::string_view text) {
    out_.add_values<std::int8_t>(node(parent, name, label, "C1") + "/ data", {text.begin(), text.end()});
  }
  void integer_node(const std::string& parent, const std::string& name, const std::string& label,
                    std::vector<std::int32_t> values) {
    out_.add_values(node(parent, name, label, "I4") + "/ data", std::move(values));
  }
  // In a matrix of Fortran with one row.
  void add_row(const std::string& path, const std::vector<std::int32_t>& values) {
    out_.add_array(path + "/ data", Hdf5Type::Int32, {values.size(), 1}, [values](AtomicFile& file) {
      for (const std::int32_t value : values) file.put(value);
    });
  }

  void add_root() {
    const auto add_text = [&](const std::string& path, std::string text, std::size_t bytes) {
      text.resize(bytes, '\0');
      out_.add_values<std::int8_t>(path, {text.begin(), text.end()});
    };
    put_identity("/", "HDF5 MotherNode", "Root Node of HDF5 File", "MT");
    add_text("/ format", "IEEE_LITTLE_32", 15);
    add_text("/ hdf5version", "HDF5 Version 1.8.0", 33);
    out_.add_values<float>(node("", "CGNSLibraryVersion", "CGNSLibraryVersion_t", "R4") + "/ data", {3.4f});
  }

  void add_zone() {
    const std::size_t cells = cell_count(mesh_);
    const std::int32_t dim = cells > 0 ? 3 : surface_count(mesh_) > 0 ? 2 : 1;
    const std::size_t own = cells > 0 ? cells : dim == 2 ? surface_count(mesh_) : mesh_.edge_to_vert.size();
    integer_node("", kBase.substr(1), "CGNSBase_t", {dim, 3});
    add_units();
    node(kBase, "Zone", "Zone_t", "I4");
    add_row(kZone, {static_cast<std::int32_t>(mesh_.points.size()), static_cast<std::int32_t>(own), 0});
    text_node(kZone, "ZoneType", "ZoneType_t", "Unstructured");
  }

  // Coordinates are lengths, of a unit that the file does not say.
  void add_units() {
    text_node(kBase, "DataClass", "DataClass_t", "Dimensional");
    std::string units;  // of mass, length, time, temperature, angle
    for (const char* unit : {"Null", "UserDefined", "Null", "Null", "Null"}) {
      units += unit;
      units.resize((units.size() + kCgnsNameBytes - 1) / kCgnsNameBytes * kCgnsNameBytes, ' ');
    }
    out_.add_array(node(kBase, "DimensionalUnits", "DimensionalUnits_t", "C1") + "/ data", Hdf5Type::Int8,
                   {units.size() / kCgnsNameBytes, kCgnsNameBytes}, [units](AtomicFile& file) { file.write(units); });
  }

  void add_coordinates() {
    const std::string grid = node(kZone, "GridCoordinates", "GridCoordinates_t", "MT");
    const std::size_t count = mesh_.points.size();
    for (int axis = 0; axis < 3; ++axis) {
      const std::string path = node(grid, std::string("Coordinate") + "XYZ"[axis], "DataArray_t", "R8");
      out_.add_array(path + "/ data", Hdf5Type::Float64, {count}, [this, count, axis](AtomicFile& file) {
        file.put_each(
            count, [&](std::size_t v) { return mesh_.points[v][axis]; }, loop_);
      });
      out_.add_values<float>(node(path, "DimensionalExponents", "DimensionalExponents_t", "R4") + "/ data",
                             {0, 1, 0, 0, 0});
    }
  }

  // A name that no other section has, whatever the file calls the rest.
  std::string own_name(const std::string& name) {
    constexpr std::size_t kRoom = 9;  // for a number, or a kind of elements
    std::string own = name.substr(0, kCgnsNameBytes - kRoom);
    for (int number = 2; !taken_.insert(own).second; ++number)
      own = name.substr(0, kCgnsNameBytes - 2 * kRoom) + "_" + std::to_string(number);
    return own;
  }

  void add_group(int dim, const Group& group) {
    const std::string name = own_name(group.name);
    const std::int32_t first = next_;
    std::size_t before = 0;  // of the block, among all elements of the dimension
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) {
      if (dimension_of(block) != dim) return;
      const auto begin = std::ranges::lower_bound(group.elements, before);
      const auto end = std::ranges::lower_bound(group.elements, before + elements.size());
      if (begin != end) {
        const std::string section = next_ == first ? name : name + "." + cgns_kind(block).name;
        add_section(block, section, elements, std::span(begin, end), before);
      }
      before += elements.size();
    });
    if (dim == 2 && cell_count(mesh_) > 0) conditions_.push_back({name, first, next_ - 1});
  }

  template <class Elements>
  void add_section(Block block, const std::string& name, const Elements& elements,
                   std::span<const std::uint32_t> members, std::size_t before) {
    const std::string section = node(kZone, name, "Elements_t", "I4");
    const CgnsKind& kind = cgns_kind(block);
    const auto count = static_cast<std::int32_t>(members.size());
    out_.add_values<std::int32_t>(section + "/ data", {nodes_.are_second_order() ? kind.second_type : kind.type, 0});
    integer_node(section, "ElementRange", "IndexRange_t", {next_, next_ + count - 1});
    next_ += count;
    const std::size_t size = nodes_.count(block);
    const std::string nodes = node(section, "ElementConnectivity", "DataArray_t", "I4");
    out_.add_array(nodes + "/ data", Hdf5Type::Int32, {members.size() * size},
                   [=, this, &elements](AtomicFile& file) { put_nodes(file, block, elements, members, before); });
  }

  template <class Elements>
  void put_nodes(AtomicFile& file, Block block, const Elements& elements, std::span<const std::uint32_t> members,
                 std::size_t before) const {
    const auto& entities = entities_of(block);
    const std::span<const LocalEdge> edges = edges_up_first(block);
    const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t e = members[i] - before;
        for (const std::uint32_t v :
             nodes_.of(turned_outwards(mesh_, dimension_of(block), elements[e], entities[e]), edges)) {
          const auto number = static_cast<std::int32_t>(v + 1);
          std::memcpy(out, &number, sizeof(number));
          out += sizeof(number);
        }
      }
    };
    file.write_records(members.size(), nodes_.count(block) * sizeof(std::int32_t), encode, loop_);
  }

  const std::vector<std::uint32_t>& entities_of(Block block) const {
    const std::vector<std::uint32_t>* found = nullptr;
    for_each_block(mesh_, [&](Block each, const auto&, const auto& entities) {
      if (each == block) found = &entities;
    });
    return *found;
  }

  void add_conditions() {
    if (conditions_.empty()) return;
    const std::string all = node(kZone, "ZoneBC", "ZoneBC_t", "MT");
    for (const Condition& condition : conditions_) {
      const std::string path = all + "/" + condition.name;
      text_node(all, condition.name, "BC_t", "FamilySpecified");
      add_row(node(path, "PointRange", "IndexRange_t", "I4"), {condition.first, condition.last});
      text_node(path, "GridLocation", "GridLocation_t", "FaceCenter");
      text_node(path, "FamilyName", "FamilyName_t", condition.name);
      const std::string family = node(kBase, condition.name, "Family_t", "MT");
      text_node(family, "FamBC", "FamilyBC_t", "UserDefined");
    }
  }

  const Mesh& mesh_;
  const BlockLoop& loop_;
  Groups groups_;
  ElementNodes nodes_;
  Hdf5Writer out_;
  std::int32_t next_ = 1;  // element
  std::set<std::string> taken_{"Zone", "ZoneType", "ZoneBC", "GridCoordinates", "DataClass", "DimensionalUnits"};
  std::vector<Condition> conditions_;
};

}  // namespace

void write_cgns(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  const std::size_t elements = mesh.edge_to_vert.size() + surface_count(mesh) + cell_count(mesh);
  if (std::max(mesh.points.size(), elements) > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error(ErrorCode::InvalidArgument, "CGNS files are written with at most 2^31 - 1 points and elements");
  CgnsWriter(mesh, loop).write(file);
}

}  // namespace tetloom::detail
