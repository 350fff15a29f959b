// Threads, gears, thin tubes and assemblies.
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepLib.hxx>
#include <BRepOffsetAPI_MakePipe.hxx>
#include <BRepOffsetAPI_MakePipeShell.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <cmath>
#include <GC_MakeArcOfCircle.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2d_TrimmedCurve.hxx>
#include <Geom_CylindricalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <gp_Circ.hxx>
#include <numbers>
#include <stdexcept>
#include <TopoDS.hxx>
#include <TopoDS_Wire.hxx>

#include "tests/support/families/families.hpp"
#include "tests/support/families/shapes.hpp"

namespace tetloom::test {
namespace {

constexpr double kPi = std::numbers::pi;

gp_Ax2 upright(double x, double y, double z) { return gp_Ax2(gp_Pnt(x, y, z), gp_Dir(0, 0, 1)); }

/// A helix about z from (radius, 0, 0) on.
TopoDS_Wire helix(double radius, double pitch, double turns) {
  const Handle(Geom_Surface) around = new Geom_CylindricalSurface(gp_Ax3(gp::XOY()), radius);
  const double angle = 2 * kPi * turns, rise = pitch * turns, length = std::hypot(angle, rise);
  const Handle(Geom2d_Curve) line = new Geom2d_Line(gp_Pnt2d(0, 0), gp_Dir2d(angle, rise));
  const TopoDS_Edge edge = BRepBuilderAPI_MakeEdge(line, around, 0, length).Edge();
  BRepLib::BuildCurves3d(edge);
  return BRepBuilderAPI_MakeWire(edge).Wire();
}

/// A thread's section at (radius, 0, 0): a triangle with its tip cut off, pointing outwards.
TopoDS_Wire thread_section(double radius, double pitch) {
  const double half = .4 * pitch, depth = .5 * pitch, tip = .1 * pitch;
  BRepBuilderAPI_MakePolygon section;
  for (const auto& [x, z] : {std::pair{-.1 * pitch, -half}, {depth, -tip}, {depth, tip}, {-.1 * pitch, half}})
    section.Add(gp_Pnt(radius + x, 0, z));
  section.Close();
  return section.Wire();
}

TopoDS_Wire round_section(double radius, double wire_radius) {
  const gp_Circ circle(gp_Ax2(gp_Pnt(radius, 0, 0), gp_Dir(0, 1, 0)), wire_radius);
  return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire();
}

TopoDS_Shape swept(const TopoDS_Wire& spine, const TopoDS_Wire& section) {
  BRepOffsetAPI_MakePipeShell pipe(spine);
  pipe.SetMode(gp_Dir(0, 0, 1));
  pipe.Add(section);
  pipe.Build();
  if (!pipe.IsDone() || !pipe.MakeSolid()) throw std::runtime_error("a sweep failed");
  return pipe.Shape();
}

TopoDS_Edge line(const gp_Pnt& a, const gp_Pnt& b) { return BRepBuilderAPI_MakeEdge(a, b).Edge(); }

TopoDS_Edge arc(const gp_Pnt& a, const gp_Pnt& middle, const gp_Pnt& b) {
  const Handle(Geom_TrimmedCurve) curve = GC_MakeArcOfCircle(a, middle, b).Value();
  return BRepBuilderAPI_MakeEdge(curve).Edge();
}

gp_Pnt polar(double radius, double angle) { return {radius * std::cos(angle), radius * std::sin(angle), 0}; }

/// Root and tip arcs with straight flanks between them.
TopoDS_Wire gear_outline(int teeth, double root, double tip) {
  BRepBuilderAPI_MakeWire wire;
  const double step = 2 * kPi / teeth;
  for (int i = 0; i < teeth; ++i) {
    const double start = i * step, up = start + .4 * step, top = start + .5 * step, down = start + .8 * step,
                 end = (i + 1) * step;
    wire.Add(arc(polar(root, start), polar(root, start + .2 * step), polar(root, up)));
    wire.Add(line(polar(root, up), polar(tip, top)));
    wire.Add(arc(polar(tip, top), polar(tip, (top + down) / 2), polar(tip, down)));
    wire.Add(line(polar(tip, down), polar(root, end)));
  }
  if (!wire.IsDone()) throw std::runtime_error("a gear's outline does not close");
  return wire.Wire();
}

TopoDS_Shape gear(int teeth, double module, double width, double bore) {
  const double pitch = module * teeth / 2;
  const BRepBuilderAPI_MakeFace face(gear_outline(teeth, pitch - 1.25 * module, pitch + module), true);
  const TopoDS_Shape body = BRepPrimAPI_MakePrism(face.Face(), gp_Vec(0, 0, width)).Shape();
  return bore > 0 ? cut(body, cylinder(upright(0, 0, -1), bore, width + 2)) : body;
}

struct Tube {
  double radius = 0, wall = 0, straight = 0, bend = 0, angle = 0;  ///< bend: the radius of the middle line's arc

