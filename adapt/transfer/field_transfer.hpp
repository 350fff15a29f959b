#pragma once
// The fields of a mesh, carried over to what it has become.
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "adapt/parts/mesh_slice.hpp"
#include "adapt/transfer/cell_transfer.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::adapt {

/// Throws Error(InvalidArgument), with the names that are known, for a name that no field on points or tets has, and
/// for one that is there twice; InputUnsuitable, with the tet, for values on tets that are not finite, which no
/// integral can be made of. Pre: `mesh` is consistent.
void check_transfer(const Mesh& mesh, const std::vector<std::string>& names);

/// Values on some points and tets, all components of all fields side by side.
struct CarriedFields {
  std::vector<double> on_points, on_tets;
};

/// The tets that one rank has of a mesh, part after part, with their points.
struct TetsByPart {
  TetsInRegions tets;
  std::span<const std::size_t> first_tets;  ///< where those of each part begin, and how many there are

  std::size_t part_count() const { return first_tets.size() - 1; }
  std::size_t first(std::size_t part) const { return first_tets[part]; }
  std::size_t count(std::size_t part) const { return first_tets[part + 1] - first_tets[part]; }
  TetsInRegions part(std::size_t p) const {
    return {{tets.mesh.points, tets.mesh.tets.subspan(first(p), count(p))}, tets.regions.subspan(first(p), count(p))};
  }
};

/// What is said of the fields on points of the whole mesh before anything is done, component by component; for carriers
/// that come too late to ask. `own`: the slice's own tets, positive ones. In SharedWork::together.
std::vector<FieldFigures> figures_before(const MeshSlice& slice, const TetView& own,
                                         const std::vector<std::string>& names, const SharedWork& work);

/// Whether a field on tets has one of the names.
bool carries_on_tets(const Mesh& mesh, const std::vector<std::string>& names);

/// Fields of `from` with certain names, on points by interpolation, on tets as in transfer_cells; of a name that is on
/// both, both. `background` is `from`, tet by tet. Refers to all that it is given. Pre: check_transfer.
class FieldCarrier {
 public:
  FieldCarrier(const Mesh& from, const BackgroundMesh& background, const std::vector<std::string>& names);
  /// The same for fields on points of a mesh that lies in tiles. `before`: what is said of them; of `from` no values
  /// are asked for then, and `carry` is not called.
  FieldCarrier(const Mesh& from, const BackgroundMesh& background, const std::vector<std::string>& names,
               std::vector<FieldFigures>&& before);

  bool has_none() const { return on_points_.empty() && on_tets_.empty(); }
  /// What the points and tets of `to` get, which may be some of the mesh: before integrals are put right. `places`: of
  /// all of its points. Values do not depend on what else is in `to`. Errors: Cancelled.
  CarriedFields carry(const TetsInRegions& to, std::span<const BackgroundPlace> places, CellReconstruction shape,
                      const TaskRunner& runner) const;
  /// Puts integrals on tets right, and says what has become of the fields; those on points come first. `to`: what this
  /// rank has, with what was carried for it. Sums of parts are added up in the order of parts, so nothing depends on
  /// the ranks. In SharedWork::together.
  std::vector<FieldTransfer> finish(const TetsByPart& to, CarriedFields& carried, const SharedWork& work) const;
  /// Gives `to` the fields, of all of its points and tets.
  void give(CarriedFields&& carried, Mesh& to) const;
  /// Names and components of the fields on points and on tets.
  std::vector<FieldInfo> infos_on_points() const;
  std::vector<FieldInfo> infos_on_tets() const;

 private:
  CellSource tet_source(std::span<const double> values) const;
  void put_right(const TetsByPart& to, std::vector<double>& on_tets, const SharedWork& work) const;
  std::vector<FieldFigures> find_before(bool on_cells, const BlockLoop& loop) const;
  std::array<std::vector<FieldFigures>, 2> compare(const TetsByPart& to, std::span<const double> carried, bool on_cells,
                                                   const SharedWork& work) const;

  const Mesh& from_;
  const BackgroundMesh& background_;
  std::vector<const MeshField*> on_points_, on_tets_;
  std::size_t point_components_ = 0, tet_components_ = 0;
  std::vector<FieldFigures> before_;  // where they are known
};

}  // namespace tetloom::adapt
