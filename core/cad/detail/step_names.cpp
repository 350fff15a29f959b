#include "core/cad/detail/step_names.hpp"

#include <algorithm>
#include <cctype>
#include <StepRepr_RepresentationItem.hxx>
#include <TCollection_HAsciiString.hxx>
#include <TopExp.hxx>
#include <Transfer_TransientProcess.hxx>
#include <TransferBRep.hxx>
#include <XSControl_TransferReader.hxx>
#include <XSControl_WorkSession.hxx>

namespace tetloom::cad {
namespace {

/// By shape without its place.
using ShapeNames = NCollection_DataMap<TopoDS_Shape, std::string, TopTools_ShapeMapHasher>;

ShapeNames collect_names(const STEPCAFControl_Reader& reader) {
  ShapeNames names;
  const Handle(XSControl_WorkSession) session = reader.Reader().WS();
  const Handle(Interface_InterfaceModel) model = session->Model();
  const Handle(Transfer_TransientProcess) process = session->TransferReader()->TransientProcess();
  if (model.IsNull() || process.IsNull()) return names;
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(StepRepr_RepresentationItem) item = Handle(StepRepr_RepresentationItem)::DownCast(model->Value(i));
    if (item.IsNull() || item->Name().IsNull() || item->Name()->IsEmpty()) continue;
    const std::string name = clean_name(TCollection_ExtendedString(item->Name()->ToCString(), true));
    const TopoDS_Shape shape = name.empty() ? TopoDS_Shape() : TransferBRep::ShapeResult(process, item);
    if (shape.IsNull()) continue;
    const TopoDS_Shape key = shape.Located(TopLoc_Location());
    if (!names.IsBound(key)) names.Bind(key, name);
  }
  return names;
}

}  // namespace

std::string clean_name(const TCollection_ExtendedString& text) {
  std::string name(static_cast<std::size_t>(text.LengthOfCString()) + 1, '\0');
  Standard_PCharacter begin = name.data();
  name.resize(static_cast<std::size_t>(text.ToUTF8CString(begin)));
  const auto space = [](unsigned char c) { return std::isspace(c) != 0; };
  name.erase(name.begin(), std::find_if_not(name.begin(), name.end(), space));
  name.erase(std::find_if_not(name.rbegin(), name.rend(), space).base(), name.end());
  return name == "NONE" || name.starts_with("=>") ? "" : name;
}

void add_step_names(const STEPCAFControl_Reader& reader, Document& document) {
  const ShapeNames names = collect_names(reader);
  if (names.IsEmpty()) return;
  TopTools_IndexedMapOfShape shapes;
  TopExp::MapShapes(document.root, shapes);
  for (int i = 1; i <= shapes.Extent(); ++i) {
    const std::string* name = names.Seek(shapes(i).Located(TopLoc_Location()));
    if (!name) continue;
    ShapeAttributes attributes;
    attributes.name = *name;
    add_attributes(document.attributes, shapes(i), attributes);
  }
}

}  // namespace tetloom::cad
