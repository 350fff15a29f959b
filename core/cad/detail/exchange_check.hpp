#pragma once
// What OpenCASCADE found out while loading an exchange file. Private to core/cad.
#include <filesystem>
#include <Interface_InterfaceModel.hxx>
#include <vector>

#include "tetloom/error.hpp"

namespace tetloom::cad {

/// Refuses a STEP model in which an entity of geometry or topology is damaged, and an IGES model in which a trimmed
/// surface is: the translation would follow null references. Damage elsewhere (units, presentation, products) and
/// syntax errors that could be skipped are warned of. Errors: InputUnreadable with the first damaged entity.
std::vector<Diagnostic> check_loaded_model(const std::filesystem::path& path,
                                           const Handle(Interface_InterfaceModel) & model);

}  // namespace tetloom::cad
