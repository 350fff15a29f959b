// Parts in MSH files (Gmsh reference manual, "MSH file format").
#include <algorithm>

#include "core/base/filing.hpp"
#include "core/base/grain.hpp"
#include "core/io/msh_detail.hpp"
#include "core/mesh/mesh_access.hpp"

namespace tetloom::detail {
namespace {

using Key = std::array<std::uint32_t, 4>;

template <class Verts>
Key key_of(const Verts& verts) {
  Key key{kNone, kNone, kNone, kNone};
  std::copy(verts.begin(), verts.end(), key.begin());
  std::sort(key.begin(), key.end());
  return key;
}

/// An edge or a surface element.
struct BoundaryElement {
  Key key;
  Block block;
  std::uint32_t index;
};

/// Finds boundary elements by their vertices.
class BoundaryElements {
 public:
  explicit BoundaryElements(const Mesh& mesh) : is_used_(mesh.points.size(), false) {
    for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
      if (dimension_of(block) == 3) return;
      for (std::uint32_t i = 0; i < elements.size(); ++i) {
        found_.push_back({key_of(elements[i]), block, i});
        for (const std::uint32_t v : elements[i]) is_used_[v] = true;
      }
    });
    std::sort(found_.begin(), found_.end(),
              [](const BoundaryElement& a, const BoundaryElement& b) { return a.key < b.key; });
  }
  /// Calls visit(element) for those with these vertices.
  template <class Visit>
  void find(std::span<const std::uint32_t> verts, const Visit& visit) const {
    for (const std::uint32_t v : verts)
      if (!is_used_[v]) return;
    const Key key = key_of(verts);
    auto place = std::lower_bound(found_.begin(), found_.end(), key,
                                  [](const BoundaryElement& a, const Key& wanted) { return a.key < wanted; });
    for (; place != found_.end() && place->key == key; ++place) visit(*place);
  }
  /// Calls visit(element) for those on a cell.
  template <class Visit>
  void find_on_cell(const CellShape& shape, std::span<const std::uint32_t> cell, const Visit& visit) const {
    for (const auto& edge : shape.edges()) find(std::array{cell[edge[0]], cell[edge[1]]}, visit);
    for (const LocalFace& face : shape.faces()) {
      std::array<std::uint32_t, 4> of_face{};
      for (std::size_t k = 0; k < face.count; ++k) of_face[k] = cell[face.vert[k]];
      find(std::span(of_face).first(face.count), visit);
    }
  }

 private:
  std::vector<bool> is_used_;  // by point
  std::vector<BoundaryElement> found_;
};

/// Boundary elements go to the lowest part of the cells that they lie on.
void own_boundary(const Mesh& mesh, const MeshParts& parts, const BlockLoop& loop, MshOwners& owners) {
  struct Claim {
    Block block;
    std::uint32_t index, part;
  };
  const BoundaryElements boundary(mesh);
  std::size_t first = 0;
  for_each_cell_kind(mesh, [&](CellKind kind, const auto& cells, const auto&) {
    const auto find_claims = [&](std::size_t begin, std::size_t end, std::vector<Claim>& claims) {
      for (std::size_t c = begin; c < end; ++c)
        boundary.find_on_cell(shape_of(kind), cells[c], [&](const BoundaryElement& element) {
          claims.push_back({element.block, element.index, parts.cell_to_part[first + c]});
        });
    };
    for (const auto& claims : map_blocks(loop, cells.size(), kCopyGrain, std::vector<Claim>(), find_claims))
      for (const Claim& claim : claims) {
        std::uint32_t& owner = owners.of_elements[static_cast<std::size_t>(claim.block)][claim.index];
        owner = std::min(owner, claim.part);
      }
    first += cells.size();
  });
}

