// MEDIT meshes (Frey, INRIA RT-0253, 2001; binary as in libMeshb): references are tags, model vertices are corners and
// required vertices. Every other point is classified by the elements around it when it is read back. Prisms and the
// other cells have the order of a Mesh. Fields, which MEDIT keeps in files of their own, are left out.
#include <algorithm>
#include <array>
#include <tuple>

#include "core/base/grain.hpp"
#include "core/base/lists.hpp"
#include "core/io/formats_detail.hpp"
#include "core/io/medit_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "core/io/solver/number_text.hpp"
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
std::vector<std::uint32_t> find_corners(const Mesh& mesh, const BlockLoop& loop) {
  using Corners = std::vector<std::uint32_t>;
  const auto of_blocks = map_blocks(loop, mesh.points.size(), kCopyGrain, Corners(),
                                    [&](std::size_t begin, std::size_t end, Corners& corners) {
                                      for (std::size_t i = begin; i < end; ++i) {
                                        const ModelEntity entity = entity_of_point(mesh, i);
                                        if (entity.valid() && entity.dim == 0)
                                          corners.push_back(static_cast<std::uint32_t>(i));
                                      }
                                    });
  return joined(of_blocks);
}

void print_points(AtomicFile& file, const Mesh& mesh, const BlockLoop& loop) {
  const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t i = begin; i < end; ++i) {
      for (int axis = 0; axis < 3; ++axis) out = print(out, mesh.points[i][axis], ' ');
      out = print(out, point_tag(mesh, i), '\n');
    }
    return out;
  };
  file.write_lines(mesh.points.size(), 3 * kRealBytes + kIntegerBytes, print_block, loop);
}

template <class Element>
void print_elements(AtomicFile& file, const Mesh& mesh, Block block, const std::vector<Element>& elements,
                    const std::vector<std::uint32_t>& entities, const BlockLoop& loop) {
  if (elements.empty()) return;
  const char* keyword = kElementKeywords[static_cast<std::size_t>(block)].text;
  file.write(keyword);
  file.print(elements.size()), file.print('\n');
  const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
    for (std::size_t e = begin; e < end; ++e) {
      for (const std::uint32_t v : turned_outwards(mesh, dimension_of(block), elements[e], entities[e]))
        out = print(out, std::uint64_t{v} + 1, ' ');
      out = print(out, tag_of_index(entities[e]), '\n');
    }
    return out;
  };
  file.write_lines(elements.size(), (elements[0].size() + 1) * kIntegerBytes, print_block, loop);
}

/// The version of a binary file, on which the widths of its integers depend.
int binary_version(const Mesh& mesh, std::size_t corner_count, const BlockLoop& loop) {
  std::uint64_t largest = std::max<std::uint64_t>(mesh.points.size(), largest_tag(mesh, loop));
  std::uint64_t integers = mesh.points.size() + 2 * corner_count;
  for_each_block(mesh, [&](Block, const auto& elements, const auto&) {
    largest = std::max<std::uint64_t>(largest, elements.size());
    if (!elements.empty()) integers += (elements[0].size() + 1) * elements.size();
  });
  const std::uint64_t bytes = 24 * mesh.points.size() + 4 * integers + 1000;
  return medit_version(bytes, largest);
}

/// Writes the records of a binary file. `Integer` is as wide as those of its version.
template <class Integer>
class MeditRecords {
 public:
  MeditRecords(AtomicFile& file, int version, const BlockLoop& loop) : file_(file), version_(version), loop_(loop) {}

