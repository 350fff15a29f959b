#include "bench/support/volume_table.hpp"

#include <algorithm>
#include <cstdio>

namespace tetloom::bench {
namespace {

std::string ratio_text(double numerator, double denominator) {
  if (!(numerator > 0) || !(denominator > 0)) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f", numerator / denominator);
  return text;
}

double bytes_per_tet(const VolumeSample& s) { return static_cast<double>(s.peak_bytes) / static_cast<double>(s.tets); }

/// Millions per second.
double millions(double count, double seconds) { return seconds > 0 ? 1e-6 * count / seconds : 0; }

void print_failure(const VolumeSeries& series) {
  if (series.empty() && !series.failure.empty())
    std::printf("  %-8s failed: %.90s\n", series.mesher.c_str(), series.failure.c_str());
}

/// Collects what is not as asked.
class Misses {
 public:
  explicit Misses(const VolumeCase& one) : one_(one) {}
  void at_least(const char* what, double value, double bound) { judge(what, value, bound, value >= bound); }
  void at_most(const char* what, double value, double bound) { judge(what, value, bound, value <= bound); }
  int asked() const { return asked_; }
  int missed() const { return missed_; }

 private:
  void judge(const char* what, double value, double bound, bool held) {
    ++asked_;
    if (held) return;
    ++missed_;
    std::printf("missed: %s: %s %.4g, asked %.4g\n", one_.title().c_str(), what, value, bound);
  }