  /// Pappus: a bend's centroid runs along its middle line.
  double volume() const {
    const double inner = radius - wall;
    return kPi * (radius * radius - inner * inner) * (2 * straight + bend * angle);
  }
};

TopoDS_Wire bent_spine(const Tube& tube) {
  const gp_Pnt start(0, 0, 0), first(0, 0, tube.straight), centre(tube.bend, 0, tube.straight);
  const auto on_arc = [&](double angle) {
    return gp_Pnt(centre.X() - tube.bend * std::cos(angle), 0, centre.Z() + tube.bend * std::sin(angle));
  };
  const gp_Pnt second = on_arc(tube.angle);
  const gp_Pnt end(second.X() + tube.straight * std::sin(tube.angle), 0,
                   second.Z() + tube.straight * std::cos(tube.angle));
  BRepBuilderAPI_MakeWire wire;
  wire.Add(line(start, first));
  wire.Add(arc(first, on_arc(tube.angle / 2), second));
  wire.Add(line(second, end));
  return wire.Wire();
}

TopoDS_Shape bent_tube(const Tube& tube) {
  const TopoDS_Wire spine = bent_spine(tube);
  const auto disc = [&](double radius) {
    const gp_Circ circle(upright(0, 0, 0), radius);
    return BRepBuilderAPI_MakeFace(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(circle).Edge()).Wire()).Face();
  };
  const TopoDS_Shape section = cut(disc(tube.radius), disc(tube.radius - tube.wall));
  return BRepOffsetAPI_MakePipe(spine, faces_of(section).at(0)).Shape();
}

/// One part of an assembly, within [0, 10]³.
TopoDS_Shape assembly_part(int kind) {
  switch (kind) {
    case 0: return block(gp_Pnt(0, 0, 0), 10, 10, 10);
    case 1: return cut(block(gp_Pnt(0, 0, 0), 10, 10, 10), cylinder(upright(5, 5, -1), 3, 12));
    case 2: return cylinder(upright(5, 5, 0), 5, 10);
    default: return unite(block(gp_Pnt(0, 0, 0), 10, 10, 4), cylinder(upright(5, 5, 2), 3, 8));
  }
}

/// A long bar with round grooves along the middles of its sides and round edges, all of one length.
struct Profile {
  double width = 0, length = 0;
  double groove = 0, edge = 0;  ///< radii

  double volume() const {
    return length * (width * width - 2 * kPi * groove * groove - (4 - kPi) * edge * edge);
  }
};

TopoDS_Shape grooved_bar(const Profile& profile) {
  const double w = profile.width, l = profile.length;
  TopoDS_Shape bar = unite(block(gp_Pnt(profile.edge, 0, 0), w - 2 * profile.edge, w, l),
                           block(gp_Pnt(0, profile.edge, 0), w, w - 2 * profile.edge, l));
  for (const double x : {profile.edge, w - profile.edge})
    for (const double y : {profile.edge, w - profile.edge})
      bar = unite(bar, cylinder(upright(x, y, 0), profile.edge, l));
  for (const auto& [x, y] : {std::pair{w / 2, 0.}, {w / 2, w}, {0., w / 2}, {w, w / 2}})
    bar = cut(bar, cylinder(upright(x, y, -1), profile.groove, l + 2));
  return bar;
}

}  // namespace

