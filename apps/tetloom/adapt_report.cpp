#include "apps/tetloom/adapt_report.hpp"

#include <array>
#include <cmath>
#include <numeric>
#include <utility>

#include "apps/tetloom/console.hpp"
#include "apps/tetloom/quantities.hpp"
#include "apps/tetloom/text_table.hpp"

namespace tetloom::app {
namespace {

using Json = nlohmann::ordered_json;
using adapt::Verdict;
using adapt::Verdicts;

constexpr std::size_t kMostFieldRows = 30;
constexpr std::array<std::pair<const char*, Verdicts adapt::PassCounts::*>, 4> kOperations{
    {{"splits", &adapt::PassCounts::splits},
     {"collapses", &adapt::PassCounts::collapses},
     {"swaps", &adapt::PassCounts::swaps},
     {"moves", &adapt::PassCounts::moves}}};

std::size_t done(const Verdicts& verdicts) { return verdicts[static_cast<std::size_t>(Verdict::Done)]; }

std::size_t refused(const Verdicts& verdicts) {
  return std::accumulate(verdicts.begin(), verdicts.end(), std::size_t{0}) - done(verdicts);
}

/// Calls visit(name, count) for every reason to refuse.
template <class Visit>
void for_each_reason(const Verdicts& verdicts, const Visit& visit) {
  for (std::size_t i = 0; i < verdicts.size(); ++i)
    if (static_cast<Verdict>(i) != Verdict::Done) visit(std::string(to_string(static_cast<Verdict>(i))), verdicts[i]);
}

Json operation_json(const Verdicts& verdicts) {
  Json reasons = Json::object();
  for_each_reason(verdicts, [&](const std::string& name, std::size_t count) { reasons[name] = count; });
  return {{"done", done(verdicts)}, {"refused", refused(verdicts)}, {"refused_by", std::move(reasons)}};
}

Json conformity_json(const MetricConformity& conformity) {
  if (conformity.edges == 0) return nullptr;
  return {{"edges", conformity.edges},
          {"unit_edges", conformity.unit},
          {"half_to_two", conformity.half_to_two},
          {"shortest", conformity.shortest},
          {"longest", conformity.longest},
          {"quality_min", conformity.least_quality},
          {"quality_mean", conformity.mean_quality},
          {"quality_histogram", conformity.quality_histogram},
          {"complexity", conformity.complexity}};
}

Json transfer_json(const std::vector<adapt::FieldTransfer>& transfers) {
  Json fields = Json::array();
  for (const adapt::FieldTransfer& field : transfers) {
    Json components = Json::array();
    for (const auto& c : field.components)
      components.push_back({{"integral", {c.before.integral, c.after.integral}},
                            {"least", {c.before.least, c.after.least}},
                            {"greatest", {c.before.greatest, c.after.greatest}},
                            {"change", c.change()}});
    fields.push_back(
        {{"name", field.name}, {"on", field.on_cells ? "cells" : "points"}, {"components", std::move(components)}});
  }
  return fields;
}

std::string transfer_table(const std::vector<adapt::FieldTransfer>& transfers) {
  if (transfers.empty()) return {};
  std::vector<std::vector<std::string>> rows;
  for (const adapt::FieldTransfer& field : transfers) {
    for (std::size_t i = 0; i < field.components.size(); ++i) {
      const adapt::FieldFigures &before = field.components[i].before, &after = field.components[i].after;
      const std::string component = field.components.size() > 1 ? " [" + std::to_string(i + 1) + "]" : "";
      rows.push_back({field.name + component, field.on_cells ? "cells" : "points", format_number(before.integral),
                      format_number(after.integral), format_number(field.components[i].change()),
                      format_number(before.least) + " to " + format_number(before.greatest),
                      format_number(after.least) + " to " + format_number(after.greatest)});
    }
  }
  return render_table({"field", "on", "integral before", "after", "change", "values before", "after"}, rows,
                      kMostFieldRows);
}

std::string rounded(double value) { return format_number(std::round(1e3 * value) / 1e3); }

std::string conformity_table(const MetricConformity& before, const MetricConformity& after) {
  const auto row = [&](const std::string& label, const auto& text) {
    return std::vector<std::string>{label, text(before), text(after)};
  };
  using C = MetricConformity;
  return render_table({"in the metric", "before", "after"},
                      {row("edges", [](const C& c) { return format_count(c.edges); }),
                       row("in [0.707, 1.414]", [](const C& c) { return format_share(c.unit); }),
                       row("in [0.5, 2]", [](const C& c) { return format_share(c.half_to_two); }),
                       row("shortest", [](const C& c) { return rounded(c.shortest); }),
                       row("longest", [](const C& c) { return rounded(c.longest); }),
                       row("mean ratio, mean", [](const C& c) { return rounded(c.mean_quality); }),
                       row("mean ratio, least", [](const C& c) { return rounded(c.least_quality); }),
                       row("complexity", [](const C& c) { return format_number(c.complexity); })},
                      kMostFieldRows);
}

std::string operation_table(const adapt::PassCounts& operations) {
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, verdicts] : kOperations) {
    std::string reasons;
    for_each_reason(operations.*verdicts, [&](const std::string& reason, std::size_t count) {
      if (count > 0) reasons += (reasons.empty() ? "" : ", ") + reason + " " + format_count(count);
    });
    rows.push_back({name, format_count(done(operations.*verdicts)), format_count(refused(operations.*verdicts)),
                    std::move(reasons)});
  }
  return render_table({"operations", "done", "refused", "because of"}, rows, kMostFieldRows);
}

}  // namespace

