#pragma once
// A mesh of second order while its mid nodes move: which tets are valid, and which lie at a mid node.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "core/mesh/curved_tet.hpp"
#include "core/mesh/mid_nodes.hpp"
#include "mesher/second_order/mid_node_places.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::second_order {

/// A mid node, by its place in `Mesh::mid_to_vert`, and a tet that has it.
using MidAndTet = std::pair<std::uint32_t, std::uint32_t>;

class CurvedMesh {
 public:
  /// Tets are good where their Jacobian is proven to be at least `least` times that of the straight tet. All outlive
  /// the object, and `mesh` keeps its elements.
  CurvedMesh(Mesh& mesh, double least, const TaskRunner& runner)
      : mesh_(mesh), mids_(mesh), first_mid_(vertex_count(mesh)), least_(least), runner_(runner) {}

  const Mesh& mesh() const { return mesh_; }
  double least() const { return least_; }
  const TaskRunner& runner() const { return runner_; }

  Vec3& point(std::uint32_t mid) { return mesh_.points[first_mid_ + mid]; }
  Vec3 middle(std::uint32_t mid) const { return middle_of_edge(mesh_, mid); }
  /// Inside of a region, not on the surface.
  bool is_inside(std::uint32_t mid) const { return mesh_.point_to_entity[first_mid_ + mid].dim == 3; }

  std::array<std::uint32_t, 6> mids_of(std::uint32_t tet) const { return mids_of_tet(mesh_, mids_, tet); }
  TetJacobian jacobian_of(std::uint32_t tet) const { return tet_jacobian(nodes_of_tet(mesh_, mids_, tet)); }
  bool is_straight(std::uint32_t tet) const { return is_straight_tet(mesh_, mids_, tet); }
  bool is_good(std::uint32_t tet) const {
    return is_straight(tet) || least_jacobian(jacobian_of(tet), least_) >= least_;
  }

  /// Those of `tets` that are not good, in their order.
  std::vector<std::uint32_t> find_bad(std::span<const std::uint32_t> tets) const;
  /// All pairs of one of `mids`, which ascend, and a tet; ascending.
  std::vector<MidAndTet> tets_at(std::span<const std::uint32_t> mids) const;

 private:
  Mesh& mesh_;
  MidNodes mids_;
  std::size_t first_mid_;
  double least_;
  const TaskRunner& runner_;
};

/// The tets of some pairs, each once, ascending.
std::vector<std::uint32_t> tets_of(std::span<const MidAndTet> pairs);

/// The mid nodes of `curved`.
std::vector<std::uint32_t> mids_of(std::span<const CurvedNode> curved);

}  // namespace tetloom::second_order
