// VTK XML unstructured grids of any origin.
#include <algorithm>
#include <charconv>
#include <map>

#include "core/io/formats_detail.hpp"
#include "core/io/mid_node_reader_detail.hpp"
#include "core/io/slice_filter_detail.hpp"
#include "core/io/vtu_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

std::string describe_cell(std::int64_t type) {
  static const std::map<std::int64_t, const char*> names{{2, "poly-vertex"}, {4, "poly-line"}, {6, "triangle strip"},
                                                         {7, "polygon"},     {8, "pixel"},     {11, "voxel"},
                                                         {42, "polyhedron"}};
  const auto found = names.find(type);
  const std::string number = "VTK cell type " + std::to_string(type);
  return found == names.end() ? number : std::string(found->second) + " (" + number + ")";
}

/// Names under which writers of meshes keep what comes nearest to a model entity, best first.
constexpr std::array<std::string_view, 7> kTagNames{kEntityTag, "gmsh:geometrical", "medit:ref",  "CellEntityIds",
                                                    "region",   "material",         "MaterialIDs"};

/// What cells of a type are, and whether they have mid nodes.
struct CellType {
  Block block;
  bool is_second_order = false;
  std::size_t nodes() const { return vertices_of(block) + (is_second_order ? edges_of(block).size() : 0); }
};

std::optional<CellType> find_vtk_type(std::int64_t type) {
  for (std::size_t b = 0; b < kBlocks; ++b)
    if (type == kVtkTypes[b] || type == kVtkTypes2[b]) return CellType{static_cast<Block>(b), type == kVtkTypes2[b]};
  return {};
}

/// A field as it grows piece by piece. Cells may come in any order of their kinds, so each kind has its own values.
struct GrowingField {
  std::string name;
  std::size_t components = 1;
  std::array<std::vector<double>, kCellKinds> values;  ///< those on points are all in the first
};

/// After so many cells or points a slice's reader lets go of what lies behind it.
constexpr std::size_t kItemsBetweenReleases = std::size_t{1} << 17;

class VtuReader {
 public:
  explicit VtuReader(const InputFile& file, std::vector<std::uint64_t>* global_ids = nullptr)
      : file_(file), document_(parse_xml(file)), decoder_(file, document_), global_ids_(global_ids) {}

  Mesh read() {
    for (const XmlElement* piece : begin()) read_piece(*piece);
    finish_fields();
    if (global_ids_ != nullptr && mesh_.points.empty()) return std::move(mesh_);
    check_read_mesh(file_, mesh_);
    if (!points_are_classified_) classify_points(mesh_, corners_);
    mids_.finish(file_, mesh_, !points_are_classified_);
    return std::move(mesh_);
  }

  std::optional<FileSlice> read_slice(SliceFilter& filter) {
    filter_ = &filter;
    const std::vector<const XmlElement*> pieces = begin();
    for (const XmlElement* piece : pieces) count_tets(*piece);
    filter.set_points(first_point_);
    first_point_ = 0;
    for (const XmlElement* piece : pieces) read_piece(*piece);
    filter.begin_second_pass(mesh_);
    if (!filter.is_fit()) return {};
    first_point_ = 0, first_tet_ = 0;
    for (const XmlElement* piece : pieces) read_piece(*piece);
    finish_fields();
    return filter.finish(std::move(mesh_), corners_, points_are_classified_);
  }

 private:
  /// What a piece holds, decoded.
  struct Piece {
    VtuArray types, offsets, connectivity;
    std::optional<VtuArray> tags;
    std::string_view tag_name;
    std::uint32_t first_point = 0;
    std::size_t points = 0;
  };

