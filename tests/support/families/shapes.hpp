#pragma once
// What the families of CAD models are put together from. Everything throws std::runtime_error where OpenCASCADE fails.
#include <filesystem>
#include <gp_Ax2.hxx>
#include <gp_Pnt.hxx>
#include <string>
#include <TopoDS_Face.hxx>
#include <TopoDS_Shape.hxx>
#include <vector>

#include "tests/support/families/family.hpp"
#include "tests/support/families/random.hpp"

namespace tetloom::test {

struct Point2 {
  double x = 0, y = 0;
};

/// A simple polygon, counter-clockwise, pushed from z = 0 to `height`.
TopoDS_Shape prism(const std::vector<Point2>& polygon, double height);
double polygon_area(const std::vector<Point2>& polygon);

TopoDS_Shape block(const gp_Pnt& corner, double a, double b, double c);
TopoDS_Shape cylinder(const gp_Ax2& axis, double radius, double height);

TopoDS_Shape unite(const TopoDS_Shape& a, const TopoDS_Shape& b);
TopoDS_Shape cut(const TopoDS_Shape& from, const TopoDS_Shape& tool);
TopoDS_Shape compound(const std::vector<TopoDS_Shape>& shapes);
TopoDS_Shape moved(const TopoDS_Shape& shape, const Vec3& shift);
TopoDS_Shape turned(const TopoDS_Shape& shape, const gp_Ax1& axis, double angle);
std::vector<TopoDS_Shape> faces_of(const TopoDS_Shape& shape);
std::size_t solid_count(const TopoDS_Shape& shape);

/// A plate of 2 × 1 × (0.3 … 0.8) sizes with a hole and a boss.
TopoDS_Shape part_with_hole(Random& random, double size);

/// By quadrature, to eight digits and better where faces are analytic.
double volume_of(const TopoDS_Shape& shape);

/// Whether OpenCASCADE calls it valid and its volume is positive.
bool is_sound(const TopoDS_Shape& shape);

/// Writes `shape` as .brep, or as .step for one seed in four, and fills in the rest: the volume and the solids of the
/// shape, and whether it is sound.
FamilyModel write_family_model(const TopoDS_Shape& shape, const std::string& what, Random& random,
                               const std::filesystem::path& folder);

/// "gap 1.2e-05", for FamilyModel::what.
std::string labelled(const char* label, double value);

}  // namespace tetloom::test
