#include "tests/cad/cad_samples.hpp"

#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BRepAlgoAPI_BuilderAlgo.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_Copy.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakePolygon.hxx>
#include <BRepBuilderAPI_MakeVertex.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_NurbsConvert.hxx>
#include <BRepLib.hxx>
#include <BRepOffsetAPI_ThruSections.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepTools.hxx>
#include <cmath>
#include <fstream>
#include <Geom_BezierSurface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_OffsetSurface.hxx>
#include <GeomAPI_Interpolate.hxx>
#include <GeomAPI_PointsToBSplineSurface.hxx>
#include <gp.hxx>
#include <gp_Ax1.hxx>
#include <gp_Ax2.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Quantity_Color.hxx>
#include <stdexcept>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Controller.hxx>
#include <STEPControl_Writer.hxx>
#include <TColgp_Array2OfPnt.hxx>
#include <TColgp_HArray1OfPnt.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopTools_ListOfShape.hxx>
#include <vector>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_LayerTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include "tests/cad/shape_lists.hpp"

namespace tetloom::test {
namespace {

TopoDS_Shape box() { return BRepPrimAPI_MakeBox(10, 20, 30).Shape(); }

TopoDS_Shape loose(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> result;
  for (const TopoDS_Shape& face : faces_of(shape)) result.push_back(BRepBuilderAPI_Copy(face).Shape());
  return compound(result);
}

TopoDS_Shape hollow() { return BRepAlgoAPI_Cut(box(), BRepPrimAPI_MakeSphere(gp_Pnt(5, 10, 15), 3).Shape()).Shape(); }

Handle(Geom_BSplineCurve) interpolated(const std::vector<gp_Pnt>& points, bool periodic) {
  Handle(TColgp_HArray1OfPnt) array = new TColgp_HArray1OfPnt(1, static_cast<int>(points.size()));
  for (int i = 0; i < array->Length(); ++i) array->SetValue(i + 1, points[static_cast<std::size_t>(i)]);
  GeomAPI_Interpolate interpolate(array, periodic, 1e-9);
  interpolate.Perform();
  return interpolate.Curve();
}

TopoDS_Wire outline(double scale, double z) {
  const Handle(Geom_BSplineCurve) curve =
      interpolated({{6 * scale, 0, z}, {0, 4 * scale, z}, {-5 * scale, 1, z}, {-1, -5 * scale, z}}, true);
  return BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(curve).Edge()).Wire();
}

TopoDS_Shape turned_spline() {
  const Handle(Geom_BSplineCurve) curve = interpolated({{3, 0, 0}, {5, 0, 3}, {2, 0, 7}, {4, 0, 10}}, false);
  BRepBuilderAPI_MakeWire wire;
  wire.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(3, 0, 0)).Edge());
  wire.Add(BRepBuilderAPI_MakeEdge(curve).Edge());
  wire.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(4, 0, 10), gp_Pnt(0, 0, 10)).Edge());
  wire.Add(BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 10), gp_Pnt(0, 0, 0)).Edge());
  const TopoDS_Face profile = BRepBuilderAPI_MakeFace(wire.Wire());
  return BRepPrimAPI_MakeRevol(profile, gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1))).Shape();
}

TopoDS_Shape lofted() {
  BRepOffsetAPI_ThruSections loft(true, false);
  loft.AddWire(outline(1, 0));
  loft.AddWire(outline(0.6, 6));
  loft.AddWire(outline(1.2, 12));
  loft.Build();
  return loft.Shape();
}

Handle(Geom_BSplineSurface) hills() {
  TColgp_Array2OfPnt points(1, 6, 1, 6);
  for (int i = 1; i <= 6; ++i)
    for (int j = 1; j <= 6; ++j) points(i, j) = gp_Pnt(4 * i, 4 * j, std::sin(1.3 * i) + std::cos(0.9 * j));
  return GeomAPI_PointsToBSplineSurface(points).Surface();
}