nlohmann::ordered_json adaptation_json(const AdaptReport& adaptation, double metric_seconds) {
  Json operations = Json::object();
  for (const auto& [name, verdicts] : kOperations) operations[name] = operation_json(adaptation.operations.*verdicts);
  const adapt::TurningResult& turning = adaptation.turning;
  Json limited = nullptr;
  if (turning.turns) limited = {{"complexity_asked", turning.asked}, {"complexity_followed", turning.followed}};
  return {{"turning_limited", std::move(limited)},
          {"before", conformity_json(adaptation.before)},
          {"after", conformity_json(adaptation.after)},
          {"operations", std::move(operations)},
          {"rounds", adaptation.rounds},
          {"most_parts", adaptation.most_parts},
          {"points_beside_model", adaptation.beside_model},
          {"transfer", transfer_json(adaptation.transfers)},
          {"seconds", {{"metric", metric_seconds}, {"adapt", adaptation.seconds}}}};
}

std::string render_adaptation(const AdaptReport& adaptation, const RunReport& report, const std::string& output,
                              const std::string& report_file) {
  std::string text = format_count(report.counts.points) + " points, " + format_count(report.counts.triangles) +
                     " triangles, " + format_count(report.counts.tets) + " tets\n";
  if (adaptation.turning.turns)
    text += "  the metric turns faster than elements can: its large sizes were limited, for a complexity of " +
            format_number(std::round(adaptation.turning.followed)) + " in place of " +
            format_number(std::round(adaptation.turning.asked)) + "\n";
  text += conformity_table(adaptation.before, adaptation.after);
  text += "  tets by mean ratio in the metric (1 is regular):\n";
  text += render_histogram(adaptation.after.quality_histogram.data(), adaptation.after.quality_histogram.size(), 0, 1);
  text += operation_table(adaptation.operations);
  if (adaptation.beside_model > 0)
    text += "  beside the model: " + format_count(adaptation.beside_model) +
            " of the surface's points, on whose way to it a tet would have been inverted\n";
  text += transfer_table(adaptation.transfers);
  text += "  digest     " + report.digest + "\n";
  text += "  time       " + format_seconds(report.total_seconds()) + " in all: read " +
          format_seconds(report.seconds.read) + ", adapt " + format_seconds(adaptation.seconds) + " (" +
          std::to_string(adaptation.rounds) + " rounds), check " + format_seconds(report.seconds.check) + ", write " +
          format_seconds(report.seconds.write) + "\n";
  text += "  memory     " + format_bytes(static_cast<double>(peak_bytes())) + " at most, " +
          std::to_string(report.threads) + (report.threads == 1 ? " thread\n" : " threads\n");
  return text + "  written    " + output + (report_file.empty() ? "" : ", " + report_file) + "\n";
}

}  // namespace tetloom::app
