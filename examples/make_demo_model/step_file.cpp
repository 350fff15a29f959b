// Checking and writing the demo models.
#include <APIHeaderSection_MakeHeader.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepGProp.hxx>
#include <GProp_GProps.hxx>
#include <Interface_Static.hxx>
#include <stdexcept>
#include <STEPCAFControl_Writer.hxx>
#include <StepData_StepModel.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include "examples/make_demo_model/demo_models.hpp"

namespace tetloom::demo {
namespace {

TDF_Label add_part(const DemoPart& part, const Handle(TDocStd_Document) & document) {
  const Handle(XCAFDoc_ShapeTool) shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const Handle(XCAFDoc_ColorTool) colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const TDF_Label label = shapes->AddShape(part.shape, Standard_False);
  TDataStd_Name::Set(label, part.name.c_str());
  colors->SetColor(label, part.color, XCAFDoc_ColorSurf);
  for (const DemoPart::NamedFace& face : part.faces) {
    const TDF_Label face_label = shapes->AddSubShape(label, face.face);
    TDataStd_Name::Set(face_label, face.name.c_str());
    colors->SetColor(face_label, face.color, XCAFDoc_ColorSurf);
  }
  return label;
}

}  // namespace

void check_parts(const std::vector<DemoPart>& parts) {
  for (const DemoPart& part : parts) {
    if (!BRepCheck_Analyzer(part.shape).IsValid()) throw std::runtime_error(part.name + " is not a valid shape");
    GProp_GProps properties;
    BRepGProp::VolumeProperties(part.shape, properties);
    if (!(properties.Mass() > 0)) throw std::runtime_error(part.name + " has no positive volume");
  }
}

void write_step(const std::vector<DemoPart>& parts, const std::string& path) {
  Handle(TDocStd_Document) document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  STEPCAFControl_Writer writer;
  Interface_Static::SetCVal("write.step.unit", "MM");
  Interface_Static::SetIVal("write.stepcaf.subshapes.name", 1);
  writer.SetNameMode(Standard_True);
  writer.SetColorMode(Standard_True);
  // One by one: the writer styles the shapes of one transfer in the order of their addresses.
  bool written = true;
  for (const DemoPart& part : parts) written = written && writer.Transfer(add_part(part, document));
  if (written) {
    // A fixed time stamp: the same model is the same file.
    APIHeaderSection_MakeHeader header(writer.ChangeWriter().Model());
    header.SetTimeStamp(new TCollection_HAsciiString("2026-01-01T00:00:00"));
    header.SetName(new TCollection_HAsciiString(parts.front().name.c_str()));
    header.SetAuthorValue(1, new TCollection_HAsciiString("tetloom-demo-model"));
    header.SetOrganizationValue(1, new TCollection_HAsciiString("tetloom"));
    written = writer.Write(path.c_str()) == IFSelect_RetDone;
  }
  XCAFApp_Application::GetApplication()->Close(document);
  if (!written) throw std::runtime_error("cannot write '" + path + "'");
}

}  // namespace tetloom::demo
