#pragma once
// The digest of a mesh as sums that commute: it can be put together from what lies in several places.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "tetloom/host.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// What mesh_digest is made of: how many elements of each kind there are, and the sums of their hashes modulo 2^128.
struct DigestSums {
  static constexpr std::size_t kPoints = 0, kEdges = 1, kTriangles = 2, kQuads = 4, kMidNodes = 8;
  static constexpr std::array<std::size_t, kCellKinds> kCells{3, 5, 6, 7};  ///< by CellKind

  struct Sum {
    std::uint64_t count = 0, low = 0, high = 0;
  };
  std::array<Sum, 9> kinds{};

  void add(const DigestSums& other);
};

/// Of all elements of `mesh`, and of those of its points that `counts` marks, one mark per point; empty: of all.
/// Pre, complexity and thread safety as for mesh_digest.
DigestSums digest_sums(const Mesh& mesh, std::span<const std::uint8_t> counts, const BlockLoop& loop);

/// The digest of the mesh of which every element is in one of the sums that were added up.
std::string digest_of(const DigestSums& sums);

}  // namespace tetloom
