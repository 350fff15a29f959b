#pragma once
// What the demo models share.
#include <functional>
#include <gp.hxx>
#include <gp_Dir.hxx>
#include <gp_Pnt.hxx>
#include <TopoDS_Shape.hxx>

namespace tetloom::demo {

/// Three points of an edge, to tell it by.
struct EdgeEnds {
  gp_Pnt begin, middle, end;
};

/// The edge runs straight along `direction`.
bool is_along(const EdgeEnds& edge, const gp_Dir& direction);

/// Rounds the edges that `wanted` picks. Throws std::runtime_error when there is none or it cannot be done.
TopoDS_Shape fillet_edges(const TopoDS_Shape& shape, double radius, const std::function<bool(const EdgeEnds&)>& wanted);

TopoDS_Shape cylinder(const gp_Pnt& base, const gp_Dir& axis, double radius, double height);

/// The one solid in `shape`. Throws std::runtime_error when there are none or several.
TopoDS_Shape single_solid(const TopoDS_Shape& shape);

}  // namespace tetloom::demo
