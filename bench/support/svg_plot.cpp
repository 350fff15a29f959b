#include "bench/support/svg_plot.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace tetloom::bench {
namespace {

// Lengths in pixels.
constexpr double kPanelWidth = 400, kPanelHeight = 290, kLeft = 64, kRight = 16, kTop = 26, kBottom = 52;
constexpr double kMargin = 16, kTitleHeight = 30, kLineHeight = 15, kLegendHeight = 20, kLegendColumn = 290;
constexpr double kLeastWidth = 640, kCharacterWidth = 6.2;
constexpr double kMarker = 4;

// Colours that the colour-blind tell apart as well [Okabe, Ito 2008]; each with a marker of its own.
constexpr std::array kColours{"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"};

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&': result += "&amp;"; break;
      case '<': result += "&lt;"; break;
      case '>': result += "&gt;"; break;
      case '"': result += "&quot;"; break;
      default: result += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;  // XML has no control characters
    }
  }
  return result;
}

std::string pixels(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f", value);
  return text;
}

/// The words of a text in lines of at most `length` characters; longer words stand alone.
std::vector<std::string> wrapped(const std::string& text, std::size_t length) {
  std::vector<std::string> lines{""};
  std::istringstream words(text);
  for (std::string word; words >> word;) {
    if (!lines.back().empty() && lines.back().size() + 1 + word.size() > length) lines.emplace_back();
    lines.back() += (lines.back().empty() ? "" : " ") + word;
  }
  return lines;
}

enum class Anchor { Start, Middle, End };

struct TextStyle {
  int size = 11;
  Anchor anchor = Anchor::Start;
  bool bold = false;
  bool upwards = false;
};

class Drawing {
 public:
  void rectangle(PlotPoint corner, PlotPoint size, const std::string& style) {
    out_ << "<rect x=\"" << pixels(corner.x) << "\" y=\"" << pixels(corner.y) << "\" width=\"" << pixels(size.x)
         << "\" height=\"" << pixels(size.y) << "\" " << style << "/>\n";
  }

  void line(PlotPoint from, PlotPoint to, const std::string& style) {
    out_ << "<line x1=\"" << pixels(from.x) << "\" y1=\"" << pixels(from.y) << "\" x2=\"" << pixels(to.x) << "\" y2=\""
         << pixels(to.y) << "\" " << style << "/>\n";
  }

  void polyline(const std::vector<PlotPoint>& points, const std::string& style) {
    out_ << "<polyline points=\"";
    for (std::size_t i = 0; i < points.size(); ++i)
      out_ << (i == 0 ? "" : " ") << pixels(points[i].x) << ',' << pixels(points[i].y);
    out_ << "\" fill=\"none\" " << style << "/>\n";
  }

  void text(PlotPoint at, const std::string& text, const TextStyle& style) {
    constexpr std::array kAnchors{"start", "middle", "end"};
    out_ << "<text x=\"" << pixels(at.x) << "\" y=\"" << pixels(at.y) << "\" font-size=\"" << style.size
         << "\" text-anchor=\"" << kAnchors[static_cast<std::size_t>(style.anchor)] << '"';
    if (style.bold) out_ << " font-weight=\"bold\"";
    if (style.upwards) out_ << " transform=\"rotate(-90 " << pixels(at.x) << ' ' << pixels(at.y) << ")\"";
    out_ << '>' << escaped(text) << "</text>\n";
  }

  /// One of as many shapes as there are colours.
  void marker(PlotPoint at, std::size_t kind) {
    const std::string fill = std::string("fill=\"") + kColours[kind % kColours.size()] + '"';
    if (kind % kColours.size() == 0) {
      out_ << "<circle cx=\"" << pixels(at.x) << "\" cy=\"" << pixels(at.y) << "\" r=\"" << pixels(kMarker) << "\" "
           << fill << "/>\n";
      return;
    }
    out_ << "<polygon points=\"";
    for (const PlotPoint& corner : corners(kind % kColours.size()))
      out_ << pixels(at.x + kMarker * corner.x) << ',' << pixels(at.y + kMarker * corner.y) << ' ';
    out_ << "\" " << fill << "/>\n";
  }

