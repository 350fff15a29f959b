// Input files of Abaqus and CalculiX, without a step: nodes, elements with an ELSET per region, and for every face of
// the model an NSET of its nodes and a SURFACE of the element faces on it; NSETs for edges and vertices. Meshes without
// cells are written as shells, with an ELSET per face.
#include <algorithm>
#include <array>

#include "core/io/element_nodes_detail.hpp"
#include "core/io/formats_detail.hpp"
#include "core/io/solver/cell_faces.hpp"
#include "core/io/solver/groups.hpp"
#include "core/io/solver/inp_detail.hpp"
#include "core/io/solver/number_text.hpp"

namespace tetloom::detail {
namespace {

constexpr std::array<const char*, kBlocks> kInpTypes{"T3D2", "S3", "S4", "C3D4", "C3D5", "C3D6", "C3D8"};
constexpr std::array<const char*, kBlocks> kInpTypes2{"T3D3", "S6", "S8", "C3D10", nullptr, "C3D15", "C3D20"};
constexpr std::size_t kPerLine = 8;        // numbers in a line of a set; readers take at most 16
constexpr std::size_t kNodesPerLine = 15;  // behind the number of the element

constexpr std::size_t kMostCharacters = 20;  // of a number, for CalculiX, which reads no further

// The shortest form that reads back as the same number where that is short enough, else the nearest that is.
char* print_short(char* out, double number, char behind) {
  char* end = std::to_chars(out, out + kRealBytes, number).ptr;
  for (int digits = 14; end > out + kMostCharacters; --digits)
    end = std::to_chars(out, out + kRealBytes, number, std::chars_format::scientific, digits).ptr;
  *end = behind;
  return end + 1;
}

class InpWriter {
 public:
  InpWriter(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop)
      : mesh_(mesh), file_(file), loop_(loop), nodes_(mesh), groups_(make_groups(mesh)) {}

  void write() {
    if (nodes_.are_second_order() && !mesh_.pyramid_to_vert.empty())
      throw Error(ErrorCode::InvalidArgument, "Abaqus has no pyramids of second order, but the mesh has");
    file_.write("*HEADING\ntetloom\n");
    write_nodes();
    const int dim = cell_count(mesh_) > 0 ? 3 : 2;
    write_elements(dim);
    for (const int below : {0, 1, 2})
      for (const Group& group : groups_[static_cast<std::size_t>(below)])
        if (below < dim) write_set("*NSET, NSET=", group.name, points_of(mesh_, nodes_, below, group));
    if (dim == 3) write_surfaces();
  }

 private:
  void write_nodes() {
    file_.write("*NODE, NSET=all_nodes\n");
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t v = begin; v < end; ++v) {
        out = print(out, v + 1, ',');
        for (int axis = 0; axis < 3; ++axis) out = print_short(out, mesh_.points[v][axis], axis < 2 ? ',' : '\n');
      }
      return out;
    };
    file_.write_lines(mesh_.points.size(), kIntegerBytes + 3 * kRealBytes, print_block, loop_);
  }

  // A block of elements for each kind and entity, so that every one says its set; the numbers run on.
  void write_elements(int dim) {
    std::size_t first = 0;
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto&) {
      if (dimension_of(block) != dim) return;
      for (const Group& group : groups_[static_cast<std::size_t>(dim)]) {
        const auto begin = std::ranges::lower_bound(group.elements, first);
        const auto end = std::ranges::lower_bound(group.elements, first + elements.size());
        if (begin == end) continue;
        const auto& types = nodes_.are_second_order() ? kInpTypes2 : kInpTypes;
        file_.write(std::string("*ELEMENT, TYPE=") + types[static_cast<std::size_t>(block)] + ", ELSET=" + group.name +
                    "\n");
        const auto print_block = [&](std::size_t from, std::size_t to, char* out) {
          for (std::size_t i = from; i < to; ++i) {
            const std::size_t element = begin[static_cast<std::ptrdiff_t>(i)];
            out = print(out, element + 1, ',');
            out = print_nodes(out, nodes_.of(elements[element - first], block));
          }
          return out;
        };
        file_.write_lines(static_cast<std::size_t>(end - begin), (nodes_.count(block) + 2) * kIntegerBytes, print_block,
                          loop_);
      }
      first += elements.size();
    });
  }

  static char* print_nodes(char* out, const NodeList& nodes) {
    for (std::size_t k = 0; k < nodes.size(); ++k) {
      const bool is_last = k + 1 == nodes.size();
      out = print(out, std::uint64_t{nodes[k]} + 1, is_last ? '\n' : ',');
      if (!is_last && k + 1 == kNodesPerLine) *out++ = '\n';
    }
    return out;
  }

  void write_set(const char* keyword, const std::string& name, const std::vector<std::uint32_t>& items) {
    if (items.empty()) return;
    file_.write(keyword + name + "\n");
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t i = begin; i < end; ++i) {
        const bool is_last = i + 1 == items.size() || (i + 1) % kPerLine == 0;
        out = print(out, std::uint64_t{items[i]} + 1, is_last ? '\n' : ',');
      }
      return out;
    };
    file_.write_lines(items.size(), kIntegerBytes, print_block, loop_);
  }

  // Of a face between two regions, the sides of the region with the lower tag.
  void write_surfaces() {
    const CellFaces faces(mesh_, loop_, FacesOf::Surface);
    for (const Group& group : groups_[2]) {
      std::string lines;
      for (const std::uint32_t element : group.elements) {
        const std::uint32_t face = faces.find_side(element);
        if (face == kNone) continue;
        const std::uint32_t cell = faces.cell(face);
        const int number = kInpFaceNumbers[static_cast<std::size_t>(faces.kind_of_cell(cell))][faces.local(face)];
        lines += std::to_string(cell + 1) + ",S" + std::to_string(number) + "\n";
      }
      if (lines.empty()) continue;
      file_.write("*SURFACE, NAME=" + group.name + ", TYPE=ELEMENT\n");
      file_.write(lines);
    }
  }

  const Mesh& mesh_;
  AtomicFile& file_;
  const BlockLoop& loop_;
  ElementNodes nodes_;
  Groups groups_;
};

}  // namespace

void write_inp(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) { InpWriter(mesh, file, loop).write(); }

}  // namespace tetloom::detail
