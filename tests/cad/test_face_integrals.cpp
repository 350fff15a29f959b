// Areas and volumes by quadrature: against closed forms, and against OpenCASCADE's adaptive integration where there is
// none.
#include <array>
#include <BRep_Builder.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepGProp.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <catch2/catch.hpp>
#include <cmath>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <gp_Ax1.hxx>
#include <gp_Elips.hxx>
#include <gp_Pln.hxx>
#include <gp_Trsf.hxx>
#include <GProp_GProps.hxx>
#include <numbers>
#include <Precision.hxx>
#include <sstream>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>

#include "core/cad/detail/face_integrals.hpp"
#include "core/cad/detail/gauss_rule.hpp"

using namespace tetloom;
using namespace tetloom::cad;

namespace {

constexpr double kPi = std::numbers::pi;

double area_of(const TopoDS_Shape& shape) {
  double area = 0;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
    area += integrate_face(TopoDS::Face(face.Current())).area;
  return area;
}

double volume_of(const TopoDS_Shape& shape) {
  KnownIntegrals known;
  return enclosed_volume(shape, known, serial_loop());
}

TopoDS_Wire ellipse(double x_radius, double y_radius, double z) {
  const gp_Elips curve(gp_Ax2(gp_Pnt(0, 0, z), gp_Dir(0, 0, 1)), x_radius, y_radius);
  return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve).Edge()).Wire();
}

/// A skin through ellipses: spline faces of many spans.
TopoDS_Shape loft() {
  BRepOffsetAPI_ThruSections sections(true);
  for (const std::array<double, 3> e : {std::array{5., 3., 0.}, {6., 2., 4.}, {4., 4 - 1e-3, 9.}, {7., 5., 12.}})
    sections.AddWire(ellipse(e[0], e[1], e[2]));
  return sections.Shape();
}

}  // namespace

TEST_CASE("Gauss rules are exact up to twice their points, less one") {
  for (int count = 1; count <= kMostGaussNodes; ++count) {
    for (int power = 0; power <= 2 * count; ++power) {
      double sum = 0;
      for (const GaussNode& node : gauss_rule(count)) sum += node.weight * std::pow(node.x, power);
      const double exact = power % 2 == 0 ? 2.0 / (power + 1) : 0;
      INFO(count << " points, power " << power);
      if (power < 2 * count)
        CHECK(sum == Approx(exact).margin(1e-13));
      else
        CHECK(std::abs(sum - exact) > 1e-11);
    }
  }
}

TEST_CASE("solids of elementary faces have their areas and volumes in closed form") {
  struct Case {
    const char* name;
    TopoDS_Shape shape;
    double area, volume;
  };
  const double slant = std::hypot(10.0, 3.0);
  const Case cases[] = {
      {"box", BRepPrimAPI_MakeBox(10, 20, 30).Shape(), 2200, 6000},
      {"cylinder", BRepPrimAPI_MakeCylinder(5, 10).Shape(), 150 * kPi, 250 * kPi},
      {"sphere", BRepPrimAPI_MakeSphere(5).Shape(), 100 * kPi, 500 * kPi / 3},
      {"torus", BRepPrimAPI_MakeTorus(10, 3).Shape(), 120 * kPi * kPi, 180 * kPi * kPi},
      {"cone", BRepPrimAPI_MakeCone(5, 2, 10).Shape(), kPi * (25 + 4 + 7 * slant), kPi * 10 * (25 + 10 + 4) / 3},
      {"quarter of a torus", BRepPrimAPI_MakeTorus(10, 3, kPi / 2).Shape(), 30 * kPi * kPi + 18 * kPi, 45 * kPi * kPi},
  };
  for (const Case& c : cases) {
    INFO(c.name);
    CHECK(area_of(c.shape) == Approx(c.area).epsilon(1e-9));
    CHECK(volume_of(c.shape) == Approx(c.volume).epsilon(1e-9));
  }
}

TEST_CASE("as rational splines, and read from a file, the same solids have the same areas and volumes") {
  for (const TopoDS_Shape& shape : {BRepPrimAPI_MakeCylinder(5, 10).Shape(), BRepPrimAPI_MakeSphere(5).Shape(),
                                    BRepPrimAPI_MakeTorus(10, 3).Shape(), BRepPrimAPI_MakeCone(5, 2, 10).Shape()}) {
    const TopoDS_Shape splines = BRepBuilderAPI_NurbsConvert(shape, true).Shape();
    CHECK(area_of(splines) == Approx(area_of(shape)).epsilon(1e-6));
    CHECK(volume_of(splines) == Approx(volume_of(shape)).epsilon(1e-6));
    std::stringstream file;
    BRepTools::Write(splines, file);
    TopoDS_Shape read;
    BRepTools::Read(read, file, BRep_Builder());
    CHECK(volume_of(read) == Approx(volume_of(shape)).epsilon(1e-6));
  }
}

