// Bulk data of Nastran in fields of fixed width: GRID with 16 characters a field, elements with a property for every
// region and every face of the model, whose names stand in comments. Shells point out of the one region at their face.
#include <cstdio>
#include <string_view>

#include "core/io/element_nodes_detail.hpp"
#include "core/io/formats_detail.hpp"
#include "core/io/solver/groups.hpp"
#include "tetloom/error.hpp"

namespace tetloom::detail {
namespace {

constexpr std::array<const char*, kBlocks> kCards{"CROD", "CTRIA3", "CQUAD4", "CTETRA", "CPYRAM", "CPENTA", "CHEXA"};
constexpr std::array<const char*, kBlocks> kCards2{"", "CTRIA6", "CQUAD8", "CTETRA", "CPYRAM", "CPENTA", "CHEXA"};

constexpr std::size_t kField = 8, kFieldsPerLine = 8;
constexpr std::uint64_t kMostId = 99'999'999;  // what a field holds

char* put_field(char* out, std::uint64_t number) {
  char* const end = out + kField;
  char* at = end;
  do {
    *--at = static_cast<char>('0' + number % 10);
    number /= 10;
  } while (number > 0);
  std::fill(out, at, ' ');
  return end;
}

char* put_word(char* out, std::string_view word) {
  std::fill(out, out + kField, ' ');
  std::copy(word.begin(), word.end(), out);
  return out + kField;
}

char* put_card(char* out, const char* card, std::uint64_t id, std::uint64_t property, const NodeList& nodes) {
  out = put_word(out, card);
  out = put_field(out, id);
  out = put_field(out, property);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    if ((i + 2) % kFieldsPerLine == 0) {
      *out++ = '\n';
      out = put_word(out, "+");
    }
    out = put_field(out, std::uint64_t{nodes[i]} + 1);
  }
  *out++ = '\n';
  return out;
}

class BdfWriter {
 public:
  BdfWriter(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop)
      : mesh_(mesh), file_(file), loop_(loop), nodes_(mesh), groups_(make_groups(mesh)) {}

  void write() {
    if (std::max<std::size_t>(mesh_.points.size(), cell_count(mesh_) + surface_count(mesh_)) > kMostId)
      throw Error(ErrorCode::InvalidArgument,
                  "the mesh has more points or elements than the fields of .bdf can number");
    file_.write("$ tetloom\nBEGIN BULK\n");
    number_properties();
    write_points();
    write_elements(3);
    write_elements(2);
    file_.write("ENDDATA\n");
  }

 private:
  // Regions first, then faces, so that a property is one or the other.
  void number_properties() {
    file_.write("MAT1           1     1.0             0.3\n");
    for (const std::size_t dim : {std::size_t{3}, std::size_t{2}}) {
      std::size_t largest = 0;
      for (const Group& group : groups_[dim]) largest = std::max<std::size_t>(largest, group.tags.back());
      properties_[dim].assign(largest + 1, 0);
      for (const Group& group : groups_[dim]) {
        const std::uint64_t property = ++property_count_;
        for (const std::uint32_t tag : group.tags) properties_[dim][tag] = property;
        std::array<char, 80> line;
        char* end = put_field(put_word(line.data(), dim == 3 ? "PSOLID" : "PSHELL"), property);
        end = put_field(end, 1);
        if (dim == 2) end = put_word(end, "1.0");
        *end++ = '\n';
        file_.write((dim == 3 ? "$ region " : "$ face ") + group.name + "\n");
        file_.write(line.data(), static_cast<std::size_t>(end - line.data()));
      }
    }
  }

  void write_points() {
    constexpr std::size_t kBytes = 128;
    const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
      for (std::size_t v = begin; v < end; ++v) {
        const Vec3& x = mesh_.points[v];
        out += std::snprintf(out, kBytes, "GRID*   %16zu%16s%16.9E%16.9E\n*       %16.9E\n", v + 1, "", x.x, x.y, x.z);
      }
      return out;
    };
    file_.write_lines(mesh_.points.size(), kBytes, print_block, loop_);
  }

  void write_elements(int dim) {
    const std::vector<std::uint64_t>& properties = properties_[static_cast<std::size_t>(dim)];
    for_each_block(mesh_, [&](Block block, const auto& elements, const auto& entities) {
      if (dimension_of(block) != dim || elements.empty()) return;
      const std::uint64_t first = element_count_ + 1;
      const char* card = (nodes_.are_second_order() ? kCards2 : kCards)[static_cast<std::size_t>(block)];
      const auto print_block = [&](std::size_t begin, std::size_t end, char* out) {
        for (std::size_t e = begin; e < end; ++e)
          out = put_card(out, card, first + e, properties[tag_of_index(entities[e])],
                         nodes_.of(turned_outwards(mesh_, dim, elements[e], entities[e]), edges_up_first(block)));
        return out;
      };
      file_.write_lines(elements.size(), (nodes_.count(block) / kFieldsPerLine + 2) * (kFieldsPerLine + 2) * kField,
                        print_block, loop_);
      element_count_ += elements.size();
    });
  }

  const Mesh& mesh_;
  AtomicFile& file_;
  const BlockLoop& loop_;
  ElementNodes nodes_;
  Groups groups_;
  std::array<std::vector<std::uint64_t>, 4> properties_;  // by dimension and tag
  std::uint64_t property_count_ = 0, element_count_ = 0;
};

}  // namespace

void write_bdf(const Mesh& mesh, AtomicFile& file, const BlockLoop& loop) { BdfWriter(mesh, file, loop).write(); }

}  // namespace tetloom::detail
