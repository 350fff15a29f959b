#pragma once
// The fields of a mesh, carried over to what it has become.
#include <cstddef>
#include <span>
#include <string>
#include <vector>

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

/// Those with the names, in the order of the names.
std::vector<const MeshField*> fields_named(const std::vector<MeshField>& all, const std::vector<std::string>& names);

/// Values on some points and tets, all components of all fields side by side.
struct CarriedFields {
  std::vector<double> on_points, on_tets;
};

/// What is known of the fields of the whole mesh before anything is done.
struct FieldsBefore {
  std::vector<FieldFigures> on_points, on_tets;  ///< component by component
  SumsByRegion regions;                          ///< of what is on tets
};

/// The mesh that fields are given on, or the slice of it that a rank has. Non-owning.
struct FieldPlaces {
  const Mesh& fields;
  TetsInRegions tets;  ///< positive, those from `begin` to `end` this rank's own; regions for fields on tets alone
  std::size_t begin = 0, end = 0;
  std::span<const std::uint8_t> is_own;  ///< of points; empty: all

  TetView own_tets() const { return {tets.mesh.points, tets.mesh.tets.subspan(begin, end - begin)}; }
};

/// For the fields with these names. In SharedWork::together.
FieldsBefore fields_before(const FieldPlaces& from, const std::vector<std::string>& names, const SharedWork& work);

/// The values on all tets of a mesh, all components of the fields with these names side by side.
struct JoinedCells {
  std::vector<double> values;
  std::size_t components = 0;
  operator CellValues() const { return {values, components}; }
};
JoinedCells join_cells(const Mesh& mesh, std::size_t tet_count, const std::vector<std::string>& names);

/// Fields of `from` with certain names, on points by interpolation, on tets as CellAverager finds them; of a name that
/// is on both, both. Refers to all that it is given. Pre: check_transfer.
class FieldCarrier {
 public:
  /// `background` is `from`, tet by tet. Where it lies in `tiles`, no values are asked for of `from`.
  FieldCarrier(const Mesh& from, const BackgroundMesh& background, BackgroundTiles* tiles,
               const std::vector<std::string>& names, FieldsBefore&& before);

  bool has_none() const { return on_points_.empty() && on_tets_.empty(); }
  /// What the points and tets of `to` get, which may be some of the mesh: before integrals are put right. `hints`: for
  /// all of its points. Values do not depend on what else is in `to`. In SharedWork::together. Errors: Cancelled.
  CarriedFields carry(const TetsInRegions& to, std::span<const BackgroundTet> hints, CellReconstruction shape,
                      const SharedWork& work) const;
  /// Puts integrals on tets right, and says what has become of the fields; those on points come first. `to`: what this
  /// rank has, with what was carried for it. Sums are exact, so nothing depends on the ranks. In
  /// SharedWork::together.
  std::vector<FieldTransfer> finish(const TetsInRegions& to, CarriedFields& carried, const SharedWork& work) const;
  /// Gives `to` the fields, of all of its points and tets.
  void give(CarriedFields&& carried, Mesh& to) const;
  /// Names and components of the fields on points and on tets.
  std::vector<FieldInfo> infos_on_points() const;
  std::vector<FieldInfo> infos_on_tets() const;

 private:
  void put_values_at(const BackgroundPlace& place, double* values) const;
  std::vector<double> average_cells(const OldTets& from, const TetsInRegions& to,
                                    std::span<const BackgroundPlace> places, const SharedWork& work) const;
  std::vector<double> carry_cells(const TetsInRegions& to, std::span<const BackgroundPlace> places,
                                  CellReconstruction shape, const SharedWork& work) const;

  const Mesh& from_;
  const BackgroundMesh& background_;
  BackgroundTiles* tiles_;
  std::vector<std::string> names_;
  std::vector<const MeshField*> on_points_, on_tets_;
  std::size_t point_components_ = 0, tet_components_ = 0;
  FieldsBefore before_;
};

}  // namespace tetloom::adapt
