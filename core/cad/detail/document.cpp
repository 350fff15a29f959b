#include "core/cad/detail/document.hpp"

#include <BRep_Builder.hxx>
#include <BRepTools.hxx>
#include <fstream>
#include <IGESCAFControl_Reader.hxx>
#include <Interface_Static.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDocStd_Document.hxx>
#include <XCAFApp_Application.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XSControl_WorkSession.hxx>

#include "core/cad/detail/assembly.hpp"
#include "core/cad/detail/exchange_check.hpp"
#include "core/cad/detail/file_check.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "core/cad/detail/step_names.hpp"

namespace tetloom::cad {
namespace {

constexpr double kMetresPerMillimetre = 0.001;  // OpenCASCADE's readers convert to millimetres

[[noreturn]] void without_shape(const std::filesystem::path& path) {
  throw Error(ErrorCode::InputUnsuitable, "'" + path.string() + "' holds no shape");
}

/// A document that closes itself.
class CafDocument {
 public:
  CafDocument() { XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document_); }
  ~CafDocument() {
    try {
      XCAFApp_Application::GetApplication()->Close(document_);
    } catch (const Standard_Failure&) {  // nothing to do about a document that cannot be closed
    }
  }
  CafDocument(const CafDocument&) = delete;
  CafDocument& operator=(const CafDocument&) = delete;
  Handle(TDocStd_Document) & get() { return document_; }

 private:
  Handle(TDocStd_Document) document_;
};

/// One of OpenCASCADE's global settings, otherwise while this lives.
class Setting {
 public:
  Setting(const char* name, double value) : name_(name), before_(Interface_Static::RVal(name)) {
    Interface_Static::SetRVal(name_, value);
  }
  ~Setting() { Interface_Static::SetRVal(name_, before_); }
  Setting(const Setting&) = delete;
  Setting& operator=(const Setting&) = delete;

 private:
  const char* name_;
  double before_;
};

template <class Reader>
void transfer(Reader& reader, CafDocument& document, const std::filesystem::path& path, const CancelToken* cancel) {
  if (cancel) cancel->check();
  const Setting no_regularity("read.encoderegularity.angle", 0);  // how smooth edges are, which nobody asks for
  Handle(CancelIndicator) indicator = new CancelIndicator(cancel);
  const bool done = reader.Transfer(document.get(), Message_ProgressIndicator::Start(indicator));
  if (cancel) cancel->check();
  if (!done) without_shape(path);
}

Document read_step(const std::filesystem::path& path, const CancelToken* cancel) {
  CafDocument document;
  STEPCAFControl_Reader reader;
  reader.SetPropsMode(false);
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) unreadable(path, "is not a valid STEP file");
  const std::vector<Diagnostic> warnings = check_loaded_model(path, reader.Reader().WS()->Model());
  if (reader.NbRootsForTransfer() == 0) without_shape(path);
  DeferredFixing deferred;
  transfer(reader, document, path, cancel);
  Document result = flatten_assembly(document.get());
  result.raw_bodies = deferred.take();
  result.warnings = warnings;
  add_step_names(reader, result);
  result.metres_per_unit = kMetresPerMillimetre;
  return result;
}

Document read_iges(const std::filesystem::path& path, const CancelToken* cancel) {
  CafDocument document;
  IGESCAFControl_Reader reader;
  if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) unreadable(path, "is not a valid IGES file");
  const std::vector<Diagnostic> warnings = check_loaded_model(path, reader.WS()->Model());
  if (reader.NbRootsForTransfer() == 0) without_shape(path);
  transfer(reader, document, path, cancel);
  Document result = flatten_assembly(document.get());
  result.warnings = warnings;
  result.metres_per_unit = kMetresPerMillimetre;
  return result;
}

Document read_brep(const std::filesystem::path& path, const CancelToken* cancel) {
  std::ifstream stream(path, std::ios::binary);
  TopoDS_Shape shape;
  BRep_Builder builder;
  Handle(CancelIndicator) indicator = new CancelIndicator(cancel);
  BRepTools::Read(shape, stream, builder, Message_ProgressIndicator::Start(indicator));
  if (cancel) cancel->check();
  if (shape.IsNull()) unreadable(path, "is not a valid BREP file");
  Document result;
  builder.MakeCompound(result.root);
  builder.Add(result.root, shape);
  return result;
}

}  // namespace

Document read_document(const std::filesystem::path& path, CadFormat format, const CancelToken* cancel) {
  check_content(path, format);
  return translate_failures({}, ErrorCode::InputUnreadable, ("reading '" + path.string() + "'").c_str(), [&] {
    switch (format) {
      case CadFormat::Step: return read_step(path, cancel);
      case CadFormat::Iges: return read_iges(path, cancel);
      case CadFormat::Brep: return read_brep(path, cancel);
    }
    throw Error(ErrorCode::Internal, "unknown CAD format");
  });
}

}  // namespace tetloom::cad
