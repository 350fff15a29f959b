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

// Whether the shapes of a part have an item among them that is none, such as a note. In other lists OpenCASCADE 7.6
// does not survive one.
bool is_unknown_item(std::string_view type, std::string_view failure) {
  return type.starts_with("StepShape_") && type.ends_with("Representation") &&
         failure.find("(representation_item)") != std::string_view::npos &&
         failure.find("illegal type") != std::string_view::npos;
}

// What is wrong with an entity.
struct Faults {
  std::string damage;  // the first failure that is more than a name or an item left out
  bool has_unknown_item = false;
};

Faults faults_of(std::string_view type, const Handle(Interface_Check) & check) {
  Faults faults;
  for (int i = 1; i <= check->NbFails(); ++i) {
    const std::string_view failure = check->CFail(i);
    if (failure.find("(name) not a quoted String") != std::string_view::npos) continue;
    if (is_unknown_item(type, failure))
      faults.has_unknown_item = true;
    else if (faults.damage.empty())
      faults.damage = failure;
  }
  return faults;
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
    const std::string_view type = model->Value(i)->DynamicType()->Name();
    if (!shapes_depend_on(type)) continue;
    const Faults faults = faults_of(type, check);
    if (faults.damage.empty() && !faults.has_unknown_item) continue;
    const std::string label = model->StringLabel(model->Value(i))->ToCString();
    if (!faults.damage.empty())
      throw Error(ErrorCode::InputUnreadable, "'" + path.string() + "' is damaged at " + label + ": " + faults.damage);
    const std::string left_out = "an item of the shapes " + label + " is of an unknown kind and left out";
    warnings.push_back({ErrorCode::InputUnreadable, left_out, {}, {}, {}});
  }
  return warnings;
}

}  // namespace tetloom::cad
