// Small features of solids: fillets, steps, chamfers and what Boolean operations leave.
#include <algorithm>
#include <BRepFilletAPI_MakeFillet.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <cmath>
#include <gp_Ax1.hxx>
#include <numbers>
#include <stdexcept>
#include <TopExp.hxx>
#include <TopoDS.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include "tests/support/families/families.hpp"
#include "tests/support/families/shapes.hpp"

namespace tetloom::test {
namespace {

struct Box {
  double a = 0, b = 0, c = 0;
  double least() const { return std::min({a, b, c}); }
  TopoDS_Shape shape() const { return block(gp_Pnt(0, 0, 0), a, b, c); }
};

Box random_box(Random& random) { return {random.uniform(10, 30), random.uniform(10, 30), random.uniform(10, 30)}; }

/// Rounds the edges whose numbers `wanted` picks.
TopoDS_Shape rounded(const TopoDS_Shape& shape, double radius, const std::vector<bool>& wanted) {
  TopTools_IndexedMapOfShape edges;
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  BRepFilletAPI_MakeFillet fillet(shape);
  for (int i = 1; i <= edges.Extent(); ++i)
    if (wanted[static_cast<std::size_t>(i - 1) % wanted.size()]) fillet.Add(radius, TopoDS::Edge(edges(i)));
  fillet.Build();
  if (!fillet.IsDone()) throw std::runtime_error("a fillet cannot be made");
  return fillet.Shape();
}

/// Some edges of a block, or all of them.
std::vector<bool> random_edges(Random& random) {
  std::vector<bool> wanted(12, random.chance(.3));
  for (std::size_t i = 0; i < wanted.size(); ++i) wanted[i] = wanted[i] || random.chance(.3);
  wanted[0] = true;
  return wanted;
}

/// The corners of a block's outline, each as it is, cut off or with a step, of any depth.
std::vector<Point2> stepped_outline(Random& random, double a, double b, std::string& what) {
  const Point2 corners[] = {{0, 0}, {a, 0}, {a, b}, {0, b}};
  std::vector<Point2> outline;
  for (std::size_t i = 0; i < 4; ++i) {
    const Point2 &at = corners[i], &from = corners[(i + 3) % 4], &to = corners[(i + 1) % 4];
    const auto toward = [&](const Point2& end, double length) {
      const double whole = std::hypot(end.x - at.x, end.y - at.y);
      return Point2{(end.x - at.x) * length / whole, (end.y - at.y) * length / whole};
    };
    const int kind = random.integer(0, 2);
    const Point2 back = toward(from, random.log_uniform(2e-6, 4)), ahead = toward(to, random.log_uniform(2e-6, 4));
    if (kind == 0) outline.push_back(at);
    if (kind > 0) outline.push_back({at.x + back.x, at.y + back.y});
    if (kind == 2) outline.push_back({at.x + back.x + ahead.x, at.y + back.y + ahead.y});
    if (kind > 0) outline.push_back({at.x + ahead.x, at.y + ahead.y});
    if (kind > 0)
      what += (kind == 1 ? " chamfer" : " step") + labelled("", std::hypot(back.x, back.y)) +
              labelled(" x", std::hypot(ahead.x, ahead.y));
  }
  return outline;
}

/// A lid turned by almost nothing lies on a block.
TopoDS_Shape tilted_lid(const Box& box, double angle, Random& random) {
  const TopoDS_Shape lid = block(gp_Pnt(.3 * box.a, -.2 * box.b, .4 * box.c), box.a, .9 * box.b, .6 * box.c);
  const gp_Ax1 axis(gp_Pnt(random.uniform(0, box.a), 0, box.c), gp_Dir(0, 1, 0));
  return unite(box.shape(), turned(lid, axis, angle));
}

/// A hole or a boss whose side almost touches a side of a block.
TopoDS_Shape tangent_cylinder(const Box& box, double offset, bool boss) {
  const double radius = .3 * box.least();
  const gp_Ax2 axis(gp_Pnt(radius + offset, box.b / 2, boss ? box.c / 2 : -1), gp_Dir(0, 0, 1));
  const TopoDS_Shape tool = cylinder(axis, radius, boss ? box.c : box.c + 2);
  return boss ? unite(box.shape(), tool) : cut(box.shape(), tool);
}

/// Two pipes of almost the same radius that cross.
TopoDS_Shape crossing_cylinders(const Box& box, double difference) {
  const double radius = .25 * box.least(), length = box.a;
  const TopoDS_Shape along = cylinder(gp_Ax2(gp_Pnt(-length, 0, 0), gp_Dir(1, 0, 0)), radius, 2 * length);
  const TopoDS_Shape across =
      cylinder(gp_Ax2(gp_Pnt(0, -length, 0), gp_Dir(0, 1, 0)), radius * (1 - difference), 2 * length);
  return unite(along, across);
}

}  // namespace

FamilyModel make_fillets(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(1, seed);
  const Box box = random_box(random);
  const std::vector<bool> wanted = random_edges(random);
  const double share = random.log_uniform(1e-6, .2);
  // Some radii are too small for OpenCASCADE.
  for (double radius = share * box.least(); radius < .3 * box.least(); radius *= 4) {
    try {
      const TopoDS_Shape shape = rounded(box.shape(), radius, wanted);
      if (is_sound(shape)) {
        FamilyModel model = write_family_model(shape, labelled("radius", radius), random, folder);
        // What is that small does not reach the mesh, and makes no sizes either.
        if (radius < 1e-4 * box.least()) model.most_tets = 60'000;
        return model;
      }
    } catch (const Standard_Failure&) {
    } catch (const std::runtime_error&) {}
  }
  throw std::runtime_error("no fillet can be made");
}

FamilyModel make_steps(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(2, seed);
  const Box box = random_box(random);
  std::string what;
  const std::vector<Point2> outline = stepped_outline(random, box.a, box.b, what);
  FamilyModel model = write_family_model(prism(outline, box.c), what, random, folder);
  model.volume = polygon_area(outline) * box.c;
  model.sound = true;
  return model;
}

FamilyModel make_slivers(std::uint64_t seed, FamilyScale, const std::filesystem::path& folder) {
  Random random(3, seed);
  const Box box = random_box(random);
  const double small = random.log_uniform(1e-6, 3e-2), length = small * box.least() * (random.chance(.5) ? 1 : -1);
  switch (random.integer(0, 3)) {
    case 0: return write_family_model(tilted_lid(box, small, random), labelled("lid tilted by", small), random, folder);
    case 1:
      return write_family_model(tangent_cylinder(box, length, false), labelled("hole off a side by", length), random,
                                folder);
    case 2:
      return write_family_model(tangent_cylinder(box, length, true), labelled("boss off a side by", length), random,
                                folder);
    default:
      return write_family_model(crossing_cylinders(box, small), labelled("pipes whose radii differ by", small), random,
                                folder);
  }
}

}  // namespace tetloom::test
