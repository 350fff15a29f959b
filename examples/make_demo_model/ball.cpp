// A ball, for the benches: one face with a seam and two poles.
#include <BRepPrimAPI_MakeSphere.hxx>
#include <stdexcept>

#include "examples/make_demo_model/demo_models.hpp"
#include "examples/make_demo_model/shape_tools.hpp"

namespace tetloom::demo {

std::vector<DemoPart> make_ball(int radius) {
  if (radius < 1 || radius > 10000) throw std::runtime_error("a ball has a radius from 1 to 10000");
  const TopoDS_Shape ball = BRepPrimAPI_MakeSphere(static_cast<double>(radius)).Shape();
  return {{"ball", Quantity_Color(0.55, 0.65, 0.80, Quantity_TOC_sRGB), single_solid(ball), {}}};
}

}  // namespace tetloom::demo
