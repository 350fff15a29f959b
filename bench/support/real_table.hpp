#pragma once
// How runs over many real models are shown: one line each, and what all of them say together.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bench/support/real_model.hpp"

namespace tetloom::bench {

/// One thing measured over all models, and what is asked of it.
struct SummaryRow {
  std::string measure, value, target;
  bool reached = true;
};

/// The middle value, the mean of the two middle ones of an even number; none of nothing.
std::optional<double> median(std::vector<double> values);

/// The rows, in a fixed order. Speeds are compared on the models of `can_compare`, shapes are those of valid meshes of
/// volumes. Rows that nothing can be said of have the value "-" and count as reached.
std::vector<SummaryRow> summarize(std::span<const RealModel> models);

void print_table_heading();
void print_table_line(const RealModel& model);
/// The rows of `summarize`, marked where they miss.
void print_summary(std::span<const RealModel> models);
/// A line for every model that is not valid, saying why, and for every mesh with an angle below 5 degrees, saying what
/// of the model forces it.
void print_findings(std::span<const RealModel> models);

}  // namespace tetloom::bench
