#pragma once
// Texts, errors and warnings packed into bytes.
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/storage.hpp"

namespace tetloom {

void put_text(MessageWriter& writer, std::string_view text);
std::string get_text(MessageReader& reader);

void put_entities(MessageWriter& writer, std::span<const NamedEntity> entities);
std::vector<NamedEntity> get_entities(MessageReader& reader);

void put_diagnostic(MessageWriter& writer, const Diagnostic& diagnostic);
Diagnostic get_diagnostic(MessageReader& reader);

void put_diagnostics(MessageWriter& writer, std::span<const Diagnostic> diagnostics);
std::vector<Diagnostic> get_diagnostics(MessageReader& reader);

}  // namespace tetloom
