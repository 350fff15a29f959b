#pragma once
// Plots as SVG: panels side by side, each with two axes and series of points; one legend for all of them.
#include <filesystem>
#include <string>
#include <vector>

#include "bench/support/plot_axis.hpp"

namespace tetloom::bench {

enum class Stroke { None, Solid, Dashed };

struct PlotPoint {
  double x = 0, y = 0;
};

struct PlotSeries {
  std::string name;               ///< series of one name look alike in all panels and stand once in the legend
  std::vector<PlotPoint> points;  ///< joined in this order
  Stroke stroke = Stroke::Solid;
  bool markers = true;
};

struct Panel {
  std::string title;
  Axis x, y;
  std::vector<PlotSeries> series;
};

struct Figure {
  std::string title;
  std::vector<std::string> notes;  ///< what the figure is worth nothing without: machine, commit, date
  std::vector<Panel> panels;
  std::size_t columns = 0;  ///< panels beside each other, further ones below; 0: all
};

/// A document of SVG 1.1 that stands alone, the same for the same figure. Text is UTF-8.
/// Throws std::invalid_argument for a figure without panels, and for what AxisRange refuses.
std::string render_svg(const Figure& figure);

/// Throws std::runtime_error when the file cannot be written.
void write_svg(const Figure& figure, const std::filesystem::path& path);

}  // namespace tetloom::bench
