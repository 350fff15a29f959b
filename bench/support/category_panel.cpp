#include "bench/support/category_panel.hpp"

#include <algorithm>

namespace tetloom::bench {

Panel draw_categories(const std::string& title, const std::string& columns, const std::string& unit,
                      const std::vector<CategoryValue>& values) {
  Panel panel{title, {columns}, {unit}, {}};
  std::vector<std::string> names;
  for (const CategoryValue& one : values) {
    auto column = std::find(names.begin(), names.end(), one.column);
    if (column == names.end()) column = names.insert(column, one.column);
    const double place = static_cast<double>(column - names.begin() + 1);
    auto series = std::find_if(panel.series.begin(), panel.series.end(),
                               [&](const PlotSeries& other) { return other.name == one.contender; });
    if (series == panel.series.end()) series = panel.series.insert(series, {one.contender, {}, Stroke::None});
    series->points.push_back({place, one.value});
  }
  panel.x.from_zero = false;
  panel.x.ticks.push_back({0.5, ""});
  for (std::size_t i = 0; i < names.size(); ++i) panel.x.ticks.push_back({static_cast<double>(i + 1), names[i]});
  panel.x.ticks.push_back({static_cast<double>(names.size()) + 0.5, ""});
  return panel;
}

}  // namespace tetloom::bench