TopoDS_Shape bezier_sheet() {
  TColgp_Array2OfPnt poles(1, 4, 1, 3);
  for (int i = 1; i <= 4; ++i)
    for (int j = 1; j <= 3; ++j) poles(i, j) = gp_Pnt(3 * i, 4 * j + 0.3 * i, (i * j) % 3);
  const Handle(Geom_Surface) surface = new Geom_BezierSurface(poles);
  return BRepBuilderAPI_MakeFace(surface, 1e-7).Shape();
}

TopoDS_Face sheet() {
  BRepBuilderAPI_MakePolygon outline({0, 0, 0}, {10, 0, 0}, {10, 20, 0}, {0, 20, 0}, true);
  return BRepBuilderAPI_MakeFace(outline.Wire());
}

/// The sheet from edges, with a spur from (5, 0) to (5, 8) in its boundary.
TopoDS_Shape sheet_with_spur() {
  const gp_Pnt corners[] = {{0, 0, 0}, {5, 0, 0}, {10, 0, 0}, {10, 20, 0}, {0, 20, 0}};
  TopoDS_Vertex vertices[5];
  for (int i = 0; i < 5; ++i) vertices[i] = BRepBuilderAPI_MakeVertex(corners[i]);
  const TopoDS_Vertex tip = BRepBuilderAPI_MakeVertex(gp_Pnt(5, 8, 0));
  const TopoDS_Edge spur = BRepBuilderAPI_MakeEdge(vertices[1], tip);
  BRep_Builder builder;
  TopoDS_Wire wire;
  builder.MakeWire(wire);
  for (int i = 0; i < 5; ++i)
    builder.Add(wire, TopoDS_Edge(BRepBuilderAPI_MakeEdge(vertices[i], vertices[(i + 1) % 5])));
  builder.Add(wire, spur.Oriented(TopAbs_FORWARD));
  builder.Add(wire, spur.Oriented(TopAbs_REVERSED));
  TopoDS_Face face;
  builder.MakeFace(face, BRep_Tool::Surface(sheet()), 1e-7);
  builder.Add(face, wire);
  return face;
}

TopoDS_Shape sheet_with_line() {
  TopTools_ListOfShape arguments;
  arguments.Append(sheet());
  arguments.Append(BRepBuilderAPI_MakeEdge(gp_Pnt(3, 5, 0), gp_Pnt(7, 12, 0)).Edge());
  BRepAlgoAPI_BuilderAlgo fuse;
  fuse.SetArguments(arguments);
  fuse.Build();
  return fuse.Shape();
}

TopoDS_Shape open_box() {
  TopoDS_Shell shell;
  TopoDS_Solid solid;
  BRep_Builder builder;
  builder.MakeShell(shell);
  const std::vector<TopoDS_Shape> faces = faces_of(box());
  for (std::size_t i = 1; i < faces.size(); ++i) builder.Add(shell, faces[i]);
  builder.MakeSolid(solid);
  builder.Add(solid, shell);
  return solid;
}

TopoDS_Shape inside_out_box() {
  TopoDS_Solid solid;
  BRep_Builder builder;
  builder.MakeSolid(solid);
  const TopoDS_Shape body = box();
  for (TopoDS_Iterator shell(body); shell.More(); shell.Next()) builder.Add(solid, shell.Value().Reversed());
  return solid;
}

TopLoc_Location along_x(double distance) {
  gp_Trsf move;
  move.SetTranslation(gp_Vec(distance, 0, 0));
  return move;
}

TopoDS_Shape touching_boxes() {
  return compound(
      {BRepPrimAPI_MakeBox(10, 10, 10).Shape(), BRepPrimAPI_MakeBox(gp_Pnt(10, 2, 2), gp_Pnt(20, 12, 12)).Shape()});
}