  /// The pieces of the grid, once all that stands before them is read.
  std::vector<const XmlElement*> begin() {
    const XmlElement& root = document_.front();
    if (root.name != "VTKFile") file_.fail(ErrorCode::InputUnreadable, "no VTK file: its root is not VTKFile");
    if (root.attribute("type") != "UnstructuredGrid")
      file_.fail(ErrorCode::InputUnsuitable, "a VTK file of the type '" + std::string(root.attribute("type")) +
                                                 "'; only UnstructuredGrid is supported");
    decoder_.check_tail();
    const XmlElement* grid = child(root, "UnstructuredGrid");
    if (grid == nullptr) file_.fail(ErrorCode::InputUnreadable, "no element UnstructuredGrid");
    if (const XmlElement* fields = child(*grid, "FieldData")) read_attributes(*fields);
    std::vector<const XmlElement*> pieces;
    for (const std::size_t index : grid->children)
      if (document_[index].name == "Piece") pieces.push_back(&document_[index]);
    return pieces;
  }

  const XmlElement* child(const XmlElement& parent, std::string_view name) const {
    for (const std::size_t index : parent.children)
      if (document_[index].name == name) return &document_[index];
    return nullptr;
  }
  const XmlElement* array_named(const XmlElement* section, std::string_view name) const {
    if (section == nullptr) return nullptr;
    for (const std::size_t index : section->children)
      if (document_[index].name == "DataArray" && document_[index].attribute("Name") == name) return &document_[index];
    return nullptr;
  }
  std::optional<VtuArray> find(const XmlElement* section, std::string_view name) {
    const XmlElement* array = array_named(section, name);
    const bool numeric = array != nullptr && scalar_type(array->attribute("type")).has_value();
    return numeric ? std::optional(decoder_.decode(*array)) : std::nullopt;
  }
  VtuArray need(const XmlElement* section, std::string_view name) {
    std::optional<VtuArray> array = find(section, name);
    if (!array || !array->is_integer())
      file_.fail(ErrorCode::InputUnreadable, "no integer array '" + std::string(name) + "' among the cells");
    return std::move(*array);
  }
  /// An integer array of exactly `size` numbers, if there is one.
  std::optional<VtuArray> find_tags(const XmlElement* section, std::string_view name, std::size_t size) {
    std::optional<VtuArray> array = find(section, name);
    return array && array->is_integer() && array->size() == size ? std::move(array) : std::nullopt;
  }

  std::size_t declared(const XmlElement& piece, std::string_view key) const {
    const std::string_view digits = piece.attribute(key);
    std::size_t value = 0;
    if (std::from_chars(digits.data(), digits.data() + digits.size(), value).ec != std::errc())
      file_.fail_at_line("a piece without " + std::string(key), piece.name.data());
    return value;
  }
  void expect_size(const VtuArray& array, std::size_t size, const char* what) const {
    if (array.size() != size)
      file_.fail(ErrorCode::InputUnreadable, "the array of " + std::string(what) + " has " +
                                                 std::to_string(array.size()) + " numbers instead of " +
                                                 std::to_string(size));
  }

  bool is_first_pass() const { return filter_ != nullptr && filter_->is_first_pass(); }
  bool keeps_point(std::size_t point) const { return filter_ == nullptr || filter_->keeps_point(point); }

  void let_go_at(std::size_t item) const {
    if (filter_ != nullptr && item % kItemsBetweenReleases == 0) file_.let_go();
  }

  static std::array<std::size_t, 256> count_types(const VtuArray& types) {
    std::array<std::size_t, 256> counts{};
    for (std::size_t i = 0; i < types.size(); ++i) ++counts[static_cast<std::uint8_t>(types.integer(i))];
    return counts;
  }

  void count_tets(const XmlElement& piece) {
    first_point_ += declared(piece, "NumberOfPoints");
    if (declared(piece, "NumberOfCells") > 0) expect_cells(count_types(need(child(piece, "Cells"), "types")));
  }

  void expect_cells(const std::array<std::size_t, 256>& counts) {
    for (std::size_t b = 0; b < kBlocks; ++b) {
      filter_->expect(static_cast<Block>(b), counts[kVtkTypes[b]]);
      if (counts[kVtkTypes2[b]] > 0) filter_->set_unfit();
    }
  }

