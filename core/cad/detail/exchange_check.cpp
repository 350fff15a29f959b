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

// The first failure that is more than a name left out.
std::string first_failure(const Handle(Interface_Check) & check) {
  for (int i = 1; i <= check->NbFails(); ++i) {
    const std::string_view text = check->CFail(i);
    if (text.find("(name) not a quoted String") == std::string_view::npos) return std::string(text);
  }
  return "";
}

// Whether nothing is wrong but that the shapes of a part have an item among them that is none, such as a note. In other
// lists OpenCASCADE 7.6 does not survive one.
bool has_unknown_item(std::string_view type, std::string_view failure) {
  return type.starts_with("StepShape_") && type.ends_with("Representation") &&
         failure.find("(representation_item)") != std::string_view::npos &&
         failure.find("illegal type") != std::string_view::npos;
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
    const std::string label = model->StringLabel(model->Value(i))->ToCString();
    if (!has_unknown_item(model->Value(i)->DynamicType()->Name(), failure))
      throw Error(ErrorCode::InputUnreadable, "'" + path.string() + "' is damaged at " + label + ": " + failure);
    warnings.push_back({ErrorCode::InputUnreadable,
                        "an item of the shapes " + label + " is of an unknown kind and left out",
                        {},
                        {},
                        {}});
  }
  return warnings;
}

}  // namespace tetloom::cad
