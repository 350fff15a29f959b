#include "apps/tetloom/console.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/tetloom/quantities.hpp"

namespace tetloom::app {
namespace {

constexpr std::size_t kMostEntitiesShown = 12;
constexpr double kHistogramWidth = 40;

/// "  label      text\n", with all texts in one column.
std::string row(const std::string& label, const std::string& text) {
  std::string line = "  " + label;
  line.resize(std::max<std::size_t>(line.size() + 1, 13), ' ');
  return line + text + "\n";
}

std::string plural(std::uint64_t count, const std::string& singular) {
  return format_count(count) + " " + singular + (count == 1 ? "" : "s");
}

std::string tet_rows(const TetQuality& tets) {
  std::string text = row("shape", "mean ratio " + format_number(std::round(1e3 * tets.mean_ratio_mean) / 1e3) +
                                      " on average, " + format_number(std::round(1e3 * tets.mean_ratio_p1) / 1e3) +
                                      " at the first percentile, at least " +
                                      format_number(std::round(1e3 * tets.mean_ratio_min) / 1e3));
  text += row("", "smallest dihedral angle " + format_number(std::round(100 * tets.min_dihedral_deg) / 100) + "°");
  if (tets.inverted > 0) text += row("", plural(tets.inverted, "tet") + " of no positive volume");
  text += "  tets by mean ratio (1 is regular):\n";
  return text + render_histogram(tets.mean_ratio_histogram.data(), tets.mean_ratio_histogram.size(), 0, 1);
}

// Tets with smaller angles than asked for, and what forces them.
std::string acute_row(const QualityGoals& goals, const tets::OptimizeReport& optimizer) {
  if (optimizer.acute_tets.empty()) return {};
  std::string text = plural(optimizer.below_dihedral, "tet") + " below " + format_number(goals.dihedral) +
                     "°, the surface forces " + format_count(optimizer.forced) + ": " +
                     format_count(optimizer.forced_by_angles) + " by angles, " +
                     format_count(optimizer.forced_by_triangles) + " by triangles, " +
                     format_count(optimizer.forced_by_points) + " by close points; the worst";
  const AcuteTet& worst = optimizer.acute_tets.front();
  const char* separator = " on ";
  for (const NamedEntity& entity : worst.entities) text += separator + describe(entity), separator = ", ";
  const Vec3& p = worst.point;
  text += " near (" + format_number(p.x) + ", " + format_number(p.y) + ", " + format_number(p.z) + ")";
  return row("angles", text);
}

std::string triangle_rows(const TriangleQuality& triangles) {
  return row("surface", "triangle quality " + format_number(std::round(1e3 * triangles.shape_mean) / 1e3) +
                            " on average, at least " + format_number(std::round(1e3 * triangles.shape_min) / 1e3) +
                            "; smallest angle " + format_number(std::round(100 * triangles.min_angle_deg) / 100) + "°");
}

std::string size_row(const EdgeConformity& edges) {
  if (edges.mean_length_ratio <= 0) return row("edges", "mean length " + format_number(edges.mean_length));
  return row("edges", format_share(edges.in_band) + " within [0.71, 1.41] of the size asked for; mean length " +
                          format_number(std::round(1e3 * edges.mean_length_ratio) / 1e3) + " of it");
}

std::string volume_row(const RunReport& report) {
  const CurvedQuality& curved = report.quality->curved;
  const double mesh = curved.count > 0 ? curved.volume : report.quality->cells.volume;
  if (!report.model_volume || !(*report.model_volume > 0)) return row("volume", format_number(mesh));
  const double off = (mesh - *report.model_volume) / *report.model_volume;
  return row("volume", format_number(mesh) + ", the model's is " + format_number(*report.model_volume) + " (" +
                           format_share(std::abs(off)) + (off < 0 ? " less)" : " more)"));
}

std::string time_row(const RunReport& report) {
  const RunSeconds& seconds = report.seconds;
  std::string text = format_seconds(report.total_seconds()) + " in all: read " + format_seconds(seconds.read) +
                     ", size field " + format_seconds(seconds.size_field) + ", surface " +
                     format_seconds(seconds.surface);
  if (seconds.volume > 0) text += ", volume " + format_seconds(seconds.volume);
  if (seconds.layers > 0) text += ", layers " + format_seconds(seconds.layers);
  if (seconds.second_order > 0) text += ", second order " + format_seconds(seconds.second_order);
  return row("time", text + ", write " + format_seconds(seconds.write));
}

}  // namespace

std::string render_diagnostic(std::string_view kind, const Diagnostic& diagnostic) {
  std::string text = std::string(kind) + ": " + diagnostic.message + "\n";
  if (!diagnostic.entities.empty()) {
    text += "  on " + describe(diagnostic.entities[0]);
    const std::size_t shown = std::min(diagnostic.entities.size(), kMostEntitiesShown);
    for (std::size_t i = 1; i < shown; ++i) text += ", " + describe(diagnostic.entities[i]);
    if (diagnostic.entities.size() > shown) {
      text += " and " + std::to_string(diagnostic.entities.size() - shown) + " more";
    }
    text += "\n";
  }
  if (diagnostic.point) {
    const Vec3& p = *diagnostic.point;
    text += "  near (" + format_number(p.x) + ", " + format_number(p.y) + ", " + format_number(p.z) + ")\n";
  }
  return text;
}

std::string render_histogram(const std::size_t* bins, std::size_t count, double low, double high) {
  const std::size_t most = std::max<std::size_t>(1, *std::max_element(bins, bins + count));
  std::string text;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<char, 64> label{};
    const double width = (high - low) / static_cast<double>(count);
    std::snprintf(label.data(), label.size(), "    %4.3g to %4.3g  %12s  ", low + width * static_cast<double>(i),
                  low + width * static_cast<double>(i + 1), format_count(bins[i]).c_str());
    const double length = kHistogramWidth * static_cast<double>(bins[i]) / static_cast<double>(most);
    // What is there but too little for a whole mark still shows.
    const std::string bar = bins[i] == 0 ? "" : length < 0.5 ? "." : std::string(std::lround(length), '#');
    std::string line = label.data() + bar;
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n";
  }
  return text;
}

