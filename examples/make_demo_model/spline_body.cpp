// A wavy barrel whose faces are all B-spline surfaces, for the benches.
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepLib.hxx>
#include <cmath>
#include <Geom_BSplineSurface.hxx>
#include <Geom_Curve.hxx>
#include <Geom_Plane.hxx>
#include <Geom_RectangularTrimmedSurface.hxx>
#include <GeomConvert.hxx>
#include <numbers>
#include <ShapeFix_Shape.hxx>
#include <stdexcept>
#include <TColgp_Array2OfPnt.hxx>
#include <TColStd_Array1OfInteger.hxx>
#include <TColStd_Array1OfReal.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <TopoDS_Solid.hxx>

#include "examples/make_demo_model/demo_models.hpp"
#include "examples/make_demo_model/shape_tools.hpp"

namespace tetloom::demo {
namespace {

constexpr int kAround = 40, kUp = 18, kDegree = 3;
constexpr double kHeight = 120, kRadius = 40, kTolerance = 1e-6;

/// A control point of the barrel at turn `turn` (0 … 1) and height `level` (0 … 1).
gp_Pnt barrel_point(double turn, double level) {
  const double angle = 2 * std::numbers::pi * turn;
  const double belly = 1 + 0.25 * std::sin(std::numbers::pi * level);
  const double waves = 1 + 0.09 * std::cos(3 * angle + 2 * level) * std::sin(5 * level + 0.5);
  const double radius = kRadius * belly * waves;
  return {radius * std::cos(angle), radius * std::sin(angle), kHeight * level};
}

/// The whole side: periodic around (u from 0 to 1), clamped upwards (v from 0 to 1).
Handle(Geom_BSplineSurface) make_barrel() {
  TColgp_Array2OfPnt poles(1, kAround, 1, kUp);
  for (int i = 1; i <= kAround; ++i) {
    for (int j = 1; j <= kUp; ++j) poles(i, j) = barrel_point((i - 1.0) / kAround, (j - 1.0) / (kUp - 1));
  }
  TColStd_Array1OfReal u_knots(1, kAround + 1), v_knots(1, kUp - kDegree + 1);
  TColStd_Array1OfInteger u_mults(1, kAround + 1), v_mults(1, kUp - kDegree + 1);
  u_mults.Init(1);
  v_mults.Init(1);
  v_mults(1) = v_mults(v_mults.Upper()) = kDegree + 1;
  for (int i = 1; i <= u_knots.Upper(); ++i) u_knots(i) = (i - 1.0) / kAround;
  for (int j = 1; j <= v_knots.Upper(); ++j) v_knots(j) = (j - 1.0) / (v_knots.Upper() - 1);
  return new Geom_BSplineSurface(poles, u_knots, v_knots, u_mults, v_mults, kDegree, kDegree, Standard_True);
}

/// A patch of the barrel, as a surface of its own.
TopoDS_Face make_patch(const Handle(Geom_BSplineSurface) & barrel, double u0, double u1, double v0, double v1) {
  const Handle(Geom_BSplineSurface) patch = Handle(Geom_BSplineSurface)::DownCast(barrel->Copy());
  patch->Segment(u0, u1, v0, v1);
  return BRepBuilderAPI_MakeFace(patch, kTolerance);
}

/// The flat end at v = `v`, on a B-spline surface too.
TopoDS_Face make_end(const Handle(Geom_BSplineSurface) & barrel, int sides, double v) {
  const Handle(Geom_Curve) rim = barrel->VIso(v);
  BRepBuilderAPI_MakeWire wire;
  for (int s = 0; s < sides; ++s) {
    wire.Add(BRepBuilderAPI_MakeEdge(rim, static_cast<double>(s) / sides, (s + 1.0) / sides).Edge());
  }
  const Handle(Geom_Plane) plane = new Geom_Plane(gp_Pnt(0, 0, kHeight * v), gp::DZ());
  const Handle(Geom_Surface) square =
      new Geom_RectangularTrimmedSurface(plane, -2 * kRadius, 2 * kRadius, -2 * kRadius, 2 * kRadius);
  const TopoDS_Face face = BRepBuilderAPI_MakeFace(GeomConvert::SurfaceToBSplineSurface(square), wire.Wire());
  // On a B-spline surface, flat or not, edges need parameter curves.
  ShapeFix_Shape fix(face);
  fix.Perform();
  return TopoDS::Face(fix.Shape());
}

}  // namespace

std::vector<DemoPart> make_spline_body(int sides, int levels) {
  if (sides < 3 || sides > 100) throw std::runtime_error("a spline body has from 3 to 100 sides");
  if (levels < 1 || levels > 100) throw std::runtime_error("a spline body has from 1 to 100 levels");
  const Handle(Geom_BSplineSurface) barrel = make_barrel();
  BRepBuilderAPI_Sewing sewing(kTolerance);
  for (int s = 0; s < sides; ++s) {
    for (int l = 0; l < levels; ++l) {
      sewing.Add(make_patch(barrel, static_cast<double>(s) / sides, (s + 1.0) / sides, static_cast<double>(l) / levels,
                            (l + 1.0) / levels));
    }
  }
  for (const double end : {0.0, 1.0}) sewing.Add(make_end(barrel, sides, end));
  sewing.Perform();
  const TopExp_Explorer shell(sewing.SewedShape(), TopAbs_SHELL);
  if (!shell.More() || sewing.NbFreeEdges() > 0) throw std::runtime_error("the faces of the spline body do not close");
  TopoDS_Solid solid = BRepBuilderAPI_MakeSolid(TopoDS::Shell(shell.Current())).Solid();
  BRepLib::OrientClosedSolid(solid);
  return {{"spline body", Quantity_Color(0.75, 0.55, 0.45, Quantity_TOC_sRGB), solid, {}}};
}

}  // namespace tetloom::demo
