#include "bench/support/svg_plot.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/temporary_folder.hpp"

using namespace tetloom;
using namespace tetloom::bench;

namespace {

/// A reader of XML that knows elements, attributes, text and the predefined entities, and what must not be.
class XmlReader {
 public:
  explicit XmlReader(std::string text) : text_(std::move(text)) {}

  /// Why the text is not well-formed; empty where it is.
  std::string fault() {
    if (text_.rfind("<?xml", 0) != 0) return "no declaration";
    at_ = text_.find("?>") + 2;
    while (at_ < text_.size()) {
      const std::string why = text_[at_] == '<' ? read_tag() : read_text("<");
      if (!why.empty()) return why + " at " + text_.substr(at_, 40);
    }
    return open_.empty() && roots_ == 1 ? "" : "not one closed root";
  }
  std::size_t count(const std::string& name) const {
    return static_cast<std::size_t>(std::count(elements_.begin(), elements_.end(), name));
  }

 private:
  std::string read_text(const char* ends) {
    for (; at_ < text_.size() && std::string(ends).find(text_[at_]) == std::string::npos; ++at_) {
      const char c = text_[at_];
      if (c == '<') return "a bare <";
      if (static_cast<unsigned char>(c) < 0x20 && c != '\n') return "a control character";
      if (open_.empty() && c != '\n') return "text outside of the root";
      if (c == '&' && !starts_entity()) return "a bare &";
    }
    return "";
  }

  bool starts_entity() const {
    for (const char* entity : {"&amp;", "&lt;", "&gt;", "&quot;"})
      if (text_.compare(at_, std::string(entity).size(), entity) == 0) return true;
    return false;
  }

  std::string read_tag() {
    const bool closes = text_[at_ + 1] == '/';
    at_ += closes ? 2 : 1;
    const std::string name = read_name();
    if (name.empty()) return "a tag without a name";
    if (closes) {
      if (open_.empty() || open_.back() != name) return "closes what is not open";
      open_.pop_back();
      return text_[at_++] == '>' ? "" : "a bad end tag";
    }
    roots_ += open_.empty();
    open_.push_back(name);
    elements_.push_back(name);
    return read_attributes();
  }

  std::string read_attributes() {
    std::vector<std::string> names;
    for (;;) {
      while (at_ < text_.size() && text_[at_] == ' ') ++at_;
      if (text_.compare(at_, 2, "/>") == 0) return open_.pop_back(), at_ += 2, "";
      if (text_[at_] == '>') return ++at_, "";
      names.push_back(read_name());
      if (names.back().empty() || std::count(names.begin(), names.end(), names.back()) > 1) return "a bad attribute";
      if (text_.compare(at_, 2, "=\"") != 0) return "an attribute without a value";
      at_ += 2;
      const std::string why = read_text("\"");
      if (!why.empty()) return why;
      ++at_;
    }
  }

  std::string read_name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (std::isalnum(static_cast<unsigned char>(text_[at_])) || text_[at_] == '-')) ++at_;
    return text_.substr(begin, at_ - begin);
  }

  std::string text_;
  std::size_t at_ = 0, roots_ = 0;
  std::vector<std::string> open_, elements_;
};

Panel panel_of(std::vector<PlotSeries> series) {
  return {"cube", {"threads", Scale::Log, {{1, "1"}, {2, "2"}}}, {"speed-up"}, std::move(series)};
}

Figure figure_of(std::vector<Panel> panels) { return {"Speed", {"machine", "commit"}, std::move(panels)}; }

std::size_t occurrences(const std::string& text, const std::string& part) {
  std::size_t count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

}  // namespace

TEST_CASE("a figure is well-formed and shows every series, marker, tick and label") {
  const Figure figure =
      figure_of({panel_of({{"volume", {{1, 1}, {2, 1.7}}}, {"ideal", {{1, 1}, {2, 2}}, Stroke::Dashed, false}}),
                 panel_of({{"volume", {{1, 1}, {2, 1.9}}, Stroke::None}})});
  const std::string svg = render_svg(figure);
  XmlReader reader(svg);
  CHECK(reader.fault() == "");
  CHECK(reader.count("svg") == 1);
  // The first panel's two lines, and two in the legend.
  CHECK(reader.count("polyline") == 4);
  CHECK(occurrences(svg, "stroke-dasharray") == 2);
  // Two markers in each panel, one in the legend; "ideal" has none.
  CHECK(reader.count("circle") == 5);
  for (const char* text : {"Speed", "machine", "commit", "ideal"})
    CHECK(occurrences(svg, std::string(">") + text) == 1);
  CHECK(occurrences(svg, ">volume<") == 1);  // one legend for both panels
  CHECK(occurrences(svg, ">cube<") == 2);
  CHECK(occurrences(svg, ">speed-up<") == 2);
  CHECK(render_svg(figure) == svg);
}

