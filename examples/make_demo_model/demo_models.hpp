#pragma once
// CAD models made from nothing but numbers: for the quick start, the tests and the benches. Lengths are millimetres.
#include <string>
#include <vector>

#include <Quantity_Color.hxx>
#include <TopoDS_Shape.hxx>

namespace tetloom::demo {

/// A shape with what a CAD system would say of it.
struct DemoPart {
  std::string name;
  Quantity_Color color;
  TopoDS_Shape shape;
  /// Faces with a name or colour of their own.
  struct NamedFace {
    std::string name;
    Quantity_Color color;
    TopoDS_Shape face;
  };
  std::vector<NamedFace> faces;
};

/// A bracket: base plate with a pocket and bolt holes, an upright boss with a cross hole through its curved face,
/// fillets between them, and a top face that is a B-spline surface. About 120 x 80 x 60.
std::vector<DemoPart> make_machined_part();

/// A steel body with a flange, and the rubber seal around its stem: two solids that touch on a cylinder and on an
/// annulus but share no face until `--imprint` fuses them. About 80 x 80 x 52.
std::vector<DemoPart> make_assembly();

/// A plate with `holes` holes whose rims are rounded, and rounded outer edges; more holes, more faces.
/// 10 + 3 faces per hole. Throws std::runtime_error unless 1 <= holes <= 400.
std::vector<DemoPart> make_holed_plate(int holes);

/// A solid whose faces are all B-spline surfaces: `sides` wavy patches around and `levels` of them above each other,
/// and one patch at each end. With 5 and 4: 22 faces. About 100 x 100 x 120.
/// Throws std::runtime_error unless 3 <= sides <= 100 and 1 <= levels <= 100.
std::vector<DemoPart> make_spline_body(int sides, int levels);

/// A ball about the origin, of one face. Throws std::runtime_error unless 1 <= radius <= 10000.
std::vector<DemoPart> make_ball(int radius);

/// An eighth of a hollow ball about the origin, where x, y and z are positive. Its faces are called inner, outer, x=0,
/// y=0 and z=0. Throws std::runtime_error unless 1 <= inner < outer <= 10000.
std::vector<DemoPart> make_hollow_sphere(int inner, int outer);

/// The space inside a pipe along z with `branches` pipes along x, whose ends are called inlet, and outlet 1, outlet 2
/// …; with no branches the other end of the pipe is called outlet. Throws std::runtime_error unless 0 <= branches
/// <= 50.
std::vector<DemoPart> make_manifold(int branches);

/// Throws std::runtime_error unless every shape passes BRepCheck_Analyzer and has a positive volume.
void check_parts(const std::vector<DemoPart>& parts);

/// Writes AP214 with names and colours, the same bytes every time. Throws std::runtime_error.
void write_step(const std::vector<DemoPart>& parts, const std::string& path);

}  // namespace tetloom::demo