  void read_piece(const XmlElement& piece) {
    const std::size_t points = declared(piece, "NumberOfPoints"), cells = declared(piece, "NumberOfCells");
    if (points == 0 && cells == 0) return;
    const std::size_t first_point = first_point_;
    if (points >= 0xffffffffu - first_point) file_.fail(ErrorCode::InputUnsuitable, "the file has too many points");
    first_point_ += points;
    if (!is_first_pass()) read_points(piece, first_point, points);
    if (cells == 0) return;
    const XmlElement* section = child(piece, "Cells");
    Piece content{need(section, "types"),
                  need(section, "offsets"),
                  need(section, "connectivity"),
                  {},
                  {},
                  static_cast<std::uint32_t>(first_point),
                  points};
    expect_size(content.types, cells, "cell types");
    expect_size(content.offsets, cells, "cell offsets");
    for (const std::string_view name : kTagNames) {
      if (content.tags) break;
      content.tags = find_tags(child(piece, "CellData"), name, cells);
      content.tag_name = name;
    }
    add_cells(content, cells);
    if (is_first_pass()) return;
    const XmlElement* data = child(piece, "CellData");
    if (!has_cell_fields_)
      begin_fields(data, false, content.tags ? content.tag_name : std::string_view(), cell_fields_);
    has_cell_fields_ = true;
    const std::vector<bool> is_left_out = find_left_out(content);
    grow_fields(data, cells, cell_fields_, [&](std::size_t i) -> std::optional<std::size_t> {
      const std::optional<CellType> type = find_vtk_type(content.types.integer(i));
      if (!type || dimension_of(type->block) < 3 || (!is_left_out.empty() && is_left_out[i])) return {};
      return cell_kind_of(type->block);
    });
  }

  /// Of the cells of a piece: whether they are not in the slice; empty without one, or without fields.
  std::vector<bool> find_left_out(const Piece& piece) {
    std::vector<bool> is_left_out;
    if (filter_ == nullptr || cell_fields_.empty()) return is_left_out;
    is_left_out.assign(piece.types.size(), true);
    for (std::size_t i = 0; i < is_left_out.size(); ++i)
      if (piece.types.integer(i) == kVtkTypes[static_cast<std::size_t>(Block::Tet)])
        is_left_out[i] = !filter_->keeps_tet(first_tet_++);
    return is_left_out;
  }

  void read_points(const XmlElement& piece, std::size_t first_point, std::size_t count) {
    const XmlElement* section = child(piece, "Points");
    if (section == nullptr || section->children.empty())
      file_.fail(ErrorCode::InputUnreadable, "a piece without points");
    const VtuArray numbers = decoder_.decode(document_[section->children.front()]);
    expect_size(numbers, 3 * count, "points");
    std::size_t at = mesh_.points.size();
    if (filter_ == nullptr) reserve_more(mesh_.points, count);
    for (std::size_t i = 0; i < count; ++i) {
      let_go_at(i);
      if (keeps_point(first_point + i))
        mesh_.points.push_back({numbers.real(3 * i), numbers.real(3 * i + 1), numbers.real(3 * i + 2)});
    }
    mesh_.point_to_entity.resize(mesh_.points.size());
    const XmlElement* data = child(piece, "PointData");
    if (global_ids_ != nullptr) read_global_ids(data, count);
    if (first_point == 0) begin_fields(data, true, {}, point_fields_);
    grow_fields(data, count, point_fields_, [&](std::size_t i) {
      return keeps_point(first_point + i) ? std::optional(std::size_t{0}) : std::nullopt;
    });
    const std::optional<VtuArray> dims = find_tags(data, kEntityDim, count), tags = find_tags(data, kEntityTag, count);
    if (!dims || !tags) return;
    points_are_classified_ = true;
    for (std::size_t i = 0; i < count; ++i) {
      if (!keeps_point(first_point + i)) continue;
      const std::int64_t dim = dims->integer(i);
      const std::uint32_t index = index_of_tag(tags->integer(i));
      if (dim >= 0 && dim <= 3 && index != ModelFaceId::kNone)
        mesh_.point_to_entity[at] = {static_cast<int>(dim), index};
      ++at;
    }
  }

