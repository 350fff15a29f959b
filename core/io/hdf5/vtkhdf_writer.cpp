// VTKHDF 1.0, an unstructured grid of one part ("VTKHDF format specification", docs.vtk.org), with the arrays that VTU
// files of our own have, but for colours, layers, tolerances and sides of entities. Cells stand in the order of VTU.
#include <limits>

#include "core/io/element_nodes_detail.hpp"
#include "core/io/hdf5/hdf5_writer_detail.hpp"
#include "core/io/vtu_detail.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

const std::string kRoot = "/VTKHDF";

class VtkHdfWriter {
 public:
  VtkHdfWriter(const Mesh& mesh, const BlockLoop& loop) : mesh_(mesh), loop_(loop), nodes_(mesh) {
    for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
      cells_ += elements.size();
      connected_ += elements.size() * nodes_.count(block);
    });
  }

  void write(AtomicFile& file) {
    out_.add_group(kRoot);
    out_.put(kRoot, "Version", std::span<const std::int64_t>(kVersion));
    out_.put(kRoot, "Type", "UnstructuredGrid", std::string_view("UnstructuredGrid").size());
    for (const auto& [name, count] : {std::pair("NumberOfPoints", mesh_.points.size()),
                                      {"NumberOfCells", cells_},
                                      {"NumberOfConnectivityIds", connected_}})
      out_.add_values<std::int64_t>(kRoot + "/" + name, {static_cast<std::int64_t>(count)});
    out_.add_array(kRoot + "/Points", Hdf5Type::Float64, {mesh_.points.size(), 3},
                   [this](AtomicFile& to) { to.write(mesh_.points.data(), mesh_.points.size() * sizeof(Vec3)); });
    add_cells();
    add_point_data();
    add_cell_data();
    add_names();
    out_.write(file);
  }

 private:
  static constexpr std::array<std::int64_t, 2> kVersion{1, 0};

  void add_cells() {
    out_.add_array(kRoot + "/Connectivity", Hdf5Type::Int64, {connected_}, [this](AtomicFile& file) {
      for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) { put_nodes(file, block, elements); });
    });
    out_.add_array(kRoot + "/Offsets", Hdf5Type::Int64, {cells_ + 1}, [this](AtomicFile& file) {
      std::size_t first = 0;
      file.put(std::int64_t{0});
      for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) {
        const std::size_t size = nodes_.count(block);
        file.put_each(
            elements.size(), [&](std::size_t e) { return static_cast<std::int64_t>(first + (e + 1) * size); }, loop_);
        first += elements.size() * size;
      });
    });
    add_per_cell<std::uint8_t>("/Types", [this](Block block, std::uint32_t) {
      return (nodes_.are_second_order() ? kVtkTypes2 : kVtkTypes)[static_cast<std::size_t>(block)];
    });
  }

  template <class Elements>
  void put_nodes(AtomicFile& file, Block block, const Elements& elements) {
    const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t e = begin; e < end; ++e)
        for (const std::int64_t node : nodes_.of(turned_for_vtk(elements[e]), block)) {
          std::memcpy(out, &node, sizeof(node));
          out += sizeof(node);
        }
    };
    file.write_records(elements.size(), nodes_.count(block) * sizeof(std::int64_t), encode, loop_);
  }

  template <class Value, class ValueOf>
  void add_per_cell(const std::string& path, const ValueOf& value) {
    out_.add_array(kRoot + path, hdf5_type_of<Value>(), {cells_}, [this, value](AtomicFile& file) {
      for_each_block(mesh_, [&](Block block, const auto&, const auto& entities) {
        file.put_each(
            entities.size(), [&](std::size_t e) { return static_cast<Value>(value(block, entities[e])); }, loop_);
      });
    });
  }

  template <class Value, class ValueOf>
  void add_per_point(std::string_view name, const ValueOf& value) {
    const std::size_t count = mesh_.points.size();
    out_.add_array(kRoot + "/PointData/" + std::string(name), hdf5_type_of<Value>(), {count},
                   [this, count, value](AtomicFile& file) { file.put_each(count, value, loop_); });
  }

  void add_point_data() {
    out_.add_group(kRoot + "/PointData");
    add_per_point<std::int8_t>(kEntityDim, [this](std::size_t i) {
      const ModelEntity entity = entity_of_point(mesh_, i);
      return static_cast<std::int8_t>(entity.valid() ? entity.dim : -1);
    });
    add_per_point<std::uint32_t>(kEntityTag, [this](std::size_t i) { return point_tag(mesh_, i); });
    for (const MeshField& field : mesh_.point_fields) add_field("/PointData/", field, mesh_.points.size(), 0);
  }

  void add_cell_data() {
    const std::string group = "/CellData/";
    out_.add_group(kRoot + "/CellData");
    add_per_cell<std::int8_t>(group + std::string(kEntityDim),
                              [](Block block, std::uint32_t) { return dimension_of(block); });
    add_per_cell<std::uint32_t>(group + std::string(kEntityTag),
                                [](Block, std::uint32_t entity) { return tag_of_index(entity); });
    add_per_cell<std::uint32_t>(group + std::string(kRegion), [](Block block, std::uint32_t entity) {
      return dimension_of(block) == 3 ? tag_of_index(entity) : 0u;
    });
    const std::size_t others = mesh_.edge_to_vert.size() + surface_count(mesh_);
    for (const MeshField& field : mesh_.cell_fields) add_field(group, field, cells_, others);
  }

  // `missing` tuples of NaN come first.
  void add_field(const std::string& group, const MeshField& field, std::size_t tuples, std::size_t missing) {
    if (is_classification(field.name, group == "/PointData/") || field.name.find('/') != std::string::npos ||
        field.name == ".")
      throw Error(ErrorCode::InvalidArgument,
                  "a field has the name '" + field.name + "', which an array of a VTKHDF file cannot have");
    const auto components = static_cast<std::size_t>(field.components);
    std::vector<std::uint64_t> shape{tuples};
    if (components != 1) shape.push_back(components);
    out_.add_array(
        kRoot + group + field.name, Hdf5Type::Float64, shape, [this, &field, missing, components](AtomicFile& file) {
          file.put_each(
              missing * components, [](std::size_t) { return std::numeric_limits<double>::quiet_NaN(); }, loop_);
          file.write(field.values.data(), field.values.size() * sizeof(double));
        });
  }

  // As in VTU files: bytes, each name ended by a zero.
  void add_names() {
    out_.add_group(kRoot + "/FieldData");
    for (std::size_t dim = 0; dim < 4; ++dim) {
      std::vector<std::uint8_t> bytes;
      for (const EntityAttributes& entity : mesh_.entities[dim]) {
        for (const char c : entity.name.substr(0, entity.name.find('\0')))
          bytes.push_back(static_cast<std::uint8_t>(c));
        bytes.push_back(0);
      }
      if (!bytes.empty()) out_.add_values(kRoot + "/FieldData/" + std::string(kEntityKinds[dim]) + "_names", bytes);
    }
  }

  const Mesh& mesh_;
  const BlockLoop& loop_;
  ElementNodes nodes_;
  std::size_t cells_ = 0, connected_ = 0;
  Hdf5Writer out_;
};

}  // namespace

void write_vtkhdf(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) { VtkHdfWriter(mesh, loop).write(file); }

}  // namespace tetloom::detail