TEST_CASE("extruded and turned ellipses have their volumes in closed form") {
  const TopoDS_Face disc = BRepBuilderAPI_MakeFace(ellipse(5, 3, 0)).Face();
  const TopoDS_Shape prism = BRepPrimAPI_MakePrism(disc, gp_Vec(1, 2, 7)).Shape();
  CHECK(volume_of(prism) == Approx(15 * kPi * 7).epsilon(1e-9));
  const TopoDS_Shape ring = BRepPrimAPI_MakeRevol(disc, gp_Ax1(gp_Pnt(11, 0, 0), gp_Dir(0, 1, 0))).Shape();
  CHECK(std::abs(volume_of(ring)) == Approx(15 * kPi * 2 * kPi * 11).epsilon(1e-9));
}

TEST_CASE("holes through curved walls count") {
  // Two cylinders across: the drilled one loses Steinmetz's integral, here against OpenCASCADE's adaptive one.
  const TopoDS_Shape across = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(-9, 1, 5), gp_Dir(1, 0, 0)), 2, 18).Shape();
  const TopoDS_Shape drilled = BRepAlgoAPI_Cut(BRepPrimAPI_MakeCylinder(5, 10).Shape(), across).Shape();
  GProp_GProps reference;
  BRepGProp::VolumeProperties(drilled, reference, 1e-8);
  CHECK(volume_of(drilled) == Approx(reference.Mass()).epsilon(1e-6));
  CHECK(volume_of(drilled) < 250 * kPi - 100);
}

TEST_CASE("a skin of splines agrees with OpenCASCADE's adaptive integration") {
  const TopoDS_Shape shape = loft();
  GProp_GProps reference;
  BRepGProp::VolumeProperties(shape, reference, 1e-9);
  CHECK(volume_of(shape) == Approx(reference.Mass()).epsilon(1e-7));
}

TEST_CASE("a volume depends neither on the place nor, but for the sign, on the side of its faces") {
  const TopoDS_Shape shape = loft();
  const double volume = volume_of(shape);
  gp_Trsf far;
  far.SetTranslation(gp_Vec(1e6, -2e6, 3e6));
  CHECK(volume_of(BRepBuilderAPI_Transform(shape, far, true).Shape()) == Approx(volume).epsilon(1e-8));
  CHECK(volume_of(shape.Moved(TopLoc_Location(far))) == Approx(volume).epsilon(1e-8));
  CHECK(volume_of(shape.Reversed()) == Approx(-volume).epsilon(1e-12));
}

TEST_CASE("instances of one part are integrated once, each where it lies") {
  const TopoDS_Shape part = loft();
  gp_Trsf turn, place;
  turn.SetRotation(gp_Ax1(gp_Pnt(1, 2, 3), gp_Dir(1, 1, 1)), 0.7);
  place.SetTranslation(gp_Vec(100, -20, 3));
  KnownIntegrals known;
  const double volume = enclosed_volume(part, known, serial_loop());
  const int faces = known.Extent();
  const TopoDS_Shape copy = part.Moved(TopLoc_Location(place * turn));
  CHECK(enclosed_volume(copy, known, serial_loop()) == Approx(volume).epsilon(1e-10));
  CHECK(known.Extent() == faces);
  for (TopExp_Explorer at(copy, TopAbs_FACE); at.More(); at.Next()) {
    const TopoDS_Face face = TopoDS::Face(at.Current());
    const FaceIntegrals direct = integrate_face(face), found = find_integrals(known, face).value();
    CHECK(found.area == Approx(direct.area).epsilon(1e-9));
    CHECK(distance(found.origin, direct.origin) < 1e-9);
    CHECK(distance(found.area_vector, direct.area_vector) < 1e-9 * direct.area);
    CHECK(found.moment == Approx(direct.moment).epsilon(1e-8).margin(1e-8));
  }
}

TEST_CASE("a loop that runs the wrong way counts negative") {
  BRepBuilderAPI_MakePolygon square;
  for (const gp_Pnt& p : {gp_Pnt(0, 0, 0), gp_Pnt(2, 0, 0), gp_Pnt(2, 2, 0), gp_Pnt(0, 2, 0)}) square.Add(p);
  square.Close();
  const gp_Pln plane(gp_Ax3(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)));
  CHECK(integrate_face(BRepBuilderAPI_MakeFace(plane, square.Wire(), true).Face()).area == Approx(4));
  TopoDS_Face face;
  BRep_Builder builder;
  builder.MakeFace(face, new Geom_Plane(plane), Precision::Confusion());
  builder.Add(face, square.Wire().Reversed());
  CHECK(integrate_face(face).area == Approx(-4));
}

TEST_CASE("a face without any wire covers its surface") {
  TopoDS_Face face;
  BRep_Builder builder;
  builder.MakeFace(face, new Geom_SphericalSurface(gp_Ax3(), 5), Precision::Confusion());
  CHECK(integrate_face(face).area == Approx(100 * kPi).epsilon(1e-9));
  builder.MakeFace(face, new Geom_Plane(gp_Ax3()), Precision::Confusion());  // endless: nothing to count
  CHECK(integrate_face(face).area == 0);
}
