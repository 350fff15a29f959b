#pragma once
// What a rank tells the others of what it has filled.
#include "mesher/volume/volume_parts.hpp"
#include "threading/message.hpp"

namespace tetloom::volume {

void put_text(MessageWriter& writer, const std::string& text);
std::string get_text(MessageReader& reader);

void put_diagnostics(MessageWriter& writer, std::span<const Diagnostic> diagnostics);
std::vector<Diagnostic> get_diagnostics(MessageReader& reader);

void put_figures(MessageWriter& writer, const FillingFigures& figures);
FillingFigures get_figures(MessageReader& reader);

void put_part(MessageWriter& writer, const VolumePart& part);
VolumePart get_part(MessageReader& reader);

}  // namespace tetloom::volume
