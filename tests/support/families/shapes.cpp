#include "tests/support/families/shapes.hpp"

#include <BRep_Builder.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepTools.hxx>
#include <cstdio>
#include <gp_Ax1.hxx>
#include <gp_Trsf.hxx>
#include <GProp_GProps.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <stdexcept>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Wire.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

namespace tetloom::test {
namespace {

/// OpenCASCADE's writers report on standard output.
class Silence {
 public:
  Silence() : printers_(::Message::DefaultMessenger()->Printers()) {
    ::Message::DefaultMessenger()->ChangePrinters().Clear();
  }
  ~Silence() { ::Message::DefaultMessenger()->ChangePrinters() = printers_; }
  Silence(const Silence&) = delete;
  Silence& operator=(const Silence&) = delete;

 private:
  Message_SequenceOfPrinters printers_;
};

void write_shape(const TopoDS_Shape& shape, const std::filesystem::path& path) {
  const Silence silence;
  if (path.extension() == ".brep") {
    if (BRepTools::Write(shape, path.c_str())) return;
  } else {
    STEPControl_Controller::Init();
    STEPControl_Writer writer;
    if (writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone && writer.Write(path.c_str()) == IFSelect_RetDone)
      return;
  }
  throw std::runtime_error("cannot write " + path.string());
}

template <class Operation>
TopoDS_Shape result_of(Operation&& operation) {
  if (!operation.IsDone()) throw std::runtime_error("a Boolean operation failed");
  return operation.Shape();
}

}  // namespace

TopoDS_Shape prism(const std::vector<Point2>& polygon, double height) {
  BRepBuilderAPI_MakePolygon outline;
  for (const Point2& point : polygon) outline.Add(gp_Pnt(point.x, point.y, 0));
  outline.Close();
  if (!outline.IsDone()) throw std::runtime_error("a polygon cannot be made");
  const BRepBuilderAPI_MakeFace face(outline.Wire(), true);
  if (!face.IsDone()) throw std::runtime_error("a face cannot be made of a polygon");
  return BRepPrimAPI_MakePrism(face.Face(), gp_Vec(0, 0, height)).Shape();
}

double polygon_area(const std::vector<Point2>& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Point2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return twice / 2;
}

TopoDS_Shape block(const gp_Pnt& corner, double a, double b, double c) {
  return BRepPrimAPI_MakeBox(corner, a, b, c).Shape();
}

TopoDS_Shape cylinder(const gp_Ax2& axis, double radius, double height) {
  return BRepPrimAPI_MakeCylinder(axis, radius, height).Shape();
}

TopoDS_Shape unite(const TopoDS_Shape& a, const TopoDS_Shape& b) { return result_of(BRepAlgoAPI_Fuse(a, b)); }

TopoDS_Shape cut(const TopoDS_Shape& from, const TopoDS_Shape& tool) { return result_of(BRepAlgoAPI_Cut(from, tool)); }

TopoDS_Shape compound(const std::vector<TopoDS_Shape>& shapes) {
  TopoDS_Compound result;
  const BRep_Builder builder;
  builder.MakeCompound(result);
  for (const TopoDS_Shape& shape : shapes) builder.Add(result, shape);
  return result;
}

TopoDS_Shape moved(const TopoDS_Shape& shape, const Vec3& shift) {
  gp_Trsf move;
  move.SetTranslation(gp_Vec(shift.x, shift.y, shift.z));
  return shape.Moved(TopLoc_Location(move));
}

TopoDS_Shape turned(const TopoDS_Shape& shape, const gp_Ax1& axis, double angle) {
  gp_Trsf turn;
  turn.SetRotation(axis, angle);
  return shape.Moved(TopLoc_Location(turn));
}

std::vector<TopoDS_Shape> faces_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> faces;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) faces.push_back(face.Current());
  return faces;
}

std::size_t solid_count(const TopoDS_Shape& shape) {
  std::size_t count = 0;
  for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next()) ++count;
  return count;
}

TopoDS_Shape part_with_hole(Random& random, double size) {
  const double radius = random.uniform(.1, .25) * size, height = random.uniform(.3, .8) * size;
  const auto axis = [&](double x, double z) { return gp_Ax2(gp_Pnt(x, .5 * size, z), gp_Dir(0, 0, 1)); };
  const TopoDS_Shape plate = block(gp_Pnt(0, 0, 0), 2 * size, size, height);
  const TopoDS_Shape holed = cut(plate, cylinder(axis(.5 * size, -1), radius, height + 2));
  return unite(holed, cylinder(axis(1.4 * size, .5 * height), 1.2 * radius, height));
}

double volume_of(const TopoDS_Shape& shape) {
  GProp_GProps properties;
  BRepGProp::VolumeProperties(shape, properties, 1e-8);
  return properties.Mass();
}

bool is_sound(const TopoDS_Shape& shape) {
  return solid_count(shape) > 0 && BRepCheck_Analyzer(shape).IsValid() && volume_of(shape) > 0;
}

FamilyModel write_family_model(const TopoDS_Shape& shape, const std::string& what, Random& random,
                               const std::filesystem::path& folder) {
  FamilyModel model;
  model.file = folder / (random.chance(.25) ? "model.step" : "model.brep");
  model.what = what;
  model.volume = volume_of(shape);
  model.solids = solid_count(shape);
  model.sound = is_sound(shape);
  write_shape(shape, model.file);
  return model;
}

std::string labelled(const char* label, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), "%s %.3g", label, value);
  return text;
}

}  // namespace tetloom::test