  void read_global_ids(const XmlElement* data, std::size_t count) {
    const XmlElement* array = array_named(data, kGlobalId);
    if (array == nullptr || !is_global_id(kGlobalId, array->attribute("type")))
      file_.fail(ErrorCode::InputUnsuitable, "the points have no array 'global_id' of the type UInt64");
    const VtuArray ids = decoder_.decode(*array);
    expect_size(ids, count, "global ids");
    for (std::size_t i = 0; i < count; ++i) {
      const std::int64_t id = ids.integer(i);
      if (id < 0) file_.fail(ErrorCode::InputUnreadable, "a global id is not below 2^63");
      global_ids_->push_back(static_cast<std::uint64_t>(id));
    }
  }

  void add_cells(const Piece& piece, std::size_t cells) {
    if (filter_ == nullptr) {
      reserve_cells(piece);
    } else if (!is_first_pass()) {
      expect_cells(count_types(piece.types));
    }
    std::int64_t begin = 0;
    for (std::size_t i = 0; i < cells; ++i) {
      let_go_at(i);
      const std::int64_t end = piece.offsets.integer(i);
      const std::int64_t type = piece.types.integer(i);
      const std::optional<CellType> of_cell = find_vtk_type(type);
      const bool is_refused = of_cell ? of_cell->is_second_order && global_ids_ != nullptr : type != kVtkVertex;
      if (is_refused) refuse_elements(file_, describe_cell(type));
      const std::size_t nodes = of_cell ? of_cell->nodes() : 1;
      if (end < begin || static_cast<std::uint64_t>(end) > piece.connectivity.size() ||
          static_cast<std::uint64_t>(end - begin) != nodes)
        file_.fail(ErrorCode::InputUnreadable, "cell " + std::to_string(i) + " has the wrong number of points");
      const std::uint32_t index = piece.tags ? index_of_tag(piece.tags->integer(i)) : ModelFaceId::kNone;
      const auto at = static_cast<std::size_t>(begin);
      begin = end;
      if (is_first_pass() && !is_tet_of_slice(type)) continue;
      if (filter_ != nullptr && of_cell && !filter_->wants(of_cell->block)) continue;
      if (of_cell)
        visit_block(mesh_, of_cell->block,
                    [&](auto& elements, auto& entities) { add(piece, at, *of_cell, index, elements, entities); });
      else
        corners_.push_back({vertex(piece, at), index});
    }
  }

  bool is_tet_of_slice(std::int64_t type) {
    return type == kVtkTypes[static_cast<std::size_t>(Block::Tet)] && filter_->keeps_tet(first_tet_++);
  }

  /// Memory for the cells, once their number of each type is known.
  void reserve_cells(const Piece& piece) {
    const std::array<std::size_t, 256> counts = count_types(piece.types);
    for_each_block(mesh_, [&](Block block, auto& elements, auto& entities) {
      const auto b = static_cast<std::size_t>(block);
      const std::size_t count = counts[kVtkTypes[b]] + counts[kVtkTypes2[b]];
      reserve_more(elements, count);
      reserve_more(entities, count);
    });
  }

  std::size_t components_of(const XmlElement& array) const {
    const std::string_view digits = array.attribute("NumberOfComponents");
    if (digits.empty()) return 1;
    std::size_t value = 0;
    const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (result.ec != std::errc() || value < 1 || value > kMostVtuComponents)
      file_.fail_at_line("an array with the number of components '" + std::string(digits.substr(0, 20)) + "'",
                         array.name.data());
    return value;
  }

