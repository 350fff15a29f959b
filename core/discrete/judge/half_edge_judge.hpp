#pragma once
// OpenMesh as an independent judge of facets, for tests. No library of tetloom links it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

#include "tetloom/vec.hpp"

namespace tetloom {

/// Numbers of what OpenMesh finds.
struct HalfEdgeCounts {
  std::size_t vertices = 0, edges = 0, facets = 0, open_edges = 0;
  friend bool operator==(const HalfEdgeCounts&, const HalfEdgeCounts&) = default;
};

/// What OpenMesh counts in the facets; nothing when it refuses one of them, because they are no oriented manifold.
std::optional<HalfEdgeCounts> judge_facets(std::span<const Vec3> points,
                                           std::span<const std::array<std::uint32_t, 3>> tri_to_vert);

/// What OpenMesh's own reader finds in a file; nothing when it cannot read it.
std::optional<HalfEdgeCounts> judge_file(const std::filesystem::path& path);

}  // namespace tetloom
