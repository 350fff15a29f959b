#include "core/cad/detail/exchange_check.hpp"

#include <Interface_Check.hxx>
#include <string>
#include <string_view>
#include <TCollection_HAsciiString.hxx>

namespace tetloom::cad {
namespace {

bool shapes_depend_on(std::string_view type) {
  return type.starts_with("StepGeom_") || type.starts_with("StepShape_") ||
         type == "StepRepr_DefinitionalRepresentation" || type == "IGESGeom_CurveOnSurface" ||
         type == "IGESGeom_TrimmedSurface" || type == "IGESGeom_Boundary" || type == "IGESGeom_BoundedSurface";
}

/// The first failure that is more than a name left out.
std::string first_failure(const Handle(Interface_Check) & check) {
  for (int i = 1; i <= check->NbFails(); ++i) {
    const std::string_view text = check->CFail(i);
    if (text.find("(name) not a quoted String") == std::string_view::npos) return std::string(text);
  }
  return "";
}

}  // namespace

std::vector<Diagnostic> check_loaded_model(const std::filesystem::path& path,
                                           const Handle(Interface_InterfaceModel) & model) {
  std::vector<Diagnostic> warnings;
  const Handle(Interface_Check) whole = model->GlobalCheck();
  if (!whole.IsNull() && whole->HasFailed())
    warnings.push_back(
        {ErrorCode::InputUnreadable, std::string("the file has errors: ") + whole->CFail(1), {}, {}, {}});
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Handle(Interface_Check) check = model->Check(i, true);
    if (check.IsNull() || !check->HasFailed()) continue;
    if (!shapes_depend_on(model->Value(i)->DynamicType()->Name())) continue;
    const std::string failure = first_failure(check);
    if (failure.empty()) continue;
    const Handle(TCollection_HAsciiString) label = model->StringLabel(model->Value(i));
    throw Error(ErrorCode::InputUnreadable,
                "'" + path.string() + "' is damaged at " + label->ToCString() + ": " + failure);
  }
  return warnings;
}

}  // namespace tetloom::cad
