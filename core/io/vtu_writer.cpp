// VTK XML unstructured grid, raw appended data with 64-bit sizes, as "VTK XML Formats" (docs.vtk.org) describes it.
// Cells are edges, triangles, quadrilaterals, tets, pyramids, wedges and hexahedra, in this order and each in the order
// of the mesh. Fields on cells are NaN at edges and surface elements.
#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "core/io/element_nodes_detail.hpp"
#include "core/io/formats_detail.hpp"
#include "core/io/vtu_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

struct DataArray {
  const char* section;  ///< the XML element that it belongs to
  std::string name;
  const char* type;
  std::size_t components;
  std::size_t tuples;
  std::size_t bytes;
  std::function<void()> write;
};

class VtuWriter {
 public:
  VtuWriter(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop,
            const std::span<const std::uint64_t>* global_ids = nullptr)
      : mesh_(mesh), file_(file), loop_(loop), nodes_(mesh) {
    for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
      cells_ += elements.size();
      connected_ += elements.size() * nodes_.count(block);
    });
    add_attributes();
    add_point_data();
    if (global_ids != nullptr)
      add("PointData", std::string(kGlobalId), "UInt64", 1, global_ids->size(), 8,
          [this, ids = *global_ids] { file_.write(ids.data(), ids.size_bytes()); });
    add_cell_data();
    add_fields();
    add("Points", "Points", "Float64", 3, mesh.points.size(), 8,
        [this] { file_.write(mesh_.points.data(), mesh_.points.size() * sizeof(Vec3)); });
    constexpr std::size_t kLargest32 = std::numeric_limits<std::int32_t>::max();
    if (connected_ <= kLargest32 && mesh.points.size() <= kLargest32)
      add_cells<std::int32_t>("Int32");
    else
      add_cells<std::int64_t>("Int64");
  }

  void write() {
    // Data lie in the file in the opposite order of their arrays in the header. To VTK the order is all the same, but
    // meshio 5 rewrites the offsets of raw data one by one and searches for the next one among old and new offsets:
    // this way the right one is always the first that it meets.
    std::vector<std::uint64_t> offsets(arrays_.size());
    std::uint64_t end = 0;
    for (std::size_t i = arrays_.size(); i-- > 0;) {
      offsets[i] = end;
      end += 8 + arrays_[i].bytes;
    }
    write_header(offsets);
    for (std::size_t i = arrays_.size(); i-- > 0;) {
      file_.put(std::uint64_t{arrays_[i].bytes});
      arrays_[i].write();
    }
    file_.write("\n  </AppendedData>\n</VTKFile>\n");
  }

 private:
  void add(const char* section, std::string name, const char* type, std::size_t components, std::size_t tuples,
           std::size_t number_bytes, std::function<void()> write) {
    arrays_.push_back(
        {section, std::move(name), type, components, tuples, components * tuples * number_bytes, std::move(write)});
  }

  // Strings go as bytes, each ended by a zero: the String arrays of VTK are unknown to other readers.
  void add_strings(std::string name, std::vector<std::string> strings) {
    std::string bytes;
    for (const std::string& text : strings) bytes += text.substr(0, text.find('\0')) + '\0';
    const std::size_t size = bytes.size();
    add("FieldData", std::move(name), "UInt8", 1, size, 1, [this, bytes = std::move(bytes)] { file_.write(bytes); });
  }

  void add_attributes() {
    for (std::size_t dim = 0; dim < 4; ++dim) {
      const std::vector<EntityAttributes>& table = mesh_.entities[dim];
      if (table.empty()) continue;
      const std::string kind(kEntityKinds[dim]);
      const auto add_texts = [&](const char* what, std::string EntityAttributes::*member) {
        std::vector<std::string> texts;
        for (const EntityAttributes& entity : table) texts.push_back(entity.*member);
        add_strings(kind + what, std::move(texts));
      };
      add_texts("_names", &EntityAttributes::name);
      add_texts("_layers", &EntityAttributes::layer);
      if (std::ranges::any_of(table, [](const EntityAttributes& entity) { return !entity.group.empty(); }))
        add_texts("_groups", &EntityAttributes::group);
      add("FieldData", kind + "_colors", "Float32", 4, table.size(), 4, [this, &table] {
        for (const EntityAttributes& entity : table) {
          const Color color = entity.color.value_or(Color{});
          for (const float x : {color.red, color.green, color.blue, entity.color ? 1.0f : 0.0f}) file_.put(x);
        }
      });
      add("FieldData", kind + "_tolerances", "Float64", 1, table.size(), 8, [this, &table] {
        for (const EntityAttributes& entity : table) file_.put(entity.tolerance);
      });
    }
    if (mesh_.face_to_sides.empty()) return;
    add("FieldData", "face_sides", "UInt32", 2, mesh_.face_to_sides.size(), 4, [this] {
      for (const FaceSides& sides : mesh_.face_to_sides)
        for (const ModelRegionId region : {sides.front, sides.back}) file_.put(region.tag());
    });
  }

  void add_point_data() {
    const std::size_t count = mesh_.points.size();
    add("PointData", std::string(kEntityDim), "Int8", 1, count, 1, [this, count] {
      const auto dim_of = [this](std::size_t i) {
        const ModelEntity entity = entity_of_point(mesh_, i);
        return static_cast<std::int8_t>(entity.valid() ? entity.dim : -1);
      };
      file_.put_each(count, dim_of, loop_);
    });
    add("PointData", std::string(kEntityTag), "UInt32", 1, count, 4, [this, count] {
      file_.put_each(
          count, [this](std::size_t i) { return point_tag(mesh_, i); }, loop_);
    });
  }

  void add_cell_data() {
    add("CellData", std::string(kEntityDim), "Int8", 1, cells_, 1, [this] {
      put_per_cell([](Block block, std::uint32_t) { return static_cast<std::int8_t>(dimension_of(block)); });
    });
    add("CellData", std::string(kEntityTag), "UInt32", 1, cells_, 4,
        [this] { put_per_cell([](Block, std::uint32_t entity) { return tag_of_index(entity); }); });
    add("CellData", std::string(kRegion), "UInt32", 1, cells_, 4, [this] {
      put_per_cell(
          [](Block block, std::uint32_t entity) { return dimension_of(block) == 3 ? tag_of_index(entity) : 0u; });
    });
  }

  void add_fields() {
    for (const MeshField& field : mesh_.point_fields)
      add_field("PointData", field, mesh_.points.size(), [this, &field] { put_values(field); });
    for (const MeshField& field : mesh_.cell_fields)
      add_field("CellData", field, cells_, [this, &field] {
        const std::size_t others = mesh_.edge_to_vert.size() + surface_count(mesh_);
        file_.put_each(
            others * static_cast<std::size_t>(field.components),
            [](std::size_t) { return std::numeric_limits<double>::quiet_NaN(); }, loop_);
        put_values(field);
      });
  }
  void add_field(const char* section, const MeshField& field, std::size_t tuples, std::function<void()> write) {
    if (is_classification(field.name, section == std::string_view("PointData")))
      throw Error(ErrorCode::InvalidArgument,
                  "a field has the name '" + field.name + "', under which VTU files keep the classification");
    add(section, field.name, "Float64", static_cast<std::size_t>(field.components), tuples, 8, std::move(write));
  }
  void put_values(const MeshField& field) { file_.write(field.values.data(), field.values.size() * sizeof(double)); }

  template <class Value>
  void put_per_cell(const Value& value) {
    for_each_block(mesh_, [&](Block block, const auto&, const auto& entities) {
      file_.put_each(
          entities.size(), [&](std::size_t i) { return value(block, entities[i]); }, loop_);
    });
  }

  template <class Index>
  void add_cells(const char* type) {
    add("Cells", "connectivity", type, 1, connected_, sizeof(Index), [this] {
      for_each_block(mesh_, [this](Block block, const auto& elements, const auto&) {
        const auto encode = [&](std::size_t begin, std::size_t end, char* out) {
          for (std::size_t e = begin; e < end; ++e)
            for (const std::uint32_t node : nodes_.of(turned_for_vtk(elements[e]), block)) {
              const auto index = static_cast<Index>(node);
              std::memcpy(out, &index, sizeof(Index));
              out += sizeof(Index);
            }
        };
        file_.write_records(elements.size(), nodes_.count(block) * sizeof(Index), encode, loop_);
      });
    });
    add("Cells", "offsets", type, 1, cells_, sizeof(Index), [this] {
      std::size_t first = 0;
      for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) {
        const std::size_t size = nodes_.count(block);
        file_.put_each(
            elements.size(), [&](std::size_t e) { return static_cast<Index>(first + (e + 1) * size); }, loop_);
        first += elements.size() * size;
      });
    });
    add("Cells", "types", "UInt8", 1, cells_, 1, [this] {
      const auto& types = nodes_.are_second_order() ? kVtkTypes2 : kVtkTypes;
      put_per_cell([&](Block block, std::uint32_t) { return types[static_cast<std::size_t>(block)]; });
    });
  }

  void write_header(const std::vector<std::uint64_t>& offsets) {
    file_.write(
        "<?xml version=\"1.0\"?>\n"
        "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
        "  <UnstructuredGrid>\n");
    write_section("FieldData", offsets);
    file_.write("    <Piece NumberOfPoints=\"" + std::to_string(mesh_.points.size()) + "\" NumberOfCells=\"" +
                std::to_string(cells_) + "\">\n");
    for (const char* section : {"PointData", "CellData", "Points", "Cells"}) write_section(section, offsets);
    file_.write("    </Piece>\n  </UnstructuredGrid>\n  <AppendedData encoding=\"raw\">\n   _");
  }

  void write_section(std::string_view section, const std::vector<std::uint64_t>& offsets) {
    std::string lines;
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
      const DataArray& array = arrays_[i];
      if (array.section != section) continue;
      lines += "        <DataArray type=\"" + std::string(array.type) + "\" Name=\"" + xml_escaped(array.name) + "\"";
      lines += " NumberOfComponents=\"" + std::to_string(array.components) + "\"";
      if (section == "FieldData") lines += " NumberOfTuples=\"" + std::to_string(array.tuples) + "\"";
      lines += " format=\"appended\" offset=\"" + std::to_string(offsets[i]) + "\"/>\n";
    }
    const std::string name(section);
    if (!lines.empty()) file_.write("      <" + name + ">\n" + lines + "      </" + name + ">\n");
  }

  const Mesh& mesh_;
  AtomicFile& file_;
  const BlockLoop& loop_;
  ElementNodes nodes_;
  std::size_t cells_ = 0, connected_ = 0;
  std::vector<DataArray> arrays_;
};

}  // namespace

void write_vtu(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) { VtuWriter(mesh, file, loop).write(); }

void write_vtu_piece(const Mesh& mesh, std::span<const std::uint64_t> global_ids, AtomicFile& file,
                     const BlockLoop& loop) {
  VtuWriter(mesh, file, loop, &global_ids).write();
}

}  // namespace tetloom::detail