FamilyModel make_threads(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(8, seed);
  const double radius = random.uniform(4, 10), turns = random.uniform(.6, scale == FamilyScale::Full ? 8 : 2.5);
  const double pitch = radius * random.uniform(.2, .6);
  const TopoDS_Wire spine = helix(radius, pitch, turns);
  const std::string what = labelled("pitch", pitch) + labelled(", turns", turns);
  if (random.chance(.4))
    return write_family_model(swept(spine, round_section(radius, .35 * pitch)), "coil, " + what, random, folder);
  const TopoDS_Shape thread = swept(spine, thread_section(radius, pitch));
  if (random.chance(.5)) return write_family_model(thread, "thread alone, " + what, random, folder);
  const TopoDS_Shape core = cylinder(upright(0, 0, -pitch), radius, pitch * (turns + 2));
  return write_family_model(unite(core, thread), "screw, " + what, random, folder);
}

FamilyModel make_gears(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(9, seed);
  const int teeth = random.integer(6, scale == FamilyScale::Full ? 80 : 16);
  const double module = random.log_uniform(.5, 5), width = module * random.uniform(1, 10);
  const double bore = random.chance(.7) ? module * teeth * random.uniform(.05, .3) : 0;
  const std::string what = std::to_string(teeth) + " teeth" + labelled(", width", width) + labelled(", bore", bore);
  FamilyModel model = write_family_model(gear(teeth, module, width, bore), what, random, folder);
  model.relative_size = .05;
  return model;
}

FamilyModel make_tubes(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(10, seed);
  const double thinnest = scale == FamilyScale::Full ? .02 : .1, longest = scale == FamilyScale::Full ? 60 : 8;
  Tube tube{.radius = random.log_uniform(.5, 5)};
  tube.wall = tube.radius * random.log_uniform(thinnest, .6);
  tube.straight = tube.radius * random.log_uniform(1, longest);
  tube.bend = tube.radius * random.uniform(1.5, 5);
  tube.angle = random.uniform(.2, 1.6);
  const std::string what = labelled("radius", tube.radius) + labelled(", wall", tube.wall) +
                           labelled(", straight", tube.straight) + labelled(", bend", tube.bend);
  FamilyModel model = write_family_model(bent_tube(tube), what, random, folder);
  model.volume = tube.volume();
  return model;
}

FamilyModel make_profiles(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(18, seed);
  Profile profile{.width = random.log_uniform(1, 20)};
  profile.length = profile.width * random.log_uniform(5, scale == FamilyScale::Full ? 100 : 20);
  profile.groove = profile.width * random.uniform(.15, .35);
  profile.edge = profile.width * random.log_uniform(.01, .1);
  const std::string what = labelled("width", profile.width) + labelled(", length", profile.length) +
                           labelled(", grooves", profile.groove) + labelled(", edges", profile.edge);
  FamilyModel model = write_family_model(grooved_bar(profile), what, random, folder);
  model.volume = profile.volume();
  model.volume_tolerance = .02;  // beside deep grooves: the rule counts the volume of the grooves
  return model;
}

FamilyModel make_assemblies(std::uint64_t seed, FamilyScale scale, const std::filesystem::path& folder) {
  Random random(11, seed);
  const int most = scale == FamilyScale::Full ? 500 : 12;
  const int parts = static_cast<int>(random.log_uniform(3, most)), side = static_cast<int>(std::ceil(std::cbrt(parts)));
  const double gap = random.chance(.2) ? 0 : random.log_uniform(1e-6, 3);
  std::vector<TopoDS_Shape> kinds, placed;
  for (int kind = 0; kind < 4; ++kind) kinds.push_back(assembly_part(kind));
  for (int i = 0; i < parts; ++i) {
    const Vec3 cell{static_cast<double>(i % side), static_cast<double>(i / side % side),
                    static_cast<double>(i / side / side)};
    placed.push_back(moved(kinds[static_cast<std::size_t>(random.integer(0, 3))], (10 + gap) * cell));
  }
  const std::string what = std::to_string(parts) + " parts" + labelled(", gap", gap);
  FamilyModel model = write_family_model(compound(placed), what, random, folder);
  model.relative_size = .2 / side;
  return model;
}

}  // namespace tetloom::test
