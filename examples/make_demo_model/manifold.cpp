// The space inside a header pipe with branches: for flows.
#include <BRepAdaptor_Surface.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <cmath>
#include <GeomAbs_SurfaceType.hxx>
#include <stdexcept>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>

#include "examples/make_demo_model/demo_models.hpp"
#include "examples/make_demo_model/shape_tools.hpp"

namespace tetloom::demo {
namespace {

constexpr double kPipeRadius = 10, kBranchRadius = 6, kReach = 50, kBranchPitch = 30, kRound = 1.5;

/// What an end of a pipe is called; empty for walls.
std::string name_of(const BRepAdaptor_Surface& surface, double length, int branches) {
  if (surface.GetType() != GeomAbs_Plane) return {};
  const gp_Pnt at = surface.Plane().Location();
  if (std::abs(at.Z()) < 1e-6 && std::abs(at.X()) < 1e-6) return "inlet";
  if (std::abs(at.X() - kReach) < 1e-6) return "outlet " + std::to_string(std::lround(at.Z() / kBranchPitch) - 1);
  return branches == 0 && std::abs(at.Z() - length) < 1e-6 ? "outlet" : "";
}

}  // namespace

std::vector<DemoPart> make_manifold(int branches) {
  if (branches < 0 || branches > 50) throw std::runtime_error("a manifold has from 0 to 50 branches");
  const double length = branches == 0 ? 160 : kBranchPitch * (branches + 2);
  TopoDS_Shape shape = cylinder({0, 0, 0}, gp::DZ(), kPipeRadius, length);
  for (int i = 0; i < branches; ++i) {
    const double z = kBranchPitch * (i + 2);
    shape = BRepAlgoAPI_Fuse(shape, cylinder({0, 0, z}, gp::DX(), kBranchRadius, kReach)).Shape();
  }
  if (branches > 0)
    shape = fillet_edges(single_solid(shape), kRound, [](const EdgeEnds& e) {
      const double radius = std::hypot(e.middle.X(), e.middle.Y());
      return e.middle.X() > 0 && e.middle.X() < kReach - 1 && std::abs(radius - kPipeRadius) < 1e-3;
    });
  DemoPart part{"fluid", Quantity_Color(0.45, 0.65, 0.85, Quantity_TOC_sRGB), single_solid(shape), {}};
  for (TopExp_Explorer face(part.shape, TopAbs_FACE); face.More(); face.Next()) {
    const std::string name = name_of(BRepAdaptor_Surface(TopoDS::Face(face.Current())), length, branches);
    if (!name.empty()) part.faces.push_back({name, part.color, face.Current()});
  }
  return {part};
}

}  // namespace tetloom::demo