TEST_CASE("points lie where their values are") {
  const std::string svg = render_svg(figure_of({{"",
                                                 {"x", Scale::Linear, {{0, "0"}, {10, "10"}}},
                                                 {"y", Scale::Linear, {{0, "0"}, {10, "10"}}},
                                                 {{"a", {{0, 0}, {5, 10}, {10, 5}}}}}}));
  double x[3], y[3];
  const std::size_t at = svg.find("<polyline points=\"");
  REQUIRE(at != std::string::npos);
  REQUIRE(std::sscanf(svg.c_str() + at, "<polyline points=\"%lf,%lf %lf,%lf %lf,%lf", &x[0], &y[0], &x[1], &y[1], &x[2],
                      &y[2]) == 6);
  CHECK(x[1] == Approx((x[0] + x[2]) / 2));
  CHECK(x[2] > x[0] + 200);
  CHECK(y[2] == Approx((y[0] + y[1]) / 2));
  CHECK(y[1] < y[0] - 100);  // upwards
}

TEST_CASE("panels stand in as many columns as asked") {
  const std::vector<Panel> panels(3, panel_of({{"a", {{1, 1}}}}));
  const auto extent = [&](std::size_t columns, const char* attribute) {
    Figure figure = figure_of(panels);
    figure.columns = columns;
    const std::string svg = render_svg(figure);
    return std::stod(svg.substr(svg.find(attribute) + std::string(attribute).size()));
  };
  const char *width = " width=\"", *height = " height=\"";
  CHECK(extent(0, width) == extent(3, width));
  CHECK(extent(9, height) == extent(3, height));
  CHECK(extent(2, width) < extent(3, width));
  const double row = extent(2, height) - extent(3, height);
  CHECK(row > 200);
  CHECK(extent(1, height) == Approx(extent(3, height) + 2 * row));
}

TEST_CASE("texts of any kind leave a figure well-formed") {
  const std::string odd = "a < b & \"c\" > d\nwith \x01 control, and µs";
  Panel panel = panel_of({{odd, {{1, 1}}}});
  panel.title = panel.x.label = panel.y.label = panel.x.ticks[0].label = odd;
  const std::string svg = render_svg({odd, {odd, std::string(500, 'w'), ""}, {panel}});
  CHECK(XmlReader(svg).fault() == "");
  CHECK(occurrences(svg, "a &lt; b &amp; &quot;c&quot; &gt; d") >= 6);
}

TEST_CASE("more series than colours are drawn") {
  std::vector<PlotSeries> series;
  for (int i = 0; i < 20; ++i) series.push_back({"series " + std::to_string(i), {{1, 1.0 + i}, {2, 2.0 + i}}});
  const std::string svg = render_svg(figure_of({panel_of(series)}));
  XmlReader reader(svg);
  CHECK(reader.fault() == "");
  CHECK(reader.count("polyline") == 40);
  CHECK(reader.count("circle") + reader.count("polygon") == 60);
}

TEST_CASE("a figure of nothing is refused, and so is a file that cannot be written") {
  CHECK_THROWS_AS(render_svg(figure_of({})), std::invalid_argument);
  CHECK_THROWS_AS(render_svg(figure_of({panel_of({})})), std::invalid_argument);
  CHECK_THROWS_AS(render_svg(figure_of({panel_of({{"a", {{1, NAN}}}})})), std::invalid_argument);
  CHECK_THROWS_AS(render_svg(figure_of({panel_of({{"a", {{0, 1}}}})})), std::invalid_argument);
  const Figure good = figure_of({panel_of({{"a", {{1, 1}}}})});
  CHECK_THROWS_AS(write_svg(good, "/no/such/folder/figure.svg"), std::runtime_error);
  const test::TemporaryFolder folder;
  write_svg(good, folder / "figure.svg");
  CHECK(test::file_content(folder / "figure.svg") == render_svg(good));
}
