#include "bench/support/real_table.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>

namespace tetloom::bench {
namespace {

constexpr double kSharpAngle = 5, kFlatAngle = 1;  // degrees
constexpr std::uint64_t kLargeMesh = 5'000'000;    // tets of a mesh that may take longer

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof(text), format, value);
  return text;
}

std::string percent(double share) { return formatted("%.0f %%", 100 * share); }

/// Both values with a slash between them; "-" for those that are not there.
std::string both(const std::optional<double>& a, const std::optional<double>& b, const char* format,
                 double factor = 1) {
  const auto text = [&](const std::optional<double>& value) {
    return value ? formatted(format, factor * *value) : std::string("-");
  };
  return text(a) + " / " + text(b);
}

std::string of(std::size_t count, std::size_t all) { return std::to_string(count) + " of " + std::to_string(all); }

bool has_tets(const RealModel& model) { return is_valid(model) && model.tetloom.mesh->tets > 0; }

/// Of every model that `counts` picks.
std::vector<double> values_of(std::span<const RealModel> models, const std::function<bool(const RealModel&)>& counts,
                              const std::function<double(const RealModel&)>& value) {
  std::vector<double> values;
  for (const RealModel& model : models)
    if (counts(model)) values.push_back(value(model));
  return values;
}

std::size_t count_of(std::span<const RealModel> models, const std::function<bool(const RealModel&)>& counts) {
  return static_cast<std::size_t>(std::count_if(models.begin(), models.end(), counts));
}

std::optional<double> largest(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  return *std::max_element(values.begin(), values.end());
}

double speed_ratio(const RealModel& model) { return model.tetloom.tets_per_second() / model.gmsh->tets_per_second(); }

double size_field_share(const RealModel& model) { return model.stages.size_field / model.stages.total; }

double angle_of(const RealModel& model) { return model.tetloom.mesh->min_dihedral_deg; }

SummaryRow valid_row(std::span<const RealModel> models) {
  const std::size_t valid = count_of(models, is_valid);
  std::string value = of(valid, models.size());
  const std::size_t beside = count_of(models, [](const RealModel& model) { return model.gmsh.has_value(); });
  if (beside > 0) value += " (Gmsh " + of(count_of(models, is_gmsh_valid), beside) + ")";
  return {"valid, every solid filled, volume within 1 %", value, "all but the truly invalid", valid == models.size()};
}

SummaryRow longest_row(std::span<const RealModel> models) {
  const RealModel* slowest = nullptr;
  for (const RealModel& model : models) {
    const bool may_take_long = model.tetloom.mesh && model.tetloom.mesh->tets > kLargeMesh;
    if (!may_take_long && (slowest == nullptr || model.tetloom.seconds > slowest->tetloom.seconds)) slowest = &model;
  }
  if (slowest == nullptr) return {"longest run", "-", "<= 30 s", true};
  const std::string value = (slowest->tetloom.timed_out ? "> " : "") + formatted("%.1f s", slowest->tetloom.seconds);
  return {"longest run", value + ", " + slowest->name, "<= 30 s", slowest->tetloom.seconds <= 30};
}

SummaryRow speed_row(std::span<const RealModel> models) {
  const std::vector<double> ratios = values_of(models, can_compare, speed_ratio);
  const std::string measure = "tets/s against Gmsh, median / slower than it", target = ">= 8 / none";
  if (ratios.empty()) return {measure, "-", target, true};
  const auto slower =
      static_cast<std::size_t>(std::count_if(ratios.begin(), ratios.end(), [](double ratio) { return ratio < 1; }));
  return {measure, formatted("%.2f", *median(ratios)) + " / " + of(slower, ratios.size()), target,
          *median(ratios) >= 8 && slower == 0};
}

