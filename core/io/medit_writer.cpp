// MEDIT meshes (Frey, INRIA RT-0253, 2001; binary as in libMeshb): references are tags, model vertices are corners and
// required vertices. Every other point is classified by the elements around it when it is read back. Prisms and the
// other cells have the order of a Mesh. Fields, which MEDIT keeps in files of their own, are left out.
#include <array>
#include <limits>

#include "core/io/formats_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

/// The codes of libMeshb for the keywords that are written.
enum class MeditKeyword : std::int32_t {
  Dimension = 3,
  Vertices = 4,
  Edges = 5,
  Triangles = 6,
  Quadrilaterals = 7,
  Tetrahedra = 8,
  Prisms = 9,
  Hexahedra = 10,
  Corners = 13,
  RequiredVertices = 15,
  Pyramids = 49,
  End = 54
};

struct MeditName {
  const char* text;
  MeditKeyword code;
};
/// By Block.
constexpr std::array<MeditName, kBlocks> kElementKeywords{{{"Edges\n", MeditKeyword::Edges},
                                                           {"Triangles\n", MeditKeyword::Triangles},
                                                           {"Quadrilaterals\n", MeditKeyword::Quadrilaterals},
                                                           {"Tetrahedra\n", MeditKeyword::Tetrahedra},
                                                           {"Pyramids\n", MeditKeyword::Pyramids},
                                                           {"Prisms\n", MeditKeyword::Prisms},
                                                           {"Hexahedra\n", MeditKeyword::Hexahedra}}};

/// Points on model vertices, 0-based.
std::vector<std::uint32_t> find_corners(const Mesh& mesh) {
  std::vector<std::uint32_t> corners;
  for (std::uint32_t i = 0; i < mesh.points.size(); ++i) {
    const ModelEntity entity = entity_of_point(mesh, i);
    if (entity.valid() && entity.dim == 0) corners.push_back(i);
  }
  return corners;
}

std::uint32_t point_tag(const Mesh& mesh, std::size_t i) {
  const ModelEntity entity = entity_of_point(mesh, i);
  return entity.valid() ? entity.tag() : 0;
}

template <class Element>
void print_elements(AtomicFile& file, const char* keyword, const std::vector<Element>& elements,
                    const std::vector<std::uint32_t>& entities) {
  if (elements.empty()) return;
  file.write(keyword);
  file.print(elements.size()), file.print('\n');
  for (std::size_t e = 0; e < elements.size(); ++e) {
    for (const std::uint32_t v : elements[e]) file.print(std::uint64_t{v} + 1), file.print(' ');
    file.print(tag_of_index(entities[e])), file.print('\n');
  }
}

/// Writes the records of a binary file; the widths of its integers depend on the version.
class MeditRecords {
 public:
  MeditRecords(AtomicFile& file, const Mesh& mesh, std::size_t corner_count) : file_(file) {
    std::uint64_t largest = mesh.points.size(), integers = mesh.points.size() + 2 * corner_count;
    for_each_block(mesh, [&](Block, const auto& elements, const auto& entities) {
      largest = std::max<std::uint64_t>(largest, entities.size());
      for (const std::uint32_t index : entities) largest = std::max<std::uint64_t>(largest, tag_of_index(index));
      if (!elements.empty()) integers += (elements[0].size() + 1) * elements.size();
    });
    for (std::size_t i = 0; i < mesh.points.size(); ++i) largest = std::max<std::uint64_t>(largest, point_tag(mesh, i));
    const std::uint64_t bytes = 24 * mesh.points.size() + 4 * integers + 1000;
    constexpr std::uint64_t kLargest32 = std::numeric_limits<std::int32_t>::max();
    version_ = largest > kLargest32 ? 4 : bytes > kLargest32 ? 3 : 2;
  }
  int version() const { return version_; }
  std::uint64_t integer_bytes() const { return version_ == 4 ? 8 : 4; }
  std::uint64_t position_bytes() const { return version_ == 2 ? 4 : 8; }
  void integer(std::uint64_t value) {
    if (version_ == 4)
      file_.put(value);
    else
      file_.put(static_cast<std::uint32_t>(value));
  }
  void position(std::uint64_t value) {
    if (version_ == 2)
      file_.put(static_cast<std::uint32_t>(value));
    else
      file_.put(value);
  }
  /// A keyword, the place of the next one, and how many records of `record_bytes` lie in between.
  void section(MeditKeyword keyword, std::uint64_t count, std::uint64_t record_bytes) {
    const std::uint64_t header = 4 + position_bytes() + integer_bytes();
    const std::uint64_t next = file_.position() + header + count * record_bytes;
    file_.put(keyword);
    position(next);
    integer(count);
  }
  template <class Element>
  void elements(MeditKeyword keyword, const std::vector<Element>& all, const std::vector<std::uint32_t>& entities) {
    if (all.empty()) return;
    section(keyword, all.size(), (all[0].size() + 1) * integer_bytes());
    for (std::size_t e = 0; e < all.size(); ++e) {
      for (const std::uint32_t v : all[e]) integer(std::uint64_t{v} + 1);
      integer(tag_of_index(entities[e]));
    }
  }

 private:
  AtomicFile& file_;
  int version_ = 2;
};

}  // namespace

void write_medit_text(const Mesh& mesh, AtomicFile& file) {
  file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n");
  file.print(mesh.points.size()), file.print('\n');
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) file.print(mesh.points[i][axis]), file.print(' ');
    file.print(point_tag(mesh, i)), file.print('\n');
  }
  const std::vector<std::uint32_t> corners = find_corners(mesh);
  for (const char* keyword : {"Corners\n", "RequiredVertices\n"}) {
    if (corners.empty()) break;
    file.write(keyword);
    file.print(corners.size()), file.print('\n');
    for (const std::uint32_t corner : corners) file.print(std::uint64_t{corner} + 1), file.print('\n');
  }
  for_each_block(mesh, [&](Block block, const auto& elements, const auto& entities) {
    print_elements(file, kElementKeywords[static_cast<std::size_t>(block)].text, elements, entities);
  });
  file.write("End\n");
}

void write_medit_binary(const Mesh& mesh, AtomicFile& file) {
  const std::vector<std::uint32_t> corners = find_corners(mesh);
  MeditRecords records(file, mesh, corners.size());
  file.put(std::int32_t{1});
  file.put(std::int32_t{records.version()});
  file.put(MeditKeyword::Dimension);
  records.position(file.position() + records.position_bytes() + 4);
  file.put(std::int32_t{3});
  records.section(MeditKeyword::Vertices, mesh.points.size(), 24 + records.integer_bytes());
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    file.put(mesh.points[i]);
    records.integer(point_tag(mesh, i));
  }
  for (const MeditKeyword keyword : {MeditKeyword::Corners, MeditKeyword::RequiredVertices}) {
    if (corners.empty()) break;
    records.section(keyword, corners.size(), records.integer_bytes());
    for (const std::uint32_t corner : corners) records.integer(std::uint64_t{corner} + 1);
  }
  for_each_block(mesh, [&](Block block, const auto& elements, const auto& entities) {
    records.elements(kElementKeywords[static_cast<std::size_t>(block)].code, elements, entities);
  });
  file.put(MeditKeyword::End);
  records.position(0);
}

}  // namespace tetloom::detail
