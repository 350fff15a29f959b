#pragma once
// Which vertices of a mesh of tetrahedra share an edge.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/block_loop.hpp"
#include "core/base/vec.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom::adapt {

using TetVerts = std::array<std::uint32_t, 4>;

/// The points of a mesh and its tetrahedra. Non-owning.
struct TetView {
  std::span<const Vec3> points;
  std::span<const TetVerts> tets;
};

inline TetView tets_of(const Mesh& mesh) { return {mesh.points, mesh.tet_to_vert}; }

/// Neighbours of vertices across edges, ascending.
class VertexGraph {
 public:
  /// Pre: indices in range. Linear; 64 bytes per tet while it is built, about 60 per vertex afterwards.
  explicit VertexGraph(const TetView& mesh, const BlockLoop& loop = serial_loop());

  std::size_t size() const { return begins_.size() - 1; }
  std::span<const std::uint32_t> neighbors(std::size_t vert) const {
    return {neighbors_.data() + begins_[vert], begins_[vert + 1] - begins_[vert]};
  }

 private:
  std::vector<std::size_t> begins_;  ///< one more than vertices
  std::vector<std::uint32_t> neighbors_;
};

}  // namespace tetloom::adapt
