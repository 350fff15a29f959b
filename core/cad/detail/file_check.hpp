#pragma once
// Is this file what its extension says, and all of it? OpenCASCADE's readers tell little and trust much, so obvious
// damage is found before they start. Private to core/cad.
#include <filesystem>
#include <string>

#include "core/cad/detail/document.hpp"

namespace tetloom::cad {

/// Throws InputUnreadable: the file, then why.
[[noreturn]] void unreadable(const std::filesystem::path& path, const std::string& why);

/// Errors: InputUnreadable with the reason: missing, a directory, empty, another format, cut off.
void check_content(const std::filesystem::path& path, CadFormat format);

}  // namespace tetloom::cad