  std::string take(double width, double height) const {
    std::ostringstream document;
    document << "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\" "
             << "width=\"" << pixels(width) << "\" height=\"" << pixels(height) << "\" viewBox=\"0 0 " << pixels(width)
             << ' ' << pixels(height) << "\" font-family=\"sans-serif\">\n"
             << "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n"
             << out_.str() << "</svg>\n";
    return document.str();
  }

 private:
  static std::vector<PlotPoint> corners(std::size_t kind) {
    switch (kind) {
      case 1: return {{-.9, -.9}, {.9, -.9}, {.9, .9}, {-.9, .9}};       // square
      case 2: return {{0, -1.2}, {1.1, .8}, {-1.1, .8}};                 // triangle
      case 3: return {{0, -1.3}, {1.3, 0}, {0, 1.3}, {-1.3, 0}};         // diamond
      case 4: return {{0, 1.2}, {1.1, -.8}, {-1.1, -.8}};                // triangle upside down
      case 5: return {{-1.3, -.5}, {1.3, -.5}, {1.3, .5}, {-1.3, .5}};   // bar
      default: return {{-.5, -1.3}, {.5, -1.3}, {.5, 1.3}, {-.5, 1.3}};  // post
    }
  }

  std::ostringstream out_;
};

std::string stroke_of(const PlotSeries& series, std::size_t kind) {
  return std::string("stroke=\"") + kColours[kind % kColours.size()] + "\" stroke-width=\"2\"" +
         (series.stroke == Stroke::Dashed ? " stroke-dasharray=\"6 4\"" : "");
}

AxisRange range_of(const Panel& panel, const Axis& axis, double PlotPoint::*coordinate) {
  std::vector<double> values;
  for (const PlotSeries& series : panel.series)
    for (const PlotPoint& point : series.points) values.push_back(point.*coordinate);
  return {axis, values};
}

class Painter {
 public:
  explicit Painter(const Figure& figure) : figure_(figure) {
    if (figure.panels.empty()) throw std::invalid_argument("a plot without panels");
    for (const Panel& panel : figure.panels)
      for (const PlotSeries& series : panel.series)
        if (find(series.name) == legend_.size()) legend_.push_back(&series);
    columns_ = figure.columns > 0 ? std::min(figure.columns, figure.panels.size()) : figure.panels.size();
    width_ = std::max(kLeastWidth, 2 * kMargin + kPanelWidth * static_cast<double>(columns_));
  }

  std::string paint() {
    draw_heading();
    for (std::size_t i = 0; i < figure_.panels.size(); ++i)
      draw_panel(figure_.panels[i], {kMargin + kPanelWidth * static_cast<double>(i % columns_),
                                     y_ + kPanelHeight * static_cast<double>(i / columns_)});
    y_ += kPanelHeight * static_cast<double>((figure_.panels.size() + columns_ - 1) / columns_);
    draw_legend();
    return drawing_.take(width_, y_ + kMargin);
  }

 private:
  std::size_t find(const std::string& name) const {
    const auto same = [&](const PlotSeries* series) { return series->name == name; };
    return static_cast<std::size_t>(std::find_if(legend_.begin(), legend_.end(), same) - legend_.begin());
  }

  void draw_heading() {
    y_ = kMargin + 16;
    drawing_.text({kMargin, y_}, figure_.title, {16, Anchor::Start, true});
    y_ += kTitleHeight - 12;
    const auto length = static_cast<std::size_t>((width_ - 2 * kMargin) / kCharacterWidth);
    for (const std::string& note : figure_.notes)
      for (const std::string& line : wrapped(note, length)) {
        drawing_.text({kMargin, y_}, line, {});
        y_ += kLineHeight;
      }
    y_ += kMargin / 2;
  }

