#pragma once
// Where shapes stand within others, bit by bit: OpenCASCADE computes transformations anew when it reads them. Private
// to core/cad.
#include <array>
#include <cstdint>
#include <map>
#include <TopLoc_Datum3D.hxx>
#include <TopLoc_Location.hxx>
#include <TopoDS_Shape.hxx>
#include <vector>

#include "tetloom/storage.hpp"

namespace tetloom::cad {

/// One factor of a location: a transformation, and how often it is applied.
struct LocationFactor {
  std::uint64_t datum = 0;  ///< of the same number: the same one
  std::array<double, 14> transformation{};
  std::int64_t power = 1;
};
using LocationFactors = std::vector<LocationFactor>;

LocationFactors factors_of(TopLoc_Location location);

/// Makes locations of their factors. What goes to and fro cancels where the datum is the same, not where it is equal;
/// so what belongs together is made by one of these.
class LocationMaker {
 public:
  TopLoc_Location make(const LocationFactors& factors);

 private:
  std::map<std::uint64_t, Handle(TopLoc_Datum3D)> datums_;
};

/// The same shape of parts of its own; curves and surfaces are shared.
TopoDS_Shape copy_of(const TopoDS_Shape& shape);

/// The locations of all that a shape consists of: of the shapes in others, of faces' surfaces and of edges' curves.
void put_locations(const TopoDS_Shape& shape, MessageWriter& writer);
/// A shape that was read, with the locations of the one that was written. Errors: Internal where they do not fit.
TopoDS_Shape with_locations(const TopoDS_Shape& read, MessageReader& locations, LocationMaker& maker);

}  // namespace tetloom::cad
