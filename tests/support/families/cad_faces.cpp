// Faces that nearly coincide, solids that overlap, shells that are not quite closed, and transformed parts.
#include <algorithm>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepBuilderAPI_GTransform.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepLib.hxx>
#include <cmath>
#include <gp_GTrsf.hxx>
#include <numbers>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Solid.hxx>

#include "tests/support/families/families.hpp"
#include "tests/support/families/shapes.hpp"

namespace tetloom::test {
namespace {

constexpr double kSize = 20;

/// Nothing, or any share of the size.
double random_gap(Random& random) { return random.chance(.15) ? 0 : kSize * random.log_uniform(1e-7, 1e-2); }

/// A block with another beside it.
TopoDS_Shape neighbours(double gap, Random& random) {
  const double a = random.uniform(.5, 1) * kSize, b = random.uniform(.5, 1) * kSize;
  const gp_Pnt corner(a + gap, random.uniform(-.3, .3) * b, random.uniform(-.3, .3) * b);
  return compound({block(gp_Pnt(0, 0, 0), a, b, b), block(corner, random.uniform(.3, 1) * a, b, .8 * b)});
}

TopoDS_Shape stack(double gap, Random& random) {
  std::vector<TopoDS_Shape> plates;
  double z = 0;
  for (int i = random.integer(2, 4); i > 0; --i) {
    const double thickness = random.uniform(.1, .4) * kSize;
    plates.push_back(block(gp_Pnt(0, 0, z), kSize, .8 * kSize, thickness));
    z += thickness + gap;
  }
  return compound(plates);
}

TopoDS_Shape pin_in_hole(double gap, Random& random) {
  const double radius = random.uniform(.1, .3) * kSize, height = random.uniform(.2, .6) * kSize;
  const gp_Dir up(0, 0, 1);
  const TopoDS_Shape plate = cut(block(gp_Pnt(-kSize / 2, -kSize / 2, 0), kSize, kSize, height),
                                 cylinder(gp_Ax2(gp_Pnt(0, 0, -1), up), radius + gap, height + 2));
  return compound({plate, cylinder(gp_Ax2(gp_Pnt(0, 0, -.2 * height), up), radius, 1.4 * height)});
}

/// A block with a cut of the gap's width; of none without one.
TopoDS_Shape slit_block(double gap, Random& random) {
  const double depth = random.uniform(.2, .8) * kSize, at = random.uniform(.3, .6) * kSize;
  std::vector<Point2> outline{{0, 0}, {kSize, 0}, {kSize, kSize}};
  if (gap > 1e-6)
    for (const Point2& point : {Point2{at + gap, kSize}, {at + gap, kSize - depth}, {at, kSize - depth}, {at, kSize}})
      outline.push_back(point);
  outline.push_back({0, kSize});
  return prism(outline, random.uniform(.3, 1) * kSize);
}

/// All faces of a shape, each moved by at most `gap`.
std::vector<TopoDS_Shape> loosened(const TopoDS_Shape& shape, double gap, Random& random) {
  std::vector<TopoDS_Shape> faces;
  for (const TopoDS_Shape& face : faces_of(shape)) {
    const TopoDS_Shape own = BRepBuilderAPI_Copy(face).Shape();
    faces.push_back(moved(own, random.uniform(0, .5) * gap * random.direction()));
  }
  return faces;
}

/// A solid of the faces, or their shells where they do not close.
TopoDS_Shape sewn(const std::vector<TopoDS_Shape>& faces, double tolerance) {
  BRepBuilderAPI_Sewing sewing(tolerance);
  for (const TopoDS_Shape& face : faces) sewing.Add(face);
  sewing.Perform();
  BRepBuilderAPI_MakeSolid solid;
  for (TopExp_Explorer shell(sewing.SewedShape(), TopAbs_SHELL); shell.More(); shell.Next())
    solid.Add(TopoDS::Shell(shell.Current()));
  if (!solid.IsDone() || sewing.NbFreeEdges() > 0) return sewing.SewedShape();
  TopoDS_Solid result = solid.Solid();
  BRepLib::OrientClosedSolid(result);
  return result;
}

gp_Trsf random_similarity(Random& random, double scale) {
  gp_Trsf mirror, turn, size;
  const auto axis = [&] {
    const Vec3 d = random.direction();
    return gp_Dir(d.x, d.y, d.z);
  };
  if (random.chance(.5)) mirror.SetMirror(gp_Ax2(gp_Pnt(1, 2, 3), axis()));
  turn.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), axis()), random.uniform(0, 6));
  size.SetScale(gp_Pnt(0, 0, 0), scale);
  return size * turn * mirror;
}

