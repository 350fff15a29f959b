#include "bench/support/surface_table.hpp"

#include <algorithm>
#include <cstdio>

namespace tetloom::bench {
namespace {

/// The case of the same model and size with this number of threads; null when there is none.
const SurfaceCase* find_sibling(std::span<const SurfaceCase> cases, const SurfaceCase& of, int threads) {
  for (const SurfaceCase& candidate : cases) {
    const bool same = candidate.model_name == of.model_name && candidate.task.size == of.task.size;
    if (same && candidate.task.threads == threads) return &candidate;
  }
  return nullptr;
}

std::string ratio_text(double numerator, double denominator) {
  if (!(numerator > 0) || !(denominator > 0)) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), "%.2f", numerator / denominator);
  return text;
}

struct Row {
  const char* mesher;
  const Series& series;
  std::string speed_up, to_gmsh;
};

void print_row(const SurfaceCase& surface_case, const Row& row) {
  const SurfaceSample& s = row.series.median();
  std::printf("%-15s %7.4g %3d  %-7s %8llu %8.3f %8.3f %8.1f %6s %6s  %6.4f %6.2f %6.4f %6.2f %7.0f\n",
              surface_case.model_name.c_str(), surface_case.task.size, surface_case.task.threads, row.mesher,
              static_cast<unsigned long long>(s.triangles), s.seconds, s.cpu_seconds,
              1e-3 * row.series.triangles_per_second(), row.speed_up.c_str(), row.to_gmsh.c_str(), s.quality,
              s.min_angle_deg, s.edge_ratio, 100 * s.in_band,
              static_cast<double>(s.peak_bytes) / static_cast<double>(std::max<std::uint64_t>(s.triangles, 1)));
}

nlohmann::json series_json(const Series& series) {
  if (series.empty()) return nullptr;
  return {{"median_seconds", series.median().seconds},
          {"triangles_per_second", series.triangles_per_second()},
          {"samples", series.samples}};
}

}  // namespace

const SurfaceSample& Series::median() const {
  std::vector<const SurfaceSample*> order;
  for (const SurfaceSample& sample : samples) order.push_back(&sample);
  const auto middle = order.begin() + static_cast<std::ptrdiff_t>((order.size() - 1) / 2);
  std::nth_element(order.begin(), middle, order.end(),
                   [](const SurfaceSample* a, const SurfaceSample* b) { return a->seconds < b->seconds; });
  return **middle;
}

double Series::triangles_per_second() const {
  if (empty()) return 0;
  const SurfaceSample& sample = median();
  return sample.seconds > 0 ? static_cast<double>(sample.triangles) / sample.seconds : 0;
}

void print_table(std::span<const SurfaceCase> cases) {
  std::printf("%-15s %7s %3s  %-7s %8s %8s %8s %8s %6s %6s  %6s %6s %6s %6s %7s\n", "model", "h", "thr", "mesher",
              "tris", "wall s", "cpu s", "k tri/s", "1->T", "/gmsh", "qual.", "angle", "edge/h", "band %", "B/tri");
  for (const SurfaceCase& surface_case : cases) {
    const SurfaceCase* serial = find_sibling(cases, surface_case, 1);
    const auto speed_up = [&](const Series SurfaceCase::*mesher) {
      if (serial == nullptr || (serial->*mesher).empty()) return std::string("-");
      return ratio_text((serial->*mesher).median().seconds, (surface_case.*mesher).median().seconds);
    };
    const double own = surface_case.tetloom.triangles_per_second();
    print_row(surface_case, {"tetloom", surface_case.tetloom, speed_up(&SurfaceCase::tetloom),
                             ratio_text(own, surface_case.gmsh.triangles_per_second())});
    if (!surface_case.gmsh.empty()) {
      print_row(surface_case, {"gmsh", surface_case.gmsh, speed_up(&SurfaceCase::gmsh), ""});
    }
  }
}

void print_claims(std::span<const SurfaceCase> cases) {
  for (const SurfaceCase& surface_case : cases) {
    const SurfaceCase* serial = find_sibling(cases, surface_case, 1);
    if (surface_case.task.threads != 2 || serial == nullptr) continue;
    const Series &own = surface_case.tetloom, &gmsh = surface_case.gmsh;
    std::printf(
        "%-15s %8llu triangles, %3zu faces: 1 -> 2 threads x %s (asked: 1.80); 2 threads, tetloom / gmsh x %s "
        "(asked: 2.00)\n",
        surface_case.model_name.c_str(), static_cast<unsigned long long>(own.median().triangles),
        surface_case.model_faces, ratio_text(serial->tetloom.median().seconds, own.median().seconds).c_str(),
        ratio_text(own.triangles_per_second(), gmsh.triangles_per_second()).c_str());
  }
}

nlohmann::json to_json(const SurfaceCase& surface_case) {
  return {{"model", surface_case.model_name},
          {"faces", surface_case.model_faces},
          {"size", surface_case.task.size},
          {"threads", surface_case.task.threads},
          {"tetloom", series_json(surface_case.tetloom)},
          {"gmsh", series_json(surface_case.gmsh)}};
}

}  // namespace tetloom::bench
