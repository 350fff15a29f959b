// Two materials: a steel body with a flange, and the rubber seal around it.
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <utility>

#include "examples/make_demo_model/demo_models.hpp"
#include "examples/make_demo_model/shape_tools.hpp"

namespace tetloom::demo {
namespace {

TopoDS_Shape steel_body() {
  const TopoDS_Shape flange = cylinder({0, 0, 0}, gp::DZ(), 40, 12);
  const TopoDS_Shape stem = cylinder({0, 0, 12}, gp::DZ(), 20, 40);
  TopoDS_Shape body = BRepAlgoAPI_Fuse(flange, stem).Shape();
  for (const auto& [x, y] : {std::pair{32.0, 0.0}, {-32.0, 0.0}, {0.0, 32.0}, {0.0, -32.0}}) {
    body = BRepAlgoAPI_Cut(body, cylinder({x, y, -1}, gp::DZ(), 3.5, 14)).Shape();
  }
  return single_solid(BRepAlgoAPI_Cut(body, cylinder({0, 0, -1}, gp::DZ(), 10, 60)).Shape());
}

/// Sits on the flange and around the stem: it touches the body on an annulus and on a cylinder.
TopoDS_Shape rubber_seal() {
  const TopoDS_Shape outside = fillet_edges(cylinder({0, 0, 12}, gp::DZ(), 28, 24), 6, [](const EdgeEnds& e) {
    return e.middle.Z() > 35.9 && e.begin.Distance(e.end) < 1e-6;
  });
  return single_solid(BRepAlgoAPI_Cut(outside, cylinder({0, 0, 10}, gp::DZ(), 20, 40)).Shape());
}

}  // namespace

std::vector<DemoPart> make_assembly() {
  return {{"steel body", Quantity_Color(0.60, 0.66, 0.72, Quantity_TOC_sRGB), steel_body(), {}},
          {"rubber seal", Quantity_Color(0.20, 0.45, 0.70, Quantity_TOC_sRGB), rubber_seal(), {}}};
}

}  // namespace tetloom::demo
