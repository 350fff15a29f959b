// The bracket. Every step is one that a machinist would recognise.
#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <cmath>
#include <Geom_BSplineSurface.hxx>
#include <GeomAbs_SurfaceType.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <utility>

#include "examples/make_demo_model/demo_models.hpp"
#include "examples/make_demo_model/shape_tools.hpp"

namespace tetloom::demo {
namespace {

constexpr double kLength = 120, kWidth = 80, kBase = 18;
constexpr double kBossX = 60, kBossY = 40, kBossRadius = 22, kBossHeight = 62;

/// A gentle hill over the base plate: what lies below it remains.
TopoDS_Shape below_spline_top() {
  constexpr int kPoints = 7;
  TColgp_Array2OfPnt points(1, kPoints, 1, kPoints);
  for (int i = 1; i <= kPoints; ++i) {
    for (int j = 1; j <= kPoints; ++j) {
      const double u = (i - 1.0) / (kPoints - 1), v = (j - 1.0) / (kPoints - 1);
      const double height = kBossHeight - 9 + 3.5 * std::sin(3.1 * u + 0.4) * std::cos(4.0 * v);
      points.SetValue(i, j, gp_Pnt(-20 + (kLength + 40) * u, -20 + (kWidth + 40) * v, height));
    }
  }
  const Handle(Geom_BSplineSurface) surface = GeomAPI_PointsToBSplineSurface(points, 3, 5).Surface();
  const TopoDS_Face face = BRepBuilderAPI_MakeFace(surface, 1e-6);
  return BRepPrimAPI_MakePrism(face, gp_Vec(0, 0, -200)).Shape();
}

TopoDS_Shape base_plate() {
  TopoDS_Shape plate = BRepPrimAPI_MakeBox(kLength, kWidth, kBase).Shape();
  plate = fillet_edges(plate, 12, [](const EdgeEnds& e) { return is_along(e, gp::DZ()); });
  // The pocket is milled with a round tool: its upright edges are rounded.
  TopoDS_Shape pocket = BRepPrimAPI_MakeBox(gp_Pnt(88, 20, 6), 24, 40, 40).Shape();
  pocket = fillet_edges(pocket, 5, [](const EdgeEnds& e) { return is_along(e, gp::DZ()); });
  return BRepAlgoAPI_Cut(plate, pocket).Shape();
}

TopoDS_Shape with_boss(const TopoDS_Shape& plate) {
  const TopoDS_Shape boss = cylinder({kBossX, kBossY, 0}, gp::DZ(), kBossRadius, kBossHeight);
  const TopoDS_Shape boss_with_top = BRepAlgoAPI_Common(boss, below_spline_top()).Shape();
  const TopoDS_Shape fused = BRepAlgoAPI_Fuse(plate, boss_with_top).Shape();
  // A fillet where the boss stands on the plate.
  return fillet_edges(fused, 5, [](const EdgeEnds& e) {
    const double radius = std::hypot(e.middle.X() - kBossX, e.middle.Y() - kBossY);
    return std::abs(radius - kBossRadius) < 1e-3 && std::abs(e.middle.Z() - kBase) < 1e-3;
  });
}

TopoDS_Shape drilled(TopoDS_Shape shape) {
  for (const auto& [x, y] : {std::pair{14.0, 14.0}, {14.0, 66.0}, {106.0, 10.0}, {106.0, 70.0}}) {
    shape = BRepAlgoAPI_Cut(shape, cylinder({x, y, -1}, gp::DZ(), 4, kBase + 2)).Shape();
    // Countersink.
    shape = BRepAlgoAPI_Cut(shape, cylinder({x, y, kBase - 4}, gp::DZ(), 7, 10)).Shape();
  }
  // The bore of the boss, and a cross hole through its curved face.
  shape = BRepAlgoAPI_Cut(shape, cylinder({kBossX, kBossY, -1}, gp::DZ(), 11, kBossHeight + 2)).Shape();
  return BRepAlgoAPI_Cut(shape, cylinder({kBossX - 40, kBossY, 37}, gp::DX(), 5, 80)).Shape();
}

}  // namespace

std::vector<DemoPart> make_machined_part() {
  DemoPart part{"bracket", Quantity_Color(0.55, 0.62, 0.70, Quantity_TOC_sRGB), {}, {}};
  part.shape = single_solid(drilled(with_boss(base_plate())));
  for (TopExp_Explorer face(part.shape, TopAbs_FACE); face.More(); face.Next()) {
    const BRepAdaptor_Surface surface(TopoDS::Face(face.Current()));
    const double radius = surface.GetType() == GeomAbs_Cylinder ? surface.Cylinder().Radius() : 0;
    const bool is_bore = std::abs(radius - 11) < 1e-6, is_bolt_hole = std::abs(radius - 4) < 1e-6;
    if (surface.GetType() == GeomAbs_BSplineSurface) {
      part.faces.push_back({"spline top", Quantity_Color(0.85, 0.45, 0.25, Quantity_TOC_sRGB), face.Current()});
    } else if (is_bolt_hole) {
      part.faces.push_back({"bolt hole", part.color, face.Current()});
    } else if (is_bore) {
      part.faces.push_back({"bore", Quantity_Color(0.30, 0.60, 0.45, Quantity_TOC_sRGB), face.Current()});
    }
  }
  return {part};
}

}  // namespace tetloom::demo