TopoDS_Shape stretched(const TopoDS_Shape& shape, const Vec3& factors) {
  gp_GTrsf stretch;
  for (int i = 0; i < 3; ++i) stretch.SetValue(i + 1, i + 1, factors[i]);
  return BRepBuilderAPI_GTransform(shape, stretch, true).Shape();
}

}  // namespace

FamilyModel make_gaps(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(4, seed);
  const double gap = random_gap(random);
  const int kind = random.integer(0, 3);
  const TopoDS_Shape shape = kind == 0   ? neighbours(gap, random)
                             : kind == 1 ? stack(gap, random)
                             : kind == 2 ? pin_in_hole(gap, random)
                                         : slit_block(gap, random);
  static constexpr const char* kKinds[] = {"neighbours, gap", "stack, gap", "pin in hole, gap", "slit of"};
  return write_family_model(shape, labelled(kKinds[kind], gap), random, folder);
}

FamilyModel make_overlaps(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(5, seed);
  const double gap = -kSize * random.log_uniform(1e-6, 1e-1);
  const int kind = random.integer(0, 2);
  const TopoDS_Shape shape = kind == 0   ? neighbours(gap, random)
                             : kind == 1 ? stack(gap, random)
                                         : pin_in_hole(gap, random);
  return write_family_model(shape, labelled("overlap", -gap), random, folder);
}

FamilyModel make_sewn(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(6, seed);
  const double share = random.log_uniform(1e-8, 1e-3);
  const TopoDS_Shape whole = random.chance(.5) ? block(gp_Pnt(0, 0, 0), kSize, random.uniform(.5, 2) * kSize, kSize)
                                               : cylinder(gp_Ax2(), kSize / 2, random.uniform(.5, 2) * kSize);
  const std::vector<TopoDS_Shape> faces = loosened(whole, share * kSize, random);
  const bool sew = random.chance(.7);
  const TopoDS_Shape shape = sew ? sewn(faces, 2 * share * kSize) : compound(faces);
  FamilyModel model =
      write_family_model(shape, labelled(sew ? "sewn over" : "loose by", share * kSize), random, folder);
  model.volume = volume_of(whole);
  model.solids = 1;
  // What was not sewn here closes only where it is within what a reader takes for equal.
  if (!sew) model.sound = share < 1e-7;
  return model;
}

FamilyModel make_transformed(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(7, seed);
  const TopoDS_Shape part = part_with_hole(random, kSize);
  const double volume = volume_of(part);
  if (random.chance(.4)) {
    const Vec3 factors{random.log_uniform(.2, 5), random.log_uniform(.2, 5), random.log_uniform(.2, 5)};
    const std::string what = labelled("stretched by", factors.x) + labelled(",", factors.y) + labelled(",", factors.z);
    FamilyModel model = write_family_model(stretched(part, factors), what, random, folder);
    model.volume = volume * factors.x * factors.y * factors.z;
    return model;
  }
  const double scale = random.log_uniform(1e-2, 1e4);
  const gp_Trsf similarity = random_similarity(random, scale);
  const std::string what = labelled(similarity.IsNegative() ? "mirrored, scaled by" : "scaled by", scale);
  FamilyModel model =
      write_family_model(BRepBuilderAPI_Transform(part, similarity, true).Shape(), what, random, folder);
  model.volume = volume * scale * scale * scale;
  return model;
}

}  // namespace tetloom::test