  std::uint64_t position_bytes() const { return version_ == 2 ? 4 : 8; }
  void position(std::uint64_t value) {
    if (version_ == 2)
      file_.put(static_cast<std::uint32_t>(value));
    else
      file_.put(value);
  }
  void points(const Mesh& mesh) {
    using Record = std::array<char, sizeof(Vec3) + sizeof(Integer)>;
    section(MeditKeyword::Vertices, mesh.points.size(), sizeof(Record));
    const auto record_of = [&](std::size_t i) {
      Record record;
      const Integer tag = point_tag(mesh, i);
      std::memcpy(record.data(), &mesh.points[i], sizeof(Vec3));
      std::memcpy(record.data() + sizeof(Vec3), &tag, sizeof(Integer));
      return record;
    };
    file_.put_each(mesh.points.size(), record_of, loop_);
  }
  void corners(MeditKeyword keyword, const std::vector<std::uint32_t>& all) {
    if (all.empty()) return;
    section(keyword, all.size(), sizeof(Integer));
    file_.put_each(
        all.size(), [&](std::size_t i) { return static_cast<Integer>(std::uint64_t{all[i]} + 1); }, loop_);
  }
  template <class Element>
  void elements(const Mesh& mesh, Block block, const std::vector<Element>& all,
                const std::vector<std::uint32_t>& entities) {
    if (all.empty()) return;
    using Record = std::array<Integer, std::tuple_size_v<Element> + 1>;
    section(kElementKeywords[static_cast<std::size_t>(block)].code, all.size(), sizeof(Record));
    const auto record_of = [&](std::size_t e) {
      Record record;
      const Element verts = turned_outwards(mesh, dimension_of(block), all[e], entities[e]);
      std::transform(verts.begin(), verts.end(), record.begin(),
                     [](std::uint32_t v) { return static_cast<Integer>(std::uint64_t{v} + 1); });
      record.back() = tag_of_index(entities[e]);
      return record;
    };
    file_.put_each(all.size(), record_of, loop_);
  }

 private:
  /// A keyword, the place of the next one, and how many records of `record_bytes` lie in between.
  void section(MeditKeyword keyword, std::uint64_t count, std::uint64_t record_bytes) {
    const std::uint64_t header = 4 + position_bytes() + sizeof(Integer);
    const std::uint64_t next = file_.position() + header + count * record_bytes;
    file_.put(keyword);
    position(next);
    file_.put(static_cast<Integer>(count));
  }

  AtomicFile& file_;
  int version_;
  const BlockLoop& loop_;
};

template <class Integer>
void write_binary(const Mesh& mesh, const std::vector<std::uint32_t>& corners, AtomicFile& file,
                  MeditRecords<Integer> records) {
  file.put(MeditKeyword::Dimension);
  records.position(file.position() + records.position_bytes() + 4);
  file.put(std::int32_t{3});
  records.points(mesh);
  records.corners(MeditKeyword::Corners, corners);
  records.corners(MeditKeyword::RequiredVertices, corners);
  for_each_block(mesh, [&](Block block, const auto& elements, const auto& entities) {
    records.elements(mesh, block, elements, entities);
  });
  file.put(MeditKeyword::End);
  records.position(0);
}

}  // namespace

void write_medit_text(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  file.write("MeshVersionFormatted 2\nDimension 3\nVertices\n");
  file.print(mesh.points.size()), file.print('\n');
  print_points(file, mesh, loop);
  const std::vector<std::uint32_t> corners = find_corners(mesh, loop);
  for (const char* keyword : {"Corners\n", "RequiredVertices\n"}) {
    if (corners.empty()) break;
    file.write(keyword);
    file.print(corners.size()), file.print('\n');
    for (const std::uint32_t corner : corners) file.print(std::uint64_t{corner} + 1), file.print('\n');
  }
  for_each_block(mesh, [&](Block block, const auto& elements, const auto& entities) {
    print_elements(file, mesh, block, elements, entities, loop);
  });
  file.write("End\n");
}

void write_medit_binary(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) {
  const std::vector<std::uint32_t> corners = find_corners(mesh, loop);
  const int version = binary_version(mesh, corners.size(), loop);
  file.put(std::int32_t{1});
  file.put(std::int32_t{version});
  if (version == 4)
    write_binary(mesh, corners, file, MeditRecords<std::uint64_t>(file, version, loop));
  else
    write_binary(mesh, corners, file, MeditRecords<std::uint32_t>(file, version, loop));
}

}  // namespace tetloom::detail