  void draw_panel(const Panel& panel, PlotPoint corner) {
    const AxisRange x = range_of(panel, panel.x, &PlotPoint::x), y = range_of(panel, panel.y, &PlotPoint::y);
    const PlotPoint origin{corner.x + kLeft, corner.y + kPanelHeight - kBottom};
    const PlotPoint size{kPanelWidth - kLeft - kRight, kPanelHeight - kTop - kBottom};
    drawing_.text({origin.x + size.x / 2, corner.y + kTop - 9}, panel.title, {13, Anchor::Middle, true});
    for (const Tick& tick : x.ticks()) draw_x_tick(origin.x + size.x * x.place(tick.value), origin.y, size.y, tick);
    for (const Tick& tick : y.ticks()) draw_y_tick(origin.y - size.y * y.place(tick.value), origin.x, size.x, tick);
    drawing_.rectangle({origin.x, origin.y - size.y}, size, "fill=\"none\" stroke=\"#444444\"");
    drawing_.text({origin.x + size.x / 2, origin.y + 36}, panel.x.label, {12, Anchor::Middle});
    drawing_.text({corner.x + 14, origin.y - size.y / 2}, panel.y.label, {12, Anchor::Middle, false, true});
    for (const PlotSeries& series : panel.series) {
      std::vector<PlotPoint> points;
      for (const PlotPoint& point : series.points)
        points.push_back({origin.x + size.x * x.place(point.x), origin.y - size.y * y.place(point.y)});
      draw_series(series, points);
    }
  }

  void draw_x_tick(double x, double bottom, double height, const Tick& tick) {
    drawing_.line({x, bottom - height}, {x, bottom}, "stroke=\"#dddddd\"");
    drawing_.line({x, bottom}, {x, bottom + 4}, "stroke=\"#444444\"");
    drawing_.text({x, bottom + 17}, tick.label, {11, Anchor::Middle});
  }

  void draw_y_tick(double y, double left, double width, const Tick& tick) {
    drawing_.line({left, y}, {left + width, y}, "stroke=\"#dddddd\"");
    drawing_.line({left - 4, y}, {left, y}, "stroke=\"#444444\"");
    drawing_.text({left - 7, y + 4}, tick.label, {11, Anchor::End});
  }

  void draw_series(const PlotSeries& series, const std::vector<PlotPoint>& points) {
    const std::size_t kind = find(series.name);
    if (series.stroke != Stroke::None && points.size() > 1) drawing_.polyline(points, stroke_of(series, kind));
    if (!series.markers) return;
    for (const PlotPoint& point : points) drawing_.marker(point, kind);
  }

  void draw_legend() {
    const auto columns = std::max(std::size_t{1}, static_cast<std::size_t>((width_ - 2 * kMargin) / kLegendColumn));
    for (std::size_t i = 0; i < legend_.size(); ++i) {
      const PlotSeries& series = *legend_[i];
      const PlotPoint at{kMargin + 4 + kLegendColumn * static_cast<double>(i % columns),
                         y_ + kLegendHeight * static_cast<double>(i / columns)};
      draw_series({series.name, {}, series.stroke, false}, {at, {at.x + 26, at.y}});
      if (series.markers) drawing_.marker({at.x + 13, at.y}, i);
      drawing_.text({at.x + 34, at.y + 4}, series.name, {12});
    }
    y_ += kLegendHeight * static_cast<double>((legend_.size() + columns - 1) / columns);
  }

  const Figure& figure_;
  std::vector<const PlotSeries*> legend_;
  Drawing drawing_;
  std::size_t columns_ = 1;
  double width_ = 0, y_ = 0;
};

}  // namespace

std::string render_svg(const Figure& figure) { return Painter(figure).paint(); }

void write_svg(const Figure& figure, const std::filesystem::path& path) {
  std::ofstream file(path, std::ios::binary);
  file << render_svg(figure);
  if (!file.flush()) throw std::runtime_error("cannot write '" + path.string() + "'");
}

}  // namespace tetloom::bench
