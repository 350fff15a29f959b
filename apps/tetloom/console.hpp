#pragma once
// What a person reads: results on standard output, errors and warnings on standard error.
#include <cstdio>
#include <string>
#include <string_view>

#include "apps/tetloom/report.hpp"

namespace tetloom::app {

/// "error: the face could not be meshed", and lines with the entities and the point where it has them.
std::string render_diagnostic(std::string_view kind, const Diagnostic& diagnostic);

/// Bars of a histogram over equal bins of [low, high], one line per bin.
/// Pre: bins not empty.
std::string render_histogram(const std::size_t* bins, std::size_t count, double low, double high);

/// Shapes, sizes and, where the model's is known, the volume: the paragraphs that `mesh` and `check` share.
std::string render_quality(const RunReport& report);

/// Counts, quality, time per stage and written files of a finished `mesh` run.
std::string render_summary(const RunReport& report, const std::string& output, const std::string& report_file);

/// Writes to `stream` and forgets about errors: a reader that has gone away must not end the work.
void print(std::FILE* stream, std::string_view text);

}  // namespace tetloom::app