SummaryRow time_row(std::span<const RealModel> models) {
  const auto ratio = [](const RealModel& model) { return model.tetloom.seconds / model.gmsh->seconds; };
  const std::optional<double> middle = median(values_of(models, can_compare, ratio));
  return {"wall time against Gmsh, median", middle ? formatted("%.2f", *middle) : "-", "<= .25",
          !middle || *middle <= .25};
}

SummaryRow size_field_row(std::span<const RealModel> models) {
  const auto timed = [](const RealModel& model) {
    return model.stages.total > 0 && (model.tetloom.exit_status == 0 || model.tetloom.timed_out);
  };
  const std::vector<double> shares = values_of(models, timed, size_field_share);
  const std::optional<double> middle = median(shares), most = largest(shares);
  return {"size field's share of the run, median / largest", both(middle, most, "%.0f %%", 100), "<= 15 / <= 30 %",
          !middle || (*middle <= .15 && *most <= .30)};
}

SummaryRow angle_row(std::span<const RealModel> models) {
  const std::vector<double> angles = values_of(models, has_tets, angle_of);
  const std::string measure = "smallest dihedral < 5 / < 1 degrees, models", target = "<= 5 / 0 %";
  if (angles.empty()) return {measure, "-", target, true};
  const auto share = [&](double bound) {
    const auto below = std::count_if(angles.begin(), angles.end(), [&](double angle) { return angle < bound; });
    return static_cast<double>(below) / static_cast<double>(angles.size());
  };
  return {measure, percent(share(kSharpAngle)) + " / " + percent(share(kFlatAngle)), target,
          share(kSharpAngle) <= .05 && share(kFlatAngle) == 0};
}

SummaryRow ratio_row(std::span<const RealModel> models) {
  const auto mean_of = [](const RealModel& model) { return model.tetloom.mesh->ratio_mean; };
  const auto p1_of = [](const RealModel& model) { return model.tetloom.mesh->ratio_p1; };
  const std::optional<double> mean = median(values_of(models, has_tets, mean_of));
  const std::optional<double> p1 = median(values_of(models, has_tets, p1_of));
  return {"mean ratio mean / p1, median", both(mean, p1, "%.3f"), ">= .90 / >= .74",
          !mean || (*mean >= .90 && *p1 >= .74)};
}

SummaryRow band_row(std::span<const RealModel> models) {
  const auto band_of = [](const RealModel& model) { return model.tetloom.mesh->edges_in_band; };
  const std::optional<double> middle = median(values_of(models, has_tets, band_of));
  return {"edges in band, median", middle ? formatted("%.1f %%", 100 * *middle) : "-", ">= 96 %",
          !middle || *middle >= .96};
}

SummaryRow distance_row(std::span<const RealModel> models) {
  const auto measured = [](const RealModel& model) {
    return is_valid(model) && model.tetloom.mesh->surface_distance.has_value();
  };
  const std::vector<double> shares =
      values_of(models, measured, [](const RealModel& model) { return *model.tetloom.mesh->surface_distance; });
  const std::optional<double> middle = median(shares), most = largest(shares);
  return {"surface's distance from the model / edge, median / largest", both(middle, most, "%.3f"), "<= .10",
          !most || *most <= .10};
}

SummaryRow facets_row(std::span<const RealModel> models) {
  const auto closed = [](const RealModel& model) { return model.facts.closed_manifold; };
  const std::size_t all = count_of(models, closed);
  const std::size_t valid = count_of(models, [&](const RealModel& model) { return closed(model) && is_valid(model); });
  return {"closed manifold triangle surfaces", all > 0 ? of(valid, all) : "-", "all", valid == all};
}

void print_gmsh(const RealModel& model) {
  std::printf(" | %-14s", gmsh_verdict(model).c_str());
  if (!model.gmsh) return;
  const MesherRun& run = *model.gmsh;
  if (!run.mesh) {
    std::printf(" %9s %6.1f", "-", run.seconds);
    return;
  }
  std::printf(" %9llu %6.1f %5.1f", static_cast<unsigned long long>(run.mesh->tets), run.seconds,
              run.mesh->min_dihedral_deg);
  if (can_compare(model)) std::printf(" | %6.2f %6.2f", speed_ratio(model), model.tetloom.seconds / run.seconds);
}

}  // namespace