TopoDS_Shape sharing_boxes() {
  TopTools_ListOfShape arguments;
  arguments.Append(BRepPrimAPI_MakeBox(10, 10, 10).Shape());
  arguments.Append(BRepPrimAPI_MakeBox(gp_Pnt(10, 0, 0), gp_Pnt(20, 10, 10)).Shape());
  BRepAlgoAPI_BuilderAlgo fuse;
  fuse.SetArguments(arguments);
  fuse.Build();
  return fuse.Shape();
}

TopoDS_Shape halved_sphere() {
  const gp_Ax2 axes = gp::XOY();
  return BRepAlgoAPI_Fuse(BRepPrimAPI_MakeSphere(axes, 5, -0.5 * M_PI, 0).Shape(),
                          BRepPrimAPI_MakeSphere(axes, 5, 0, 0.5 * M_PI).Shape())
      .Shape();
}

TopoDS_Shape drilled_box() {
  const gp_Ax2 axis(gp_Pnt(5, 10, -1), gp_Dir(0, 0, 1));
  return BRepAlgoAPI_Cut(box(), BRepPrimAPI_MakeCylinder(axis, 3, 32).Shape()).Shape();
}

TopoDS_Shape make_shape(Sample sample) {
  switch (sample) {
    case Sample::Box: return box();
    case Sample::Cylinder: return BRepPrimAPI_MakeCylinder(5, 10).Shape();
    case Sample::Sphere: return BRepPrimAPI_MakeSphere(5).Shape();
    case Sample::HalvedSphere: return halved_sphere();
    case Sample::Torus: return BRepPrimAPI_MakeTorus(10, 3).Shape();
    case Sample::Cone: return BRepPrimAPI_MakeCone(5, 0, 10).Shape();
    case Sample::TurnedSpline: return turned_spline();
    case Sample::PushedSpline:
      return BRepPrimAPI_MakePrism(BRepBuilderAPI_MakeFace(outline(1, 0)).Face(), gp_Vec(0, 0, 8)).Shape();
    case Sample::SplineSolid: return BRepBuilderAPI_NurbsConvert(BRepPrimAPI_MakeCylinder(5, 10).Shape()).Shape();
    case Sample::LoftedSolid: return lofted();
    case Sample::OffsetSheet:
      return BRepBuilderAPI_MakeFace(Handle(Geom_Surface)(new Geom_OffsetSurface(hills(), 0.5)), 1e-7).Shape();
    case Sample::BezierSheet: return bezier_sheet();
    case Sample::DrilledBox: return drilled_box();
    case Sample::HollowBox: return hollow();
    case Sample::TouchingBoxes: return touching_boxes();
    case Sample::SharingBoxes: return sharing_boxes();
    case Sample::InsideOutBox: return inside_out_box();
    case Sample::PlacedInsideOutBox: return compound({inside_out_box().Moved(along_x(100))});
    case Sample::OpenBox: return open_box();
    case Sample::LooseFaces: return loose(box());
    case Sample::LooseHollow: return loose(hollow());
    case Sample::Sheet: return sheet();
    case Sample::SheetWithSpur: return sheet_with_spur();
    case Sample::SheetWithLine: return sheet_with_line();
    case Sample::BoxWithEdge:
      return compound({box(), BRepBuilderAPI_MakeEdge(gp_Pnt(50, 0, 0), gp_Pnt(60, 0, 0)).Shape(),
                       BRepBuilderAPI_MakeVertex(gp_Pnt(70, 0, 0)).Shape()});
    case Sample::NoShape: return compound({});
  }
  throw std::runtime_error("unknown sample");
}

void require(bool done, const std::filesystem::path& path) {
  if (!done) throw std::runtime_error("could not write " + path.string());
}

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

