#pragma once
// What the command line says of how models are read.
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::app {

/// Values as they come from the command line, before they are judged.
struct RawReading {
  std::optional<double> feature_angle, fill_holes;
  std::vector<std::string> rebuild;
  bool imprint = false, no_heal = false;
  bool operator==(const RawReading&) const = default;
};

void add_reading_options(CLI::App& command, RawReading& raw);

/// Throws UsageError.
ReadOptions make_read_options(const RawReading& raw);

}  // namespace tetloom::app
