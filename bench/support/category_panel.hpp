#pragma once
// Plots of a few things side by side: one column per thing, one marker per contender.
#include <string>
#include <vector>

#include "bench/support/svg_plot.hpp"

namespace tetloom::bench {

struct CategoryValue {
  std::string column, contender;
  double value = 0;
};

/// Columns and contenders in the order in which they first come. Pre: not empty.
Panel draw_categories(const std::string& title, const std::string& columns, const std::string& unit,
                      const std::vector<CategoryValue>& values);

}  // namespace tetloom::bench
