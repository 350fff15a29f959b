#pragma once
// Is this file what its extension says, and all of it? OpenCASCADE's readers tell little and trust much, so obvious
// damage is found before they start. Private to core/cad.
#include <filesystem>

#include "core/cad/detail/document.hpp"

namespace tetloom::cad {

/// Errors: InputUnreadable with the reason: missing, a directory, empty, another format, cut off.
void check_content(const std::filesystem::path& path, CadFormat format);

}  // namespace tetloom::cad