  const VolumeCase& one_;
  int asked_ = 0, missed_ = 0;
};

double wanted_mean(double gradient) { return gradient <= 0.06 ? 0.92 : gradient <= 0.2 ? 0.90 : 0.88; }

void judge_shapes(const VolumeCase& one, Misses& misses) {
  const VolumeSample& s = one.tetloom.median();
  misses.at_least("mean ratio", s.ratio_mean, wanted_mean(one.task.gradient));
  misses.at_least("mean ratio p1", s.ratio_p1, one.task.gradient > 0 ? 0.70 : 0.72);
  misses.at_most("tets below 15 degrees that the surface does not force",
                 static_cast<double>(s.below_15) - static_cast<double>(s.forced), 0);
  misses.at_least("edges in band", s.in_band, 0.97);
  misses.at_least("mean edge / size", s.edge_ratio, 0.97);
  misses.at_most("mean edge / size", s.edge_ratio, 1.03);
}

/// Speeds are promised for a million tets and more, memory from about five on.
void judge_speed(const VolumeCase& one, Misses& misses) {
  const VolumeSample& s = one.tetloom.median();
  if (s.tets < 700'000 || one.task.threads != 1) return;
  const bool large = s.tets > 3'500'000;
  if (one.task.gradient == 0) {
    misses.at_least("M tets/s of the 3D stage", 1e-6 * one.tetloom.tets_per_second(), large ? 2.0 : 1.5);
    if (!one.hxt.empty())
      misses.at_least("tets/s beside HXT", one.tetloom.tets_per_second() / one.hxt.tets_per_second(), 3);
    misses.at_least("M core tets/s", millions(static_cast<double>(s.core_tets), s.filling.core), 40);
  }
  if (large) misses.at_most("bytes per tet", bytes_per_tet(s), 80);
}

}  // namespace

const VolumeSample& VolumeSeries::median() const {
  std::vector<const VolumeSample*> order;
  for (const VolumeSample& sample : samples) order.push_back(&sample);
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>((order.size() - 1) / 2);
  std::nth_element(order.begin(), middle, order.end(),
                   [](const VolumeSample* a, const VolumeSample* b) { return a->seconds < b->seconds; });
  return **middle;
}

double VolumeSeries::tets_per_second() const {
  if (empty() || median().seconds <= 0) return 0;
  return static_cast<double>(median().tets) / median().seconds;
}

std::string VolumeCase::title() const {
  char text[160];
  const int count = std::snprintf(text, sizeof(text), "%s, h %.4g", model_name.c_str(), task.size);
  if (task.gradient > 0)
    std::snprintf(text + count, sizeof(text) - static_cast<std::size_t>(count), " to %.4g, gradient %g",
                  task.wave().largest(), task.gradient);
  return text;
}

void print_quality(std::span<const VolumeCase> cases) {
  std::printf("  %-8s %9s %6s  %6s %6s %6s  %6s %7s %6s %6s  %6s %6s\n", "mesher", "tets", "t.h3/V", "mean", "p1",
              "min", "angle", "%<20", "<15", "forced", "band %", "edge/h");
  for (const VolumeCase& one : cases) {
    std::printf("%s\n", one.title().c_str());
    for (const VolumeSeries* series : one.all()) {
      print_failure(*series);
      if (series->empty()) continue;
      const VolumeSample& s = series->median();
      const std::string forced = series == &one.tetloom ? std::to_string(s.forced) : "-";
      std::printf("  %-8s %9llu %6.2f  %6.4f %6.4f %6.4f  %6.2f %7.4f %6llu %6s  %6.2f %6.4f\n", series->mesher.c_str(),
                  static_cast<unsigned long long>(s.tets), s.density, s.ratio_mean, s.ratio_p1, s.ratio_min,
                  s.min_dihedral_deg, 100 * s.below_20, static_cast<unsigned long long>(s.below_15), forced.c_str(),
                  100 * s.in_band, s.edge_ratio);
    }
  }
}

void print_speed(std::span<const VolumeCase> cases) {
  std::printf("  %-8s %3s %8s %8s %7s %9s %6s %7s\n", "mesher", "thr", "3D s", "2D s", "sizes s", "k tets/s", "/hxt",
              "B/tet");
  for (const VolumeCase& one : cases) {
    std::printf("%s\n", one.title().c_str());
    for (const VolumeSeries* series : one.all()) {
      if (series->empty()) continue;
      const VolumeSample& s = series->median();
      std::printf("  %-8s %3d %8.3f %8.3f %7.3f %9.1f %6s %7.0f\n", series->mesher.c_str(), one.task.threads, s.seconds,
                  s.surface_seconds, s.size_seconds, 1e-3 * series->tets_per_second(),
                  ratio_text(series->tets_per_second(), one.hxt.tets_per_second()).c_str(), bytes_per_tet(s));
    }
  }
}

void print_stages(std::span<const VolumeCase> cases) {
  std::printf("%-44s %3s %7s %7s %7s %7s %7s %7s %7s  %6s %6s  %7s %6s %6s\n", "tetloom's stages, s", "thr", "points",
              "core", "Delaun.", "recov.", "join", "optim.", "rest", "core %", "Mcore/s", "missing", "points",
              "tetgen");
  for (const VolumeCase& one : cases) {
    if (one.tetloom.empty()) continue;
    const VolumeSample& s = one.tetloom.median();
    const FillingSeconds& f = s.filling;
    const double rest = s.seconds - (f.points + f.core + f.delaunay + f.recovery + f.join + f.optimize);
    const auto core_tets = static_cast<double>(s.core_tets);
    std::printf("%-44s %3d %7.3f %7.3f %7.3f %7.3f %7.3f %7.3f %7.3f  %6.1f %6.1f  %7llu %6llu %6llu\n",
                one.title().c_str(), one.task.threads, f.points, f.core, f.delaunay, f.recovery, f.join, f.optimize,
                rest, 100 * core_tets / static_cast<double>(s.tets), millions(core_tets, f.core),
                static_cast<unsigned long long>(s.missing_triangles),
                static_cast<unsigned long long>(s.recovery_points),
                static_cast<unsigned long long>(s.worker_complexes));
  }
}

void print_misses(std::span<const VolumeCase> cases) {
  int asked = 0, missed = 0;
  for (const VolumeCase& one : cases) {
    if (one.tetloom.empty()) continue;
    Misses misses(one);
    judge_shapes(one, misses);
    judge_speed(one, misses);
    asked += misses.asked(), missed += misses.missed();
  }
  std::printf("%d of %d claims hold.\n", asked - missed, asked);
}

nlohmann::json to_json(const VolumeCase& one) {
  nlohmann::json json = {{"model", one.model_name}, {"task", one.task}};
  for (const VolumeSeries* series : one.all()) {
    json[series->mesher] = nullptr;
    if (!series->failure.empty()) json[series->mesher] = {{"failure", series->failure}};
    if (!series->empty())
      json[series->mesher] = {{"median_seconds", series->median().seconds},
                              {"tets_per_second", series->tets_per_second()},
                              {"bytes_per_tet", bytes_per_tet(series->median())},
                              {"samples", series->samples}};
  }
  return json;
}

}  // namespace tetloom::bench
