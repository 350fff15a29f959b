#include "apps/tetloom/parts_text.hpp"

#include <algorithm>
#include <functional>
#include <numeric>

#include "apps/tetloom/quantities.hpp"
#include "apps/tetloom/text_table.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;
using Row = PartsFigures::Row;

constexpr std::size_t kMostPartRows = 32;
constexpr std::size_t kWorstRows = 5;

double boundary_share(const Row& row) {
  return row.vertices == 0 ? 0 : static_cast<double>(row.shared_vertices) / static_cast<double>(row.vertices);
}

/// Whether the weights say something that the numbers of elements do not.
bool has_weights(const PartsFigures& figures) {
  return std::any_of(figures.parts.begin(), figures.parts.end(),
                     [](const Row& row) { return row.weight != static_cast<double>(row.elements); });
}

std::string count_text(std::int64_t count) { return format_count(static_cast<std::uint64_t>(count)); }

std::vector<std::string> cells_of(const Row& row, const std::string& name, bool weights) {
  return {name,
          count_text(row.elements),
          count_text(row.vertices),
          format_share(boundary_share(row)),
          count_text(row.neighbours),
          weights ? format_number(row.weight) : ""};
}

/// One value of every part, reduced to a row that reads like a part's.
std::vector<std::string> range_row(const PartsFigures& figures, const std::string& name, bool weights,
                                   const std::function<double(const std::vector<double>&)>& reduce) {
  const auto column = [&](const std::function<double(const Row&)>& value) {
    std::vector<double> values(figures.parts.size());
    std::transform(figures.parts.begin(), figures.parts.end(), values.begin(), value);
    return reduce(values);
  };
  return {name,
          format_number(column([](const Row& row) { return static_cast<double>(row.elements); })),
          format_number(column([](const Row& row) { return static_cast<double>(row.vertices); })),
          format_share(column(boundary_share)),
          format_number(column([](const Row& row) { return static_cast<double>(row.neighbours); })),
          weights ? format_number(column([](const Row& row) { return row.weight; })) : ""};
}

std::vector<std::size_t> worst_parts(const PartsFigures& figures) {
  std::vector<std::size_t> order(figures.parts.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  const auto worse = [&](std::size_t a, std::size_t b) {
    const Row &of_a = figures.parts[a], &of_b = figures.parts[b];
    return of_a.weight != of_b.weight ? of_a.weight > of_b.weight : a < b;
  };
  std::partial_sort(order.begin(), order.begin() + kWorstRows, order.end(), worse);
  order.resize(kWorstRows);
  return order;
}

std::vector<std::vector<std::string>> rows_of(const PartsFigures& figures, bool weights) {
  std::vector<std::vector<std::string>> rows;
  if (figures.parts.size() <= kMostPartRows) {
    for (std::size_t part = 0; part < figures.parts.size(); ++part)
      rows.push_back(cells_of(figures.parts[part], std::to_string(part), weights));
    return rows;
  }
  rows.push_back(range_row(figures, "least", weights,
                           [](const auto& values) { return *std::min_element(values.begin(), values.end()); }));
  rows.push_back(range_row(figures, "mean", weights, [](const auto& values) {
    return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
  }));
  rows.push_back(range_row(figures, "most", weights,
                           [](const auto& values) { return *std::max_element(values.begin(), values.end()); }));
  for (const std::size_t part : worst_parts(figures))
    rows.push_back(cells_of(figures.parts[part], std::to_string(part), weights));
  return rows;
}

}  // namespace

std::string render_parts(const PartsFigures& figures) {
  const bool weights = has_weights(figures);
  std::string text = render_table({"part", "elements", "vertices", "on boundary", "neighbours", "weight"},
                                  rows_of(figures, weights), kMostPartRows);
  text += "  imbalance  elements " + format_share(figures.element_imbalance) + ", vertices " +
          format_share(figures.vertex_imbalance);
  if (weights) text += ", weights " + format_share(figures.weight_imbalance);
  return text + "\n  cut        " + count_text(figures.cut_faces) + " faces between " + count_text(figures.edges) +
         (figures.edges == 1 ? " pair of parts\n" : " pairs of parts\n");
}

nlohmann::ordered_json parts_json(const PartsFigures& figures) {
  Json table = Json::array();
  for (std::size_t part = 0; part < figures.parts.size(); ++part) {
    const Row& row = figures.parts[part];
    table.push_back({{"part", part},
                     {"elements", row.elements},
                     {"vertices", row.vertices},
                     {"boundary_share", boundary_share(row)},
                     {"neighbours", row.neighbours},
                     {"weight", row.weight}});
  }
  return {{"elements", figures.elements},
          {"vertices", figures.vertices},
          {"cut_faces", figures.cut_faces},
          {"edges", figures.edges},
          {"imbalance",
           {{"elements", figures.element_imbalance},
            {"vertices", figures.vertex_imbalance},
            {"weights", figures.weight_imbalance}}},
          {"table", std::move(table)}};
}

}  // namespace tetloom::app
