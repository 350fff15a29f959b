#pragma once
// The fields of a mesh, carried over to what it has become.
#include <cstddef>
#include <string>
#include <vector>

#include "adapt/transfer/cell_transfer.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::adapt {

/// Throws Error(InvalidArgument), with the names that are known, for a name that no field on points or tets has, and
/// for one that is there twice; InputUnsuitable, with the tet, for values on tets that are not finite, which no
/// integral can be made of. Pre: `mesh` is consistent.
void check_transfer(const Mesh& mesh, const std::vector<std::string>& names);

/// Values on some points and tets, all components of all fields side by side.
struct CarriedFields {
  std::vector<double> on_points, on_tets;
};

/// Fields of `from` with certain names, on points by interpolation, on tets as in transfer_cells; of a name that is on
/// both, both. `background` is `from`, tet by tet. Refers to all that it is given. Pre: check_transfer.
class FieldCarrier {
 public:
  FieldCarrier(const Mesh& from, const BackgroundMesh& background, const std::vector<std::string>& names);

  bool has_none() const { return on_points_.empty() && on_tets_.empty(); }
  /// What the first `point_count` points of `to` get, and its tets, which may be some of the mesh: before integrals are
  /// put right. `places`: of all of its points. Values do not depend on what else is in `to`. Errors: Cancelled.
  CarriedFields carry(const TetsInRegions& to, std::size_t point_count, std::span<const BackgroundPlace> places,
                      CellReconstruction shape, const TaskRunner& runner) const;
  /// Puts integrals on tets right and gives `to` the fields, on points first. Pre: `carried` is that of all points and
  /// tets of `to`, in their order.
  std::vector<FieldTransfer> finish(CarriedFields&& carried, Mesh& to, const TaskRunner& runner) const;

 private:
  CellSource tet_source(std::span<const double> values) const;

  const Mesh& from_;
  const BackgroundMesh& background_;
  std::vector<const MeshField*> on_points_, on_tets_;
  std::size_t point_components_ = 0, tet_components_ = 0;
};

}  // namespace tetloom::adapt
