// An eighth of a hollow ball: under pressure its stresses are known (Lamé).
#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <cmath>
#include <GeomAbs_SurfaceType.hxx>
#include <gp_Ax2.hxx>
#include <numbers>
#include <stdexcept>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>

#include "examples/make_demo_model/demo_models.hpp"
#include "examples/make_demo_model/shape_tools.hpp"

namespace tetloom::demo {
namespace {

constexpr double kRightAngle = std::numbers::pi / 2;

TopoDS_Shape eighth_of_ball(double radius) {
  const gp_Ax2 axes(gp::Origin(), gp::DZ(), gp::DX());
  return BRepPrimAPI_MakeSphere(axes, radius, 0, kRightAngle, kRightAngle).Shape();
}

std::string name_of(const BRepAdaptor_Surface& surface, double inner) {
  if (surface.GetType() == GeomAbs_Sphere)
    return std::abs(surface.Sphere().Radius() - inner) < 1e-6 ? "inner" : "outer";
  const gp_Dir normal = surface.Plane().Axis().Direction();
  return std::abs(normal.X()) > 0.5 ? "x=0" : std::abs(normal.Y()) > 0.5 ? "y=0" : "z=0";
}

}  // namespace

std::vector<DemoPart> make_hollow_sphere(int inner, int outer) {
  if (inner < 1 || outer <= inner || outer > 10000)
    throw std::runtime_error("a hollow sphere has radii from 1 to 10000, the inner one smaller");
  DemoPart part{"hollow sphere", Quantity_Color(0.70, 0.55, 0.50, Quantity_TOC_sRGB), {}, {}};
  part.shape = single_solid(BRepAlgoAPI_Cut(eighth_of_ball(outer), eighth_of_ball(inner)).Shape());
  for (TopExp_Explorer face(part.shape, TopAbs_FACE); face.More(); face.Next()) {
    const BRepAdaptor_Surface surface(TopoDS::Face(face.Current()));
    part.faces.push_back({name_of(surface, inner), part.color, face.Current()});
  }
  return {part};
}

}  // namespace tetloom::demo
