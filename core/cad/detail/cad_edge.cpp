#include "core/cad/detail/cad_edge.hpp"

#include <algorithm>
#include <BRep_Tool.hxx>
#include <TColStd_Array1OfReal.hxx>

#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/occt_guard.hpp"

namespace tetloom::cad {

CadEdge::CadEdge(const TopoDS_Edge& edge, NamedEntity who) : who_(std::move(who)) {
  translate_failures(who_, ErrorCode::EdgeFailed, "taking the curve", [&] {
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, range_.lo, range_.hi);
    if (curve.IsNull()) throw Error(ErrorCode::EdgeFailed, "the edge has no curve in space");
    curve_.Load(curve, range_.lo, range_.hi);
    if (curve_.IsPeriodic()) period_ = curve_.Period();
  });
}

Vec3 CadEdge::evaluate(double t) {
  return translate_failures(who_, ErrorCode::EdgeFailed, "evaluation", [&] { return to_vec3(curve_.Value(t)); });
}

Vec3 CadEdge::derivative(double t) {
  return translate_failures(who_, ErrorCode::EdgeFailed, "differentiation", [&] { return to_vec3(curve_.DN(t, 1)); });
}

double CadEdge::curvature(double t) {
  return translate_failures(who_, ErrorCode::EdgeFailed, "curvature", [&] {
    gp_Pnt p;
    gp_Vec d1, d2;
    curve_.D2(t, p, d1, d2);
    const double speed = d1.Magnitude(), bend = d1.Crossed(d2).Magnitude();
    const double value = bend / (speed * speed * speed);
    return std::isfinite(value) ? value : 0.0;
  });
}

namespace {
constexpr int kSamplesOfOnePiece = 16, kSamplesPerPiece = 8;
constexpr int kMaxSamples = 2048;
constexpr int kMostMinima = 3;
constexpr int kMostIterations = 60;
constexpr double kRounding = 4e-15;
}  // namespace

void CadEdge::make_samples() {
  const int pieces = curve_.GetType() == GeomAbs_Line ? 1 : curve_.NbIntervals(GeomAbs_C2);
  TColStd_Array1OfReal ends(1, pieces + 1);
  ends(1) = range_.lo, ends(pieces + 1) = range_.hi;
  if (pieces > 1) curve_.Intervals(ends, GeomAbs_C2);
  const int each = std::clamp(kMaxSamples / pieces, 2, pieces == 1 ? kSamplesOfOnePiece : kSamplesPerPiece);
  for (int piece = 1; piece <= pieces; ++piece)
    for (int i = piece == 1 ? 0 : 1; i <= each; ++i)
      sample_t_.push_back(ends(piece) + (ends(piece + 1) - ends(piece)) * i / each);
  for (const double t : sample_t_) samples_.push_back(to_vec3(curve_.Value(t)));
}

// The root of (C(t) - x)·C'(t) in [lo, hi] from the middle: Newton, kept inside by bisection on the sign.
CurvePoint CadEdge::refine(const Vec3& x, double lo, double hi) {
  const double width = hi - lo;
  double t = 0.5 * (lo + hi);
  for (int i = 0; i < kMostIterations; ++i) {
    gp_Pnt p;
    gp_Vec d1, d2;
    curve_.D2(t, p, d1, d2);
    const Vec3 r = to_vec3(p) - x, c1 = to_vec3(d1);
    const double slope = dot(r, c1), bend = dot(c1, c1) + dot(r, to_vec3(d2));
    const double newton = bend > 0 ? t - slope / bend : HUGE_VAL;
    const double noise = kRounding * (norm(x) + norm(r));  // of the distance along the curve
    if (std::abs(newton - t) * norm(c1) <= noise || hi - lo <= 1e-14 * width) break;
    (slope > 0 ? hi : lo) = t;
    t = newton > lo && newton < hi ? newton : 0.5 * (lo + hi);
  }
  const Vec3 p = to_vec3(curve_.Value(t));
  return {t, p, distance(p, x)};
}

CurvePoint CadEdge::closest_point(const Vec3& x) {
  return translate_failures(who_, ErrorCode::EdgeFailed, "projection", [&] {
    if (samples_.empty()) make_samples();
    std::vector<std::pair<double, std::size_t>> minima;  // of the sampled distance
    const std::size_t n = samples_.size();
    for (std::size_t i = 0; i < n; ++i) {
      const double d = norm2(samples_[i] - x);
      if (i > 0 && norm2(samples_[i - 1] - x) < d) continue;
      if (i + 1 < n && norm2(samples_[i + 1] - x) < d) continue;
      minima.emplace_back(d, i);
    }
    std::sort(minima.begin(), minima.end());
    if (minima.size() > kMostMinima) minima.resize(kMostMinima);
    CurvePoint best{range_.lo, samples_.front(), HUGE_VAL};
    for (const auto& [d, i] : minima) {
      const CurvePoint sample{sample_t_[i], samples_[i], std::sqrt(d)};
      if (sample.distance < best.distance) best = sample;
      for (const std::size_t left : {i - 1, i}) {  // from the middles: the derivative may vanish at a sample
        if (left >= n - 1) continue;
        const CurvePoint found = refine(x, sample_t_[left], sample_t_[left + 1]);
        if (found.distance < best.distance) best = found;
      }
    }
    return best;
  });
}

}  // namespace tetloom::cad
