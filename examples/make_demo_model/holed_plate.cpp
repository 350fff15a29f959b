// A plate with rounded holes, for the benches: many faces of several kinds, all of them small tori and cylinders.
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <cmath>
#include <stdexcept>
#include <TopTools_ListOfShape.hxx>

#include "examples/make_demo_model/demo_models.hpp"
#include "examples/make_demo_model/shape_tools.hpp"

namespace tetloom::demo {
namespace {

constexpr double kHolePitch = 20, kHoleRadius = 5, kRim = 1, kThickness = 8;

}  // namespace

std::vector<DemoPart> make_holed_plate(int holes) {
  if (holes < 1 || holes > 400) throw std::runtime_error("a plate has from 1 to 400 holes");
  const int columns = static_cast<int>(std::ceil(std::sqrt(1.2 * holes)));
  const int rows = (holes + columns - 1) / columns;
  const TopoDS_Shape plate = BRepPrimAPI_MakeBox(kHolePitch * columns, kHolePitch * rows, kThickness).Shape();
  TopTools_ListOfShape plates, drills;
  plates.Append(fillet_edges(plate, 4, [](const EdgeEnds& e) { return is_along(e, gp::DZ()); }));
  for (int i = 0; i < holes; ++i) {
    drills.Append(cylinder({kHolePitch * (i % columns + 0.5), kHolePitch * (i / columns + 0.5), -1}, gp::DZ(),
                           kHoleRadius, kThickness + 2));
  }
  BRepAlgoAPI_Cut cut;
  cut.SetArguments(plates);
  cut.SetTools(drills);
  cut.Build();
  // The rims are closed circles; the edges of the plate are not.
  const TopoDS_Shape rounded = fillet_edges(single_solid(cut.Shape()), kRim, [](const EdgeEnds& e) {
    const bool on_top_or_bottom = std::abs(e.middle.Z()) < 1e-9 || std::abs(e.middle.Z() - kThickness) < 1e-9;
    return on_top_or_bottom && e.begin.Distance(e.end) < 1e-9;
  });
  return {{"plate", Quantity_Color(0.70, 0.70, 0.62, Quantity_TOC_sRGB), single_solid(rounded), {}}};
}

}  // namespace tetloom::demo
