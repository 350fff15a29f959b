#include "tests/cad/model_checks.hpp"

#include <algorithm>
#include <chrono>
#include <sstream>

namespace tetloom::test {

TimedDocument read_timed(const std::filesystem::path& path, const ReadOptions& options) {
  const auto start = std::chrono::steady_clock::now();
  TimedDocument result;
  result.document = read_model(path, options);
  result.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return result;
}

namespace {

/// The two ends of an edge use in the direction of its loop.
struct UseEnds {
  ModelVertexId start, end;
  Vec2 uv_start, uv_end;
};

UseEnds ends_of(const GeometricModel& model, FaceGeometry& face, const EdgeUse& use) {
  const auto& vertices = model.topology().edges[use.edge.value].vertices;
  const ParameterRange range = face.edge_range(use);
  UseEnds ends{vertices[0], vertices[1], face.edge_parameters(use, range.lo), face.edge_parameters(use, range.hi)};
  if (!use.forward) std::swap(ends.start, ends.end), std::swap(ends.uv_start, ends.uv_end);
  return ends;
}

/// The length in space of the straight line between two points in (u,v), to first order from both ends.
double uv_distance(FaceGeometry& face, const Vec2& a, const Vec2& b) {
  const SurfaceDerivatives at = face.derivatives(a), bt = face.derivatives(b);
  const Vec2 d = b - a;
  return std::max(norm(d.u * at.du + d.v * at.dv), norm(d.u * bt.du + d.v * bt.dv));
}

void check_curve(const GeometricModel& model, FaceGeometry& face, const EdgeUse& use, LoopReport& report) {
  if (model.topology().edges[use.edge.value].degenerate) return;
  const auto edge = model.edge_geometry(use.edge);
  const ParameterRange range = face.edge_range(use);
  double worst = 0;
  for (int i = 0; i <= 20; ++i) {
    const double t = range.lo + (range.hi - range.lo) * i / 20;
    worst = std::max(worst, distance(face.evaluate(face.edge_parameters(use, t)), edge->evaluate(t)));
  }
  report.worst_curve_gap = std::max(report.worst_curve_gap, worst);
  if (worst > 1.3 * model.attributes(use.edge).tolerance + 1e-7) ++report.off_curve;
}

}  // namespace

LoopReport check_loops(const GeometricModel& model) {
  LoopReport report;
  for (std::size_t f = 0; f < model.topology().face_count(); ++f) {
    const auto face = model.face_geometry(ModelFaceId(f));
    for (const ModelLoop& loop : model.topology().face_to_loops[f]) {
      for (std::size_t i = 0; i < loop.size(); ++i) {
        ++report.uses;
        const UseEnds a = ends_of(model, *face, loop[i]), b = ends_of(model, *face, loop[(i + 1) % loop.size()]);
        const double uv_gap = uv_distance(*face, a.uv_end, b.uv_start);
        const double point_gap = distance(face->evaluate(a.uv_end), face->evaluate(b.uv_start));
        const double tolerance = model.attributes(a.end).tolerance;
        report.worst_uv_gap = std::max(report.worst_uv_gap, uv_gap);
        report.worst_point_gap = std::max(report.worst_point_gap, point_gap);
        if (a.end != b.start || std::max(point_gap, uv_gap) > 3 * tolerance + 1e-7) ++report.disconnected;
        check_curve(model, *face, loop[i], report);
      }
    }
  }
  return report;
}

std::string describe(const Diagnostic& diagnostic) {
  std::ostringstream text;
  text << to_string(diagnostic.code) << ": " << diagnostic.message;
  for (const NamedEntity& entity : diagnostic.entities) text << " [" << tetloom::describe(entity) << "]";
  if (diagnostic.point)
    text << " at " << diagnostic.point->x << " " << diagnostic.point->y << " " << diagnostic.point->z;
  return text.str();
}

}  // namespace tetloom::test