  /// Takes the names of the fields from the arrays of the first piece.
  void begin_fields(const XmlElement* section, bool of_points, std::string_view tag_name,
                    std::vector<GrowingField>& fields) const {
    if (section == nullptr) return;
    for (const std::size_t index : section->children) {
      const XmlElement& array = document_[index];
      const std::string_view name = array.attribute("Name");
      const bool numeric = array.name == "DataArray" && scalar_type(array.attribute("type")).has_value();
      if (!numeric || name.empty() || name == tag_name || is_classification(name, of_points)) continue;
      if (of_points && is_global_id(name, array.attribute("type"))) continue;
      const std::string plain = xml_unescaped(name);
      const bool known = std::any_of(fields.begin(), fields.end(), [&](const auto& f) { return f.name == plain; });
      if (!known) fields.push_back({plain, components_of(array), {}});
    }
  }

  const XmlElement* array_of(const XmlElement* section, const GrowingField& field) const {
    if (section == nullptr) return nullptr;
    for (const std::size_t index : section->children)
      if (document_[index].name == "DataArray" && xml_unescaped(document_[index].attribute("Name")) == field.name)
        return &document_[index];
    return nullptr;
  }

  /// Adds the values of a piece. `place_of(i)` is the number among `values` where tuple i goes, none to leave it out.
  template <class PlaceOf>
  void grow_fields(const XmlElement* section, std::size_t tuples, std::vector<GrowingField>& fields,
                   const PlaceOf& place_of) {
    for (GrowingField& field : fields) {
      const XmlElement* array = array_of(section, field);
      if (array == nullptr || components_of(*array) != field.components)
        file_.fail(ErrorCode::InputUnreadable, "the pieces do not agree on the array '" + field.name + "'");
      const VtuArray numbers = decoder_.decode(*array);
      expect_size(numbers, tuples * field.components, ("the field '" + field.name + "'").c_str());
      for (std::size_t i = 0; i < tuples; ++i) {
        let_go_at(i);
        if (const std::optional<std::size_t> place = place_of(i))
          for (std::size_t c = 0; c < field.components; ++c)
            field.values[*place].push_back(numbers.real(i * field.components + c));
      }
    }
  }

  /// Fields on cells that the file has for edges and surface elements alone are left out.
  void finish_fields() {
    for (GrowingField& field : point_fields_)
      mesh_.point_fields.push_back({field.name, static_cast<int>(field.components), std::move(field.values[0])});
    if (cell_count(mesh_) == 0) return;
    for (GrowingField& field : cell_fields_) {
      std::vector<double>& all = field.values[0];
      for (std::size_t kind = 1; kind < kCellKinds; ++kind)
        all.insert(all.end(), field.values[kind].begin(), field.values[kind].end());
      mesh_.cell_fields.push_back({field.name, static_cast<int>(field.components), std::move(all)});
    }
  }

  std::uint32_t vertex(const Piece& piece, std::size_t at) const {
    const std::int64_t local = piece.connectivity.integer(at);
    if (local < 0 || static_cast<std::uint64_t>(local) >= piece.points)
      file_.fail(ErrorCode::InputUnreadable, "a cell refers to the point " + std::to_string(local) +
                                                 ", but there are " + std::to_string(piece.points));
    return piece.first_point + static_cast<std::uint32_t>(local);
  }

  template <class Element>
  void add(const Piece& piece, std::size_t at, CellType type, std::uint32_t index, std::vector<Element>& elements,
           std::vector<std::uint32_t>& entities) {
    Element element;
    for (std::size_t i = 0; i < element.size(); ++i) element[i] = vertex(piece, at + i);
    if (filter_ != nullptr && !is_first_pass() && !filter_->keeps(element)) return;
    if (type.is_second_order) {
      std::array<std::uint32_t, kMostNodes> mids;
      const std::size_t count = type.nodes() - element.size();
      for (std::size_t i = 0; i < count; ++i) mids[i] = vertex(piece, at + element.size() + i);
      mids_.add(element, edges_of(type.block), std::span(mids).first(count));
    }
    elements.push_back(turned_for_vtk(element));
    entities.push_back(index);
  }

