// Lists of pieces ("VTK XML Formats", docs.vtk.org: PUnstructuredGrid). What VTK has no place for, the totals of the
// whole mesh and the counts of each piece, stands in an element and in attributes that VTK passes over.
#include <charconv>
#include <new>

#include "core/io/formats_detail.hpp"
#include "core/io/mesh_piece.hpp"
#include "core/io/vtu_detail.hpp"

namespace tetloom {
namespace {

using detail::InputFile;
using detail::XmlElement;

constexpr std::string_view kTotals = "TetloomTotals";

std::string array_line(std::string_view type, std::string_view name, int components) {
  return "      <PDataArray type=\"" + std::string(type) + "\" Name=\"" + detail::xml_escaped(name) +
         "\" NumberOfComponents=\"" + std::to_string(components) + "\"/>\n";
}

std::string field_lines(const std::vector<PieceList::Field>& fields) {
  std::string text;
  for (const PieceList::Field& field : fields) text += array_line("Float64", field.name, field.components);
  return text;
}

class ListReader {
 public:
  explicit ListReader(const InputFile& file) : file_(file), document_(detail::parse_xml(file)) {}

  PieceList read() {
    const XmlElement& root = document_.front();
    if (root.name != "VTKFile" || root.attribute("type") != "PUnstructuredGrid")
      file_.fail(ErrorCode::InputUnreadable, "no list of pieces: its root is no VTKFile of type PUnstructuredGrid");
    const XmlElement* grid = child(root, "PUnstructuredGrid");
    if (grid == nullptr) file_.fail(ErrorCode::InputUnreadable, "no element PUnstructuredGrid");
    refuse_others(*grid);
    PieceList list;
    list.point_fields = fields_of(child(*grid, "PPointData"), true);
    list.cell_fields = fields_of(child(*grid, "PCellData"), false);
    for (const std::size_t index : grid->children)
      if (document_[index].name == "Piece") list.pieces.push_back(piece_of(document_[index]));
    if (list.pieces.empty()) file_.fail(ErrorCode::InputUnreadable, "the list names no pieces");
    const XmlElement* totals = child(*grid, kTotals);
    if (totals == nullptr) file_.fail(ErrorCode::InputUnreadable, "the totals of the mesh are missing");
    list.totals = {number(*totals, "Points"), number(*totals, "CutFaces")};
    return list;
  }

 private:
  const XmlElement* child(const XmlElement& parent, std::string_view name) const {
    for (const std::size_t index : parent.children)
      if (document_[index].name == name) return &document_[index];
    return nullptr;
  }

  void refuse_others(const XmlElement& grid) const {
    const XmlElement* data = child(grid, "PPointData");
    bool found = false;
    if (data != nullptr)
      for (const std::size_t index : data->children)
        found = found || detail::is_global_id(document_[index].attribute("Name"), document_[index].attribute("type"));
    if (!found)
      file_.fail(ErrorCode::InputUnsuitable,
                 "the pieces have no array 'global_id' of the type UInt64 on points, so nothing says which of their "
                 "points are the same; only partitioned files that tetloom wrote can be read");
  }

  std::uint64_t number(const XmlElement& element, std::string_view key) const {
    const std::string_view digits = element.attribute(key);
    std::uint64_t value = 0;
    const auto result = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    if (digits.empty() || result.ec != std::errc() || result.ptr != digits.data() + digits.size())
      file_.fail_at_line("a number is expected as " + std::string(key), element.name.data());
    return value;
  }

  std::vector<PieceList::Field> fields_of(const XmlElement* section, bool of_points) const {
    std::vector<PieceList::Field> fields;
    if (section == nullptr) return fields;
    for (const std::size_t index : section->children) {
      const XmlElement& array = document_[index];
      const std::string_view name = array.attribute("Name");
      if (array.name != "PDataArray" || detail::is_classification(name, of_points) ||
          (of_points && detail::is_global_id(name, array.attribute("type"))))
        continue;
      const std::uint64_t components = number(array, "NumberOfComponents");
      if (components < 1 || components > detail::kMostVtuComponents)
        file_.fail_at_line("a field with an impossible number of components", array.name.data());
      fields.push_back({detail::xml_unescaped(name), static_cast<int>(components)});
    }
    return fields;
  }

  PieceList::Piece piece_of(const XmlElement& element) const {
    PieceList::Piece piece{detail::xml_unescaped(element.attribute("Source")), number(element, "NumberOfPoints"),
                           number(element, "NumberOfCells")};
    if (piece.source.empty()) file_.fail_at_line("a piece without a file", element.name.data());
    return piece;
  }

  const InputFile& file_;
  std::vector<XmlElement> document_;
};

}  // namespace

void write_piece_list(const PieceList& list, AtomicFile& file) {
  file.write(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n"
      "  <PUnstructuredGrid GhostLevel=\"0\">\n");
  file.write("    <PPointData>\n" + array_line("Int8", detail::kEntityDim, 1) +
             array_line("UInt32", detail::kEntityTag, 1) + array_line("UInt64", detail::kGlobalId, 1) +
             field_lines(list.point_fields) + "    </PPointData>\n");
  file.write("    <PCellData>\n" + array_line("Int8", detail::kEntityDim, 1) +
             array_line("UInt32", detail::kEntityTag, 1) + array_line("UInt32", detail::kRegion, 1) +
             field_lines(list.cell_fields) + "    </PCellData>\n");
  file.write("    <PPoints>\n" + array_line("Float64", "Points", 3) + "    </PPoints>\n");
  file.write("    <" + std::string(kTotals) + " Points=\"" + std::to_string(list.totals.points) + "\" CutFaces=\"" +
             std::to_string(list.totals.cut_faces) + "\"/>\n");
  for (const PieceList::Piece& piece : list.pieces)
    file.write("    <Piece Source=\"" + detail::xml_escaped(piece.source) + "\" NumberOfPoints=\"" +
               std::to_string(piece.points) + "\" NumberOfCells=\"" + std::to_string(piece.cells) + "\"/>\n");
  file.write("  </PUnstructuredGrid>\n</VTKFile>\n");
}

PieceList read_piece_list(const std::filesystem::path& path, const CancelToken* cancel) {
  const InputFile file(path, cancel);
  return ListReader(file).read();
}

}  // namespace tetloom