std::optional<double> median(std::vector<double> values) {
  if (values.empty()) return std::nullopt;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

std::vector<SummaryRow> summarize(std::span<const RealModel> models) {
  return {valid_row(models), longest_row(models), speed_row(models), time_row(models),     size_field_row(models),
          angle_row(models), ratio_row(models),   band_row(models),  distance_row(models), facets_row(models)};
}

void print_table_heading() {
  std::printf("%-40s %-14s %9s %7s %9s %6s %6s %6s %5s %5s %5s %5s | %-14s %9s %6s %5s | %6s %6s\n", "model", "tetloom",
              "solids", "vol %", "tets", "s", "size %", "MB", "angle", "mean", "p1", "band", "Gmsh", "tets", "s",
              "angle", "x t/s", "x time");
}

void print_table_line(const RealModel& model) {
  const MesherRun& run = model.tetloom;
  const MeshFigures mesh = run.mesh.value_or(MeshFigures{});
  const double volume = model.facts.volume();
  std::printf("%-40.40s %-14s %9s", model.name.c_str(), verdict(model).c_str(),
              (std::to_string(mesh.regions) + "/" + std::to_string(model.facts.volumes.size())).c_str());
  std::printf(" %7s", mesh.tets > 0 && volume > 0 ? formatted("%+.2f", 100 * (mesh.volume / volume - 1)).c_str() : "-");
  std::printf(" %9llu %6.1f", static_cast<unsigned long long>(mesh.tets), run.seconds);
  std::printf(" %6s", model.stages.total > 0 ? formatted("%.0f", 100 * size_field_share(model)).c_str() : "-");
  std::printf(" %6.0f %5.2f %5.3f %5.3f %5.1f", 1e-6 * static_cast<double>(run.peak_bytes), mesh.min_dihedral_deg,
              mesh.ratio_mean, mesh.ratio_p1, 100 * mesh.edges_in_band);
  print_gmsh(model);
  std::printf("\n");
  std::fflush(stdout);
}

void print_summary(std::span<const RealModel> models) {
  std::printf("\n%-58s %-46s %s\n", "measure", "value", "asked");
  for (const SummaryRow& row : summarize(models))
    std::printf("%-58s %-46.46s %-28s%s\n", row.measure.c_str(), row.value.c_str(), row.target.c_str(),
                row.reached ? "" : "MISSED");
}

void print_findings(std::span<const RealModel> models) {
  std::printf("\n");
  for (const RealModel& model : models) {
    if (is_valid(model)) continue;
    const std::string problem = model.tetloom.mesh ? model.tetloom.mesh->problem : "";
    const std::string& why = model.tetloom.failure.empty() ? problem : model.tetloom.failure;
    std::printf("not valid: %s, %s after %.1f s. %.200s\n", model.name.c_str(), verdict(model).c_str(),
                model.tetloom.seconds, why.c_str());
  }
  for (const RealModel& model : models) {
    if (!has_tets(model) || angle_of(model) >= kSharpAngle) continue;
    std::printf("%.3f degrees: %s", angle_of(model), model.name.c_str());
    if (model.worst && !model.worst->cause.empty())
      std::printf(", forced by a %s of %.3f degrees", model.worst->cause.c_str(), model.worst->cause_deg);
    else
      std::printf(", nothing known that forces it");
    if (model.worst && model.worst->cause_length > 0) std::printf(" (%.4g wide)", model.worst->cause_length);
    if (model.worst && !model.worst->entities.empty()) std::printf(" on %s", model.worst->entities.c_str());
    std::printf("\n");
  }
}

}  // namespace tetloom::bench
