#pragma once
// The command line of `adapt`.
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/tetloom/options.hpp"
#include "apps/tetloom/reading_options.hpp"

namespace tetloom::app {

/// Values as they come from the command line, before they are judged.
struct RawAdapt {
  std::string input, output, report, model, metric, metric_field, hessian;
  std::optional<double> complexity, norm, h_min, h_max, max_aspect, gradation, quality_floor, tets_per_part, curvature;
  RawReading reading;
  std::vector<std::string> transfer;
  std::optional<int> threads, parts, transfer_order;
  bool quiet = false;
};

CLI::App* add_adapt_command(CLI::App& app, RawAdapt& raw);

/// Throws UsageError.
AdaptCommand make_adapt_command(const RawAdapt& raw);

}  // namespace tetloom::app
