#pragma once
// The tets at a vertex.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/tets/working_mesh.hpp"

namespace tetloom::tets {

/// The tets at one vertex, without allocation.
struct VertexStar {
  std::uint32_t vertex = kNone;
  std::size_t count = 0;
  std::array<FaceCode, WorkingMesh::kMostTets + 3> codes;  ///< of each tet the face opposite of the vertex

  std::span<const FaceCode> tets() const { return {codes.data(), count}; }
};

/// Whether the tets around a vertex could be listed.
enum class StarVerdict {
  Found,
  OnSurface,  ///< the vertex is one of the given surface, or on a face that has to stay
  TooLarge    ///< more than WorkingMesh::kMostTets tets
};

/// Collects the tets at corner `corner` of `tet`, in an order that depends on the mesh alone.
StarVerdict find_star(const WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, VertexStar& star);

}  // namespace tetloom::tets