void write_step(const TopoDS_Shape& shape, const std::filesystem::path& path, const char* unit) {
  STEPControl_Controller::Init();
  Interface_Static::SetCVal("write.step.unit", unit);
  STEPControl_Writer writer;
  const bool transferred = writer.Transfer(shape, STEPControl_AsIs) == IFSelect_RetDone;
  const bool written = transferred && writer.Write(path.c_str()) == IFSelect_RetDone;
  Interface_Static::SetCVal("write.step.unit", "MM");
  require(written, path);
}

}  // namespace

void write_sample(Sample sample, const std::filesystem::path& path) {
  const Silence silence;
  const TopoDS_Shape shape = make_shape(sample);
  if (path.extension() == ".brep") {
    require(BRepTools::Write(shape, path.c_str()), path);
  } else if (path.extension() == ".step") {
    write_step(shape, path, "MM");
  } else {
    IGESControl_Writer writer("MM", 0);
    require(writer.AddShape(shape) && writer.Write(path.c_str()), path);
  }
}

void write_step_without_parameter_curves(Sample sample, const std::filesystem::path& path) {
  const Silence silence;
  STEPControl_Controller::Init();
  const int before = Interface_Static::IVal("write.surfacecurve.mode");
  Interface_Static::SetIVal("write.surfacecurve.mode", 0);
  write_step(make_shape(sample), path, "MM");
  Interface_Static::SetIVal("write.surfacecurve.mode", before);
}

void write_inch_box(const std::filesystem::path& path) {
  const Silence silence;
  write_step(BRepPrimAPI_MakeBox(25.4, 50.8, 76.2).Shape(), path, "INCH");
}

void write_gearbox(const std::filesystem::path& path) {
  const Silence silence;
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const Handle(XCAFDoc_ColorTool) colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const TopoDS_Shape housing = box(), shaft = BRepPrimAPI_MakeCylinder(5, 10).Shape();
  const TDF_Label housing_label = shapes->AddShape(housing, false), shaft_label = shapes->AddShape(shaft, false);
  TDataStd_Name::Set(housing_label, "housing");
  TDataStd_Name::Set(shaft_label, "shaft");
  colors->SetColor(housing_label, Quantity_Color(1, 0, 0, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  colors->SetColor(shaft_label, Quantity_Color(0, 1, 0, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  const std::vector<TopoDS_Shape> faces = faces_of(housing);
  const TDF_Label lid = shapes->AddSubShape(housing_label, faces.back());  // the last face of a box lies at z = top
  TDataStd_Name::Set(lid, "lid");
  colors->SetColor(lid, Quantity_Color(0, 0, 1, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  XCAFDoc_DocumentTool::LayerTool(document->Main())->SetLayer(lid, "top");
  const TDF_Label assembly = shapes->NewShape();
  TDataStd_Name::Set(assembly, "gearbox");
  shapes->AddComponent(assembly, housing_label, TopLoc_Location());
  for (const double x : {40.0, 60.0}) {
    gp_Trsf shift;
    shift.SetTranslation(gp_Vec(x, 0, 0));
    shapes->AddComponent(assembly, shaft_label, TopLoc_Location(shift));
  }
  shapes->UpdateAssemblies();
  STEPCAFControl_Writer writer;
  Interface_Static::SetIVal("write.stepcaf.subshapes.name", 1);
  require(writer.Perform(document, path.c_str()), path);
  Interface_Static::SetIVal("write.stepcaf.subshapes.name", 0);
  XCAFApp_Application::GetApplication()->Close(document);
}

void write_step_without_shape(const std::filesystem::path& path) {
  std::ofstream(path) << "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\n"
                         "FILE_NAME('empty','2026-01-01T00:00:00',(''),(''),'','','');\n"
                         "FILE_SCHEMA(('AUTOMOTIVE_DESIGN { 1 0 10303 214 1 1 1 1 }'));\nENDSEC;\nDATA;\n"
                         "#1=CARTESIAN_POINT('',(0.,0.,0.));\nENDSEC;\nEND-ISO-10303-21;\n";
}

}  // namespace tetloom::test
