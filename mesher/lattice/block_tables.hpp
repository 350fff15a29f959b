#pragma once
// What is around each site and cube of a block, as steps in a padded block.
#include <array>
#include <cstdint>
#include <type_traits>

#include "mesher/lattice/lattice_shape.hpp"
#include "mesher/lattice/site_blocks.hpp"

namespace tetloom::lattice {

/// Of a lattice of so many sites and so many types of tets per cube.
template <int Kinds, int Types>
struct BlockTables {
  /// A set of types of tets.
  using TypeSet = std::conditional_t<(Types <= 16), std::uint16_t, std::uint64_t>;
  static constexpr int kMostAround = 14;

  struct Type {
    std::array<int, 4> vert_offset;  ///< of its vertices, kinds one after the other
    std::array<int, 4> behind_offset, behind_type, behind_face;
  };
  std::array<Type, Types> types;
  std::array<TypeSet, Kinds> first_at{};  ///< types whose first vertex is of a kind
  /// From a site of a kind to those next to it; those of fewer have themselves in the places left.
  std::array<std::array<int, kMostAround>, Kinds> around_offset{};
  std::array<std::size_t, Kinds> around_count{};

  /// Pre: the lattice is of these numbers.
  explicit BlockTables(const LatticeShape& shape) {
    for (int type = 0; type < Types; ++type) {
      const TetType& tet = shape.tets()[static_cast<std::size_t>(type)];
      for (std::size_t i = 0; i < 4; ++i) {
        const TetType::Behind& behind = tet.behind[i];
        types[type].vert_offset[i] = tet.verts[i].kind * kPaddedCubes + offset(tet.verts[i]);
        types[type].behind_offset[i] = offset({0, behind.x, behind.y, behind.z});
        types[type].behind_type[i] = behind.type;
        types[type].behind_face[i] = behind.face;
      }
      TypeSet& first = first_at[tet.verts[0].kind];
      first = static_cast<TypeSet>(first | TypeSet{1} << type);
    }
    for (int kind = 0; kind < Kinds; ++kind) {
      const Site& site = shape.sites()[static_cast<std::size_t>(kind)];
      std::size_t& count = around_count[static_cast<std::size_t>(kind)];
      for (const Site& next : shape.around(kind)) {
        const SiteStep step = shape.step_to(site, next);
        around_offset[kind][count++] = (step.kind - kind) * kPaddedCubes + offset(step);
      }
    }
  }

  /// How many types a set holds: from a table, since the baseline of x86-64 has no instruction for it.
  static std::uint32_t count(TypeSet set) {
    std::uint32_t sum = 0;
    for (int bit = 0; bit < Types; bit += kChunk) sum += kCounts[set >> bit & (kCounts.size() - 1)];
    return sum;
  }

 private:
  static constexpr int offset(const SiteStep& step) { return (step.z * kPaddedWidth + step.y) * kPaddedWidth + step.x; }

  static constexpr int kChunk = 12;
  static constexpr std::array<std::uint8_t, 1 << kChunk> kCounts = [] {
    std::array<std::uint8_t, 1 << kChunk> counts{};
    for (std::size_t set = 1; set < counts.size(); ++set)
      counts[set] = static_cast<std::uint8_t>(counts[set >> 1] + (set & 1));
    return counts;
  }();
};

}  // namespace tetloom::lattice
