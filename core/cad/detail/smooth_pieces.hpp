#pragma once
// Where curves and surfaces of OpenCASCADE are smooth, for quadrature.
//
// Private to core/cad.
#include <array>
#include <Geom2dAdaptor_Curve.hxx>
#include <Geom_Surface.hxx>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::cad {

/// One parameter of a surface over a range.
struct SmoothAxis {
  std::vector<double> breaks;  ///< ascending; between two of them the surface is smooth and turns by 60 degrees at most
  int nodes = 1;               ///< Gauss points that one of those pieces takes
  double lo = -HUGE_VAL, hi = HUGE_VAL;  ///< the domain; infinite where the surface repeats or goes on
};

/// The axes u and v of an untrimmed surface, with the breaks between `lo` and `hi`.
std::array<SmoothAxis, 2> surface_axes(const Handle(Geom_Surface) & surface, const Vec2& lo, const Vec2& hi);

/// Ascending parameters from `first` to `last` between which the curve is smooth and turns little.
std::vector<double> smooth_places(const Geom2dAdaptor_Curve& curve, double first, double last);

}  // namespace tetloom::cad
