// Parts in MSH files (Gmsh reference manual, "MSH file format").
#include <algorithm>

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

/// Finds boundary elements by their vertices, and gives them the lowest part that asks for them.
class BoundaryOwners {
 public:
  BoundaryOwners(const Mesh& mesh, MshOwners& owners) : owners_(owners) {
    for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
      if (dimension_of(block) == 3) return;
      for (std::uint32_t i = 0; i < elements.size(); ++i) found_.push_back({key_of(elements[i]), block, i});
    });
    std::sort(found_.begin(), found_.end(), [](const Place& a, const Place& b) { return a.key < b.key; });
  }
  template <class Verts>
  void claim(const Verts& verts, std::uint32_t part) {
    const Key key = key_of(verts);
    auto place = std::lower_bound(found_.begin(), found_.end(), key,
                                  [](const Place& a, const Key& wanted) { return a.key < wanted; });
    for (; place != found_.end() && place->key == key; ++place) {
      std::uint32_t& owner = owners_.of_elements[static_cast<std::size_t>(place->block)][place->index];
      owner = std::min(owner, part);
    }
  }

 private:
  struct Place {
    Key key;
    Block block;
    std::uint32_t index;
  };
  MshOwners& owners_;
  std::vector<Place> found_;
};

void claim_boundary(const CellShape& shape, std::span<const std::uint32_t> verts, std::uint32_t part,
                    BoundaryOwners& boundary) {
  for (const auto& edge : shape.edges()) boundary.claim(std::array{verts[edge[0]], verts[edge[1]]}, part);
  for (const LocalFace& face : shape.faces()) {
    std::array<std::uint32_t, 4> of_face{};
    for (std::size_t k = 0; k < face.count; ++k) of_face[k] = verts[face.vert[k]];
    boundary.claim(std::span(of_face).first(face.count), part);
  }
}

}  // namespace

MshOwners find_owners(const Mesh& mesh, const MeshParts& parts) {
  MshOwners owners;
  owners.of_points.assign(mesh.points.size(), kNone);
  for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
    owners.of_elements[static_cast<std::size_t>(block)].assign(elements.size(), kNone);
  });
  BoundaryOwners boundary(mesh, owners);
  std::size_t cell = 0;
  for_each_block(mesh, [&](Block block, const auto& elements, const auto&) {
    if (dimension_of(block) < 3) return;
    const CellShape& shape = shape_of(static_cast<CellKind>(cell_kind_of(block)));
    for (std::size_t i = 0; i < elements.size(); ++i) {
      const std::uint32_t part = parts.cell_to_part[cell++];
      owners.of_elements[static_cast<std::size_t>(block)][i] = part;
      for (const std::uint32_t v : elements[i]) owners.of_points[v] = std::min(owners.of_points[v], part);
      claim_boundary(shape, elements[i], part, boundary);
    }
  });
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