std::string render_quality(const RunReport& report) {
  if (!report.quality) return {};
  const QualityReport& quality = *report.quality;
  std::string text;
  if (quality.tets.count > 0) text += tet_rows(quality.tets);
  if (quality.triangles.count > 0) text += triangle_rows(quality.triangles);
  if (quality.tets.count + quality.triangles.count > 0) {
    text += size_row(quality.tets.count > 0 ? quality.tets.edges : quality.triangles.edges);
  }
  const CellQuality& cells = quality.cells;
  if (cells.inverted > quality.tets.inverted)
    text +=
        row("", plural(cells.inverted - quality.tets.inverted, "other cell") + " with a corner of no positive volume");
  if (cells.count > quality.tets.count)
    text += row("cells", plural(cells.count - quality.tets.count, "other cell") + ", scaled Jacobian at least " +
                             format_number(std::round(1e3 * cells.min_scaled_jacobian) / 1e3) + ", 99 % above " +
                             format_number(std::round(1e3 * cells.scaled_jacobian_p1) / 1e3));
  if (quality.curved.count > 0)
    text += row("curved", plural(quality.curved.count, "cell") + ", the least Jacobian is " +
                              format_number(std::round(1e3 * quality.curved.min_scaled_jacobian) / 1e3) +
                              " of the straight one's");
  if (cells.count > 0) text += volume_row(report);
  return text;
}

// Mid nodes beside the model, where there are any.
std::string off_model_row(const RunReport& report) {
  if (!report.extra.contains("second_order")) return {};
  const auto& second_order = report.extra["second_order"];
  const auto count = second_order["off_model_count"].get<std::uint64_t>();
  if (count == 0) return {};
  return row("", plural(count, "mid node") + " of " + format_count(second_order["mid_nodes"].get<std::uint64_t>()) +
                     " do not lie on the model, so that all cells are valid");
}

// Cells of boundary layers and how much of them there is.
std::string layers_row(const RunReport& report) {
  if (!report.extra.contains("layers")) return {};
  const auto& layers = report.extra["layers"];
  const auto count = [&](const char* kind) { return layers["cells"][kind].get<std::uint64_t>(); };
  const auto percent = [&](const char* share) {
    return format_number(std::round(1e3 * layers[share].get<double>()) / 10) + " %";
  };
  return row("layers", plural(count("prisms"), "prism") + ", " + plural(count("pyramids"), "pyramid") + ", " +
                           plural(count("tets"), "tet") + "; all layers on " + percent("full_count") +
                           " of the walls, one at least on " + percent("at_least_one") + ", " + percent("thickness") +
                           " of the thickness");
}

// What was too small for the mesh, where anything was.
std::string small_features_row(const RunReport& report) {
  if (!report.extra.contains("small_features")) return {};
  const auto& features = report.extra["small_features"];
  const auto count = [&](const char* kind) { return features[kind].get<std::uint64_t>(); };
  if (count("faces") + count("edges") + count("vertices") == 0) return {};
  return row("features", plural(count("faces"), "face") + " and " + plural(count("edges"), "edge") +
                             " of the model are too small for the mesh, which is at most " +
                             format_number(features["largest_distance"].get<double>()) + " from them");
}

std::string render_summary(const RunReport& report, const std::string& output, const std::string& report_file) {
  std::string text = plural(report.counts.points, "point") + ", " + plural(report.counts.triangles, "triangle");
  if (report.counts.tets > 0) {
    text += ", " + plural(report.counts.tets, "tet") + " in " + plural(report.counts.regions, "region");
  }
  text += "\n" + render_quality(report) + off_model_row(report) + layers_row(report) + small_features_row(report) +
          acute_row(report.goals, report.optimizer) + time_row(report);
  text += row("memory", format_bytes(static_cast<double>(peak_bytes())) + " at most, " +
                            plural(static_cast<std::uint64_t>(report.threads), "thread"));
  if (!report.warnings.empty()) text += row("warnings", std::to_string(report.warnings.size()) + ", see above");
  return text + row("written", output + (report_file.empty() ? "" : ", " + report_file));
}

void print(std::FILE* stream, std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stream);
  std::fflush(stream);
}

}  // namespace tetloom::app
