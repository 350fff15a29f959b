#include "core/cad/detail/step_library.hpp"

#include <fstream>
#include <sstream>
#include <StepData_FileRecognizer.hxx>
#include <StepData_Protocol.hxx>
#include <StepData_StepModel.hxx>
#include <StepData_StepReaderData.hxx>
#include <StepData_StepReaderTool.hxx>

#include "core/cad/detail/step_text.hpp"

namespace tetloom::cad {
namespace {

std::string content_of(const char* name) {
  std::ifstream stream(name, std::ios::binary | std::ios::ate);
  if (!stream) return "";
  std::string text(static_cast<std::size_t>(stream.tellg()), '\0');
  stream.seekg(0);
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  return stream ? text : "";
}

Handle(StepData_StepReaderData) to_reader_data(const StepText& text, const Handle(StepData_StepModel) & model) {
  const Handle(StepData_StepReaderData) data =
      new StepData_StepReaderData(static_cast<int>(text.header_count), static_cast<int>(text.records.size()),
                                  static_cast<int>(text.arguments.size()), model->SourceCodePage());
  for (std::size_t i = 0; i < text.records.size(); ++i) {
    const StepRecord& record = text.records[i];
    const int number = static_cast<int>(i) + 1;
    data->SetRecord(number, record.ident, record.type, record.argument_count > 0 ? 1 : 0);
    for (std::uint32_t k = 0; k < record.argument_count; ++k) {
      const StepArgument& argument = text.arguments[record.first_argument + k];
      data->AddStepParam(number, argument.text, argument.type);
    }
    data->InitParams(number);
  }
  return data;
}

}  // namespace

Standard_Integer StepLibrary::ReadFile(const Standard_CString name, Handle(Interface_InterfaceModel) & model,
                                       const Handle(Interface_Protocol) & protocol) const {
  const Handle(StepData_Protocol) step = Handle(StepData_Protocol)::DownCast(protocol);
  const std::optional<StepText> text = parse_step_text(content_of(name));
  if (step.IsNull() || !text) return StepSelect_WorkLibrary::ReadFile(name, model, protocol);
  const Handle(StepData_StepModel) loaded = new StepData_StepModel;
  model = loaded;
  StepData_StepReaderTool tool(to_reader_data(*text, loaded), step);
  tool.SetErrorHandle(true);
  const Handle(StepData_FileRecognizer) by_protocol;
  tool.PrepareHeader(by_protocol);
  tool.Prepare(by_protocol);
  tool.LoadModel(loaded);
  if (loaded->Protocol().IsNull()) loaded->SetProtocol(step);
  tool.Clear();
  return 0;
}

}  // namespace tetloom::cad
