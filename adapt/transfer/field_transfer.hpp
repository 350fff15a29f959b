#pragma once
// The fields of a mesh, carried over to what it has become.
#include <cstddef>
#include <string>
#include <vector>

#include "adapt/transfer/cell_transfer.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom::adapt {

/// One component of a field, on one mesh. The integral is over all tets, of a point field as it is interpolated.
struct FieldFigures {
  double integral = 0;
  double least = 0, greatest = 0;  ///< values
  double magnitude = 0;            ///< the integral of the magnitude
};

/// What has become of one field.
struct FieldTransfer {
  std::string name;
  bool on_cells = false;  ///< else on points
  struct Component {
    FieldFigures before, after;
    /// How far the integral has changed, as a share of that of the magnitude before.
    double change() const {
      const double by = after.integral - before.integral;
      return by == 0 || before.magnitude == 0 ? by : by / before.magnitude;
    }
  };
  std::vector<Component> components;
};

/// Throws Error(InvalidArgument), with the names that are known, for a name that no field on points or tets has, and
/// for one that is there twice; InputUnsuitable, with the tet, for values on tets that are not finite, which no
/// integral can be made of. Pre: `mesh` is consistent.
void check_transfer(const Mesh& mesh, const std::vector<std::string>& names);

/// Gives `to` the fields of `from` with those names, on points first: on points by interpolation, on tets as in
/// transfer_cells. Of a name that is on both, both. `background` is `from`, tet by tet. Pre: check_transfer. Errors:
/// Cancelled.
std::vector<FieldTransfer> transfer_fields(const Mesh& from, const BackgroundMesh& background, Mesh& to,
                                           const std::vector<std::string>& names, CellShape shape,
                                           const TaskRunner& runner);

}  // namespace tetloom::adapt