  static std::vector<std::string> strings_of(const VtuArray& bytes) {
    std::vector<std::string> strings(1);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      const char c = static_cast<char>(bytes.integer(i));
      if (c == '\0')
        strings.emplace_back();
      else
        strings.back() += c;
    }
    strings.pop_back();
    return strings;
  }

  void read_attributes(const XmlElement& fields) {
    for (std::size_t dim = 0; dim < 4; ++dim) {
      const std::string kind(kEntityKinds[dim]);
      std::vector<EntityAttributes>& table = mesh_.entities[dim];
      const std::optional<VtuArray> names = find(&fields, kind + "_names");
      if (!names || !names->is_integer()) continue;
      for (std::string& name : strings_of(*names)) table.emplace_back().name = std::move(name);
      const auto read_texts = [&](const char* what, std::string EntityAttributes::*member) {
        const auto bytes = find(&fields, kind + what);
        if (!bytes || !bytes->is_integer()) return;
        std::vector<std::string> texts = strings_of(*bytes);
        for (std::size_t i = 0; i < std::min(texts.size(), table.size()); ++i) table[i].*member = std::move(texts[i]);
      };
      read_texts("_layers", &EntityAttributes::layer);
      read_texts("_groups", &EntityAttributes::group);
      if (const auto colors = find(&fields, kind + "_colors"); colors && colors->size() == 4 * table.size())
        for (std::size_t i = 0; i < table.size(); ++i) table[i].color = color_at(*colors, 4 * i);
      if (const auto tolerances = find(&fields, kind + "_tolerances"); tolerances && tolerances->size() == table.size())
        for (std::size_t i = 0; i < table.size(); ++i) table[i].tolerance = tolerances->real(i);
    }
    const std::optional<VtuArray> sides = find(&fields, "face_sides");
    if (!sides || !sides->is_integer()) return;
    mesh_.face_to_sides.resize(sides->size() / 2);
    for (std::size_t i = 0; i < mesh_.face_to_sides.size(); ++i) {
      mesh_.face_to_sides[i].front.value = index_of_tag(sides->integer(2 * i));
      mesh_.face_to_sides[i].back.value = index_of_tag(sides->integer(2 * i + 1));
    }
  }
  static std::optional<Color> color_at(const VtuArray& numbers, std::size_t i) {
    if (numbers.real(i + 3) == 0) return {};
    return Color{static_cast<float>(numbers.real(i)), static_cast<float>(numbers.real(i + 1)),
                 static_cast<float>(numbers.real(i + 2))};
  }

  const InputFile& file_;
  std::vector<XmlElement> document_;
  VtuDecoder decoder_;
  std::vector<std::uint64_t>* global_ids_;  // null: they are not asked for
  SliceFilter* filter_ = nullptr;           // null: all is read
  std::size_t first_point_ = 0;             // of the next piece
  std::uint64_t first_tet_ = 0;             // of the slice, the next one
  Mesh mesh_;
  std::vector<Corner> corners_;
  MidNodeReader mids_;
  std::vector<GrowingField> point_fields_, cell_fields_;
  bool points_are_classified_ = false, has_cell_fields_ = false;
};

}  // namespace

Mesh read_vtu(const InputFile& file) { return VtuReader(file).read(); }

std::optional<FileSlice> read_vtu_slice(const InputFile& file, SliceFilter& filter) {
  return VtuReader(file).read_slice(filter);
}

MeshPiece read_vtu_piece(const InputFile& file) {
  MeshPiece piece;
  piece.mesh = VtuReader(file, &piece.global_ids).read();
  return piece;
}

}  // namespace tetloom::detail
