#include "examples/make_demo_model/shape_tools.hpp"

#include <BRep_Tool.hxx>
#include <BRepAdaptor_Curve.hxx>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <gp_Ax2.hxx>
#include <gp_Vec.hxx>
#include <ShapeUpgrade_UnifySameDomain.hxx>
#include <stdexcept>
#include <string>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

namespace tetloom::demo {

bool is_along(const EdgeEnds& edge, const gp_Dir& direction) {
  if (edge.begin.Distance(edge.end) < 1e-9) return false;
  const gp_Vec chord(edge.begin, edge.end);
  const gp_Pnt half((edge.begin.XYZ() + edge.end.XYZ()) / 2);
  return chord.IsParallel(gp_Vec(direction), 1e-6) && half.Distance(edge.middle) < 1e-6;
}

TopoDS_Shape fillet_edges(const TopoDS_Shape& shape, double radius,
                          const std::function<bool(const EdgeEnds&)>& wanted) {
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  BRepFilletAPI_MakeFillet fillet(shape);
  int count = 0;
  for (int i = 1; i <= edges.Extent(); ++i) {
    const TopoDS_Edge& edge = TopoDS::Edge(edges(i));
    if (BRep_Tool::Degenerated(edge)) continue;
    const BRepAdaptor_Curve curve(edge);
    const double low = curve.FirstParameter(), high = curve.LastParameter();
    if (!wanted({curve.Value(low), curve.Value((low + high) / 2), curve.Value(high)})) continue;
    fillet.Add(radius, edge);
    ++count;
  }
  if (count == 0) throw std::runtime_error("no edge to round");
  fillet.Build();
  if (!fillet.IsDone()) throw std::runtime_error("a fillet cannot be made");
  return fillet.Shape();
}

TopoDS_Shape cylinder(const gp_Pnt& base, const gp_Dir& axis, double radius, double height) {
  return BRepPrimAPI_MakeCylinder(gp_Ax2(base, axis), radius, height).Shape();
}

TopoDS_Shape single_solid(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape solids;
  TopExp::MapShapes(shape, TopAbs_SOLID, solids);
  if (solids.Extent() != 1) throw std::runtime_error("expected one solid, got " + std::to_string(solids.Extent()));
  return solids(1);
}

}  // namespace tetloom::demo