/// Points go to the lowest part of the cells around them.
void own_points(const Mesh& mesh, const MeshParts& parts, const BlockLoop& loop, MshOwners& owners) {
  const KeyRanges ranges(mesh.points.size());
  std::size_t first = 0;
  for_each_cell_kind(mesh, [&](CellKind, const auto& cells, const auto&) {
    const auto emit = [&](std::size_t begin, std::size_t end, const auto& file) {
      for (std::size_t c = begin; c < end; ++c)
        for (std::size_t i = 0; i < cells[c].size(); ++i) {
          const std::size_t range = ranges.of(cells[c][i]);
          const auto is_same = [&](std::uint32_t v) { return ranges.of(v) == range; };
          if (std::none_of(cells[c].begin(), cells[c].begin() + i, is_same)) file(range, c);
        }
    };
    const auto visit = [&](std::size_t range, std::span<const std::uint64_t> filed) {
      for (const std::uint64_t c : filed)
        for (const std::uint32_t v : cells[c])
          if (ranges.of(v) == range) owners.of_points[v] = std::min(owners.of_points[v], parts.cell_to_part[first + c]);
    };
    for_each_filed_range<std::uint64_t>(cells.size(), ranges, loop, emit, visit);
    first += cells.size();
  });
}

}  // namespace

MshOwners find_owners(const Mesh& mesh, const MeshParts& parts, const BlockLoop& loop) {
  MshOwners owners;
  owners.of_points.assign(mesh.points.size(), kNone);
  std::size_t first = 0;
  for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
    auto& of_block = owners.of_elements[static_cast<std::size_t>(block)];
    if (dimension_of(block) < 3) return of_block.assign(elements.size(), kNone);
    const auto begin = parts.cell_to_part.begin() + static_cast<std::ptrdiff_t>(first);
    of_block.assign(begin, begin + static_cast<std::ptrdiff_t>(elements.size()));
    first += elements.size();
  });
  own_boundary(mesh, parts, loop, owners);
  own_points(mesh, parts, loop, owners);
  const auto settle = [](std::vector<std::uint32_t>& of) { std::replace(of.begin(), of.end(), kNone, 0u); };
  settle(owners.of_points);
  for (auto& of : owners.of_elements) settle(of);
  return owners;
}

void MshPartitions::read_section(const InputFile& file, MshNumbers& numbers) {
  const std::uint64_t parts = numbers.size();
  // A part takes more than a byte of the file, so this is no number that is worth an allocation.
  if (parts == 0 || parts > file.bytes().size())
    file.fail("an impossible number of partitions, " + std::to_string(parts), numbers.at());
  count_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(parts, 0xfffffffeu));
  const std::uint64_t ghosts = numbers.count(2, 0);
  for (std::uint64_t i = 0; i < 2 * ghosts; ++i) numbers.integer();
  std::array<std::uint64_t, 4> counts;
  for (std::uint64_t& count : counts) count = numbers.size();
  for (int dim = 0; dim < 4; ++dim) {
    numbers.expect(counts[static_cast<std::size_t>(dim)], 3, 2);
    for (std::uint64_t i = 0; i < counts[static_cast<std::size_t>(dim)]; ++i) {
      const std::int32_t tag = numbers.integer();
      Entity entity{numbers.integer(), numbers.integer(), kNone};
      const std::uint64_t of_entity = numbers.count(1, 0);
      for (std::uint64_t p = 0; p < of_entity; ++p) {
        const std::int32_t part = numbers.integer();
        if (part < 1 || static_cast<std::uint64_t>(part) > parts)
          file.fail("a partition that is not among the " + std::to_string(parts), numbers.at());
        entity.part = std::min(entity.part, static_cast<std::uint32_t>(part) - 1);
      }
      for (int point = 0; point < (dim == 0 ? 1 : 2); ++point) numbers.point();
      const std::uint64_t groups = numbers.count(1, 0);
      for (std::uint64_t g = 0; g < groups; ++g) numbers.integer();
      const std::uint64_t bounds = dim == 0 ? 0 : numbers.count(1, 0);
      for (std::uint64_t b = 0; b < bounds; ++b) numbers.integer();
      if (entity.part == kNone) entity.part = 0;
      entities_[static_cast<std::size_t>(dim)][tag] = entity;
    }
  }
}

const MshPartitions::Entity* MshPartitions::find(std::int32_t dim, std::int32_t tag) const {
  if (dim < 0 || dim > 3) return nullptr;
  const auto& table = entities_[static_cast<std::size_t>(dim)];
  const auto found = table.find(tag);
  return found == table.end() ? nullptr : &found->second;
}

}  // namespace tetloom::detail
