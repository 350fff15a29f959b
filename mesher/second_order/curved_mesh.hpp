#pragma once
// A mesh of second order while its mid nodes move: which cells are valid, and which lie at a mid node.
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/curved_cell.hpp"
#include "core/mesh/curved_tet.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "mesher/second_order/mid_node_places.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::second_order {

/// A mid node, by its place in `Mesh::mid_to_vert`, and a cell that has it.
using MidAndCell = std::pair<std::uint32_t, std::uint32_t>;

/// Cells of all kinds are numbered one after the other, tets first.
class CurvedMesh {
 public:
  /// Cells are good where their Jacobian is proven to be at least `least` times that of the straight cell. All outlive
  /// the object, and `mesh` keeps its elements.
  CurvedMesh(Mesh& mesh, double least, const TaskRunner& runner);

  const Mesh& mesh() const { return mesh_; }
  double least() const { return least_; }
  const TaskRunner& runner() const { return runner_; }

  Vec3& point(std::uint32_t mid) { return mesh_.points[first_mid_ + mid]; }
  Vec3 middle(std::uint32_t mid) const { return middle_of_edge(mesh_, mid); }
  bool is_on_surface(std::uint32_t mid) const { return mesh_.point_to_entity[first_mid_ + mid].dim < 3; }
  /// Inside of a region, not on the surface, and only tets have it.
  bool is_free(std::uint32_t mid) const {
    return !is_on_surface(mid) && (is_of_layers_.empty() || !is_of_layers_[mid]);
  }

  bool is_tet(std::uint32_t cell) const { return cell < mesh_.tet_to_vert.size(); }
  CellMids mids_of(std::uint32_t cell) const;
  TetJacobian jacobian_of(std::uint32_t tet) const { return tet_jacobian(nodes_of_tet(mesh_, mids_, tet)); }
  bool is_straight(std::uint32_t cell) const;
  /// As tetloom::least_jacobian.
  double least_jacobian_of(std::uint32_t cell) const;
  bool is_good(std::uint32_t cell) const { return is_straight(cell) || least_jacobian_of(cell) >= least_; }

  /// Those of `cells` that are not good, in their order.
  std::vector<std::uint32_t> find_bad(std::span<const std::uint32_t> cells) const;
  /// All pairs of one of `mids`, which ascend, and a cell; ascending.
  std::vector<MidAndCell> cells_at(std::span<const std::uint32_t> mids) const;

 private:
  struct CellVerts {
    CellKind kind;
    std::span<const std::uint32_t> verts;
  };
  CellVerts verts_of(std::uint32_t cell) const;

  Mesh& mesh_;
  MidNodes mids_;
  std::size_t first_mid_;
  double least_;
  const TaskRunner& runner_;
  std::vector<bool> is_of_layers_;  // by mid: of a cell that is no tet; empty: none is
};

/// The cells of some pairs, each once, ascending.
std::vector<std::uint32_t> cells_of(std::span<const MidAndCell> pairs);

/// The mid nodes of `curved`.
std::vector<std::uint32_t> mids_of(std::span<const CurvedNode> curved);

}  // namespace tetloom::second_order
