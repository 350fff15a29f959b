#pragma once
// The text of a STEP file (ISO 10303-21) as records, faster than OpenCASCADE's own parser and for well-formed files
// only. Private to core/cad.
#include <cstdint>
#include <deque>
#include <Interface_ParamType.hxx>
#include <optional>
#include <string>
#include <vector>

namespace tetloom::cad {

struct StepArgument {
  const char* text;
  Interface_ParamType type;
};

/// One entity, one part of a complex entity, or one list inside of them.
struct StepRecord {
  const char* ident;  ///< "#12"; "#0" in the header and for the later parts of a complex entity; "$1", "$2" … for lists
  const char* type;
  std::uint32_t first_argument, argument_count;
};

/// The records in the order in which OpenCASCADE's StepData_StepReaderData expects them: a list before what it is in.
/// Texts point into `buffer` and `list_names`.
struct StepText {
  std::string buffer;
  std::deque<std::string> list_names;
  std::vector<StepRecord> records;
  std::vector<StepArgument> arguments;
  std::size_t header_count = 0;  ///< records of the header
};

/// Nothing for a file with anything unusual (errors, scopes, several data sections): OpenCASCADE's parser decides on
/// those. Linear in the length.
std::optional<StepText> parse_step_text(std::string text);

}  // namespace tetloom::cad
