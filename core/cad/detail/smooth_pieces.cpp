#include "core/cad/detail/smooth_pieces.hpp"

#include <algorithm>
#include <cmath>
#include <Geom2d_BSplineCurve.hxx>
#include <Geom_BezierSurface.hxx>
#include <Geom_BSplineCurve.hxx>
#include <Geom_BSplineSurface.hxx>
#include <Geom_ElementarySurface.hxx>
#include <Geom_Plane.hxx>
#include <Geom_SphericalSurface.hxx>
#include <Geom_SurfaceOfRevolution.hxx>
#include <Geom_SweptSurface.hxx>
#include <Geom_ToroidalSurface.hxx>
#include <Geom_TrimmedCurve.hxx>
#include <GeomAdaptor_Surface.hxx>
#include <numbers>
#include <TColStd_Array1OfReal.hxx>

#include "core/cad/detail/gauss_rule.hpp"

namespace tetloom::cad {
namespace {

constexpr double kLargestTurn = std::numbers::pi / 3;
constexpr int kTurnNodes = 6;  // 1e-10 over a sixth of a turn

/// Cuts [lo, hi] into equal pieces of at most `width`; the ends are no breaks.
std::vector<double> equal_breaks(double lo, double hi, double width) {
  const int count = std::max(1, static_cast<int>(std::ceil((hi - lo) / width - 1e-9)));
  std::vector<double> breaks;
  for (int i = 1; i < count; ++i) breaks.push_back(lo + (hi - lo) * i / count);
  return breaks;
}

/// The same for the pieces between `places`; with the places.
std::vector<double> refined(const std::vector<double>& places, double width) {
  std::vector<double> result{places.front()};
  for (std::size_t i = 0; i + 1 < places.size(); ++i) {
    const std::vector<double> inner = equal_breaks(places[i], places[i + 1], width);
    result.insert(result.end(), inner.begin(), inner.end());
    result.push_back(places[i + 1]);
  }
  return result;
}

SmoothAxis turned_axis(double lo, double hi) { return {equal_breaks(lo, hi, kLargestTurn), kTurnNodes}; }

std::array<SmoothAxis, 2> elementary_axes(const Handle(Geom_ElementarySurface) & surface, const Vec2& lo,
                                          const Vec2& hi) {
  if (!Handle(Geom_Plane)::DownCast(surface).IsNull()) return {};
  const SmoothAxis around = turned_axis(lo.u, hi.u);
  const bool is_round = !Handle(Geom_SphericalSurface)::DownCast(surface).IsNull() ||
                        !Handle(Geom_ToroidalSurface)::DownCast(surface).IsNull();
  return {around, is_round ? turned_axis(lo.v, hi.v) : SmoothAxis{{}, 2}};
}

/// The Gauss points that integrate point · (du x dv) exactly on a polynomial patch, and a few more for quotients.
int spline_nodes(int degree, bool rational) {
  return std::min((3 * degree + 1) / 2 + (rational ? 4 : 0), kMostGaussNodes);
}

/// The knots in (lo, hi), repeated with the period where there is one.
std::vector<double> knots_within(const TColStd_Array1OfReal& knots, bool periodic, double lo, double hi) {
  const double first = knots.First(), period = knots.Last() - first;
  std::vector<double> result;
  const double begin = periodic ? std::floor((lo - first) / period) : 0;
  const double end = periodic ? std::ceil((hi - first) / period) : 1;
  for (double turn = begin; turn < end; ++turn)
    for (int i = knots.Lower(); i < knots.Upper(); ++i)
      if (const double knot = knots(i) + turn * period; knot > lo && knot < hi) result.push_back(knot);
  return result;
}

SmoothAxis spline_axis(const TColStd_Array1OfReal& knots, bool periodic, int nodes, double lo, double hi) {
  SmoothAxis axis{knots_within(knots, periodic, lo, hi), nodes};
  if (!periodic) axis.lo = knots.First(), axis.hi = knots.Last();
  return axis;
}

/// Of `ends` of smooth intervals what lies in (lo, hi), with more so that there are six pieces or more.
SmoothAxis axis_of_intervals(const TColStd_Array1OfReal& ends, bool periodic, double lo, double hi) {
  std::vector<double> places = knots_within(ends, periodic, lo, hi);
  places.insert(places.begin(), lo);
  places.push_back(hi);
  std::vector<double> breaks = refined(places, (hi - lo) / 6);
  breaks.erase(breaks.begin()), breaks.pop_back();
  SmoothAxis axis{breaks, kTurnNodes};
  if (!periodic) axis.lo = ends.First(), axis.hi = ends.Last();
  return axis;
}

// Adaptors know no inner intervals of some splines that were read from a file, so splines are asked themselves.
Handle(Geom_BSplineCurve) spline_that_is_swept(const Handle(Geom_Surface) & surface) {
  const auto swept = Handle(Geom_SweptSurface)::DownCast(surface);
  if (swept.IsNull()) return {};
  Handle(Geom_Curve) curve = swept->BasisCurve();
  while (curve->IsKind(STANDARD_TYPE(Geom_TrimmedCurve)))
    curve = Handle(Geom_TrimmedCurve)::DownCast(curve)->BasisCurve();
  return Handle(Geom_BSplineCurve)::DownCast(curve);
}

std::array<SmoothAxis, 2> general_axes(const Handle(Geom_Surface) & surface, const Vec2& lo, const Vec2& hi) {
  const GeomAdaptor_Surface adaptor(surface);
  TColStd_Array1OfReal u(1, adaptor.NbUIntervals(GeomAbs_CN) + 1), v(1, adaptor.NbVIntervals(GeomAbs_CN) + 1);
  adaptor.UIntervals(u, GeomAbs_CN);
  adaptor.VIntervals(v, GeomAbs_CN);
  std::array axes{axis_of_intervals(u, surface->IsUPeriodic(), lo.u, hi.u),
                  axis_of_intervals(v, surface->IsVPeriodic(), lo.v, hi.v)};
  const auto spline = spline_that_is_swept(surface);
  if (spline.IsNull()) return axes;
  if (surface->IsKind(STANDARD_TYPE(Geom_SurfaceOfRevolution)))
    axes[1] = axis_of_intervals(spline->Knots(), spline->IsPeriodic(), lo.v, hi.v);
  else
    axes[0] = axis_of_intervals(spline->Knots(), spline->IsPeriodic(), lo.u, hi.u);
  return axes;
}

/// The parameters over which a circle or ellipse turns by a sixth; endless for other curves.
double turn_of(const Geom2dAdaptor_Curve& curve) {
  const bool turns = curve.GetType() == GeomAbs_Circle || curve.GetType() == GeomAbs_Ellipse;
  return turns ? kLargestTurn : HUGE_VAL;
}

}  // namespace

std::array<SmoothAxis, 2> surface_axes(const Handle(Geom_Surface) & surface, const Vec2& lo, const Vec2& hi) {
  if (auto elementary = Handle(Geom_ElementarySurface)::DownCast(surface); !elementary.IsNull())
    return elementary_axes(elementary, lo, hi);
  if (auto bezier = Handle(Geom_BezierSurface)::DownCast(surface); !bezier.IsNull()) {
    const bool rational = bezier->IsURational() || bezier->IsVRational();
    return {SmoothAxis{{}, spline_nodes(bezier->UDegree(), rational), 0, 1},
            SmoothAxis{{}, spline_nodes(bezier->VDegree(), rational), 0, 1}};
  }
  auto spline = Handle(Geom_BSplineSurface)::DownCast(surface);
  if (spline.IsNull()) return general_axes(surface, lo, hi);
  const bool rational = spline->IsURational() || spline->IsVRational();
  return {spline_axis(spline->UKnots(), spline->IsUPeriodic(), spline_nodes(spline->UDegree(), rational), lo.u, hi.u),
          spline_axis(spline->VKnots(), spline->IsVPeriodic(), spline_nodes(spline->VDegree(), rational), lo.v, hi.v)};
}

std::vector<double> smooth_places(const Geom2dAdaptor_Curve& curve, double first, double last) {
  if (curve.GetType() == GeomAbs_Line) return {first, last};
  std::vector<double> places;
  const bool is_spline = curve.GetType() == GeomAbs_BSplineCurve;
  if (is_spline) {
    places = knots_within(curve.BSpline()->Knots(), curve.IsPeriodic(), first, last);
  } else {
    TColStd_Array1OfReal ends(1, curve.NbIntervals(GeomAbs_CN) + 1);
    curve.Intervals(ends, GeomAbs_CN);
    places = knots_within(ends, false, first, last);
  }
  places.insert(places.begin(), first);
  places.push_back(last);
  const double width = (last - first) / (is_spline ? 8 : 4);
  return refined(places, std::min(width, turn_of(curve)));
}

}  // namespace tetloom::cad
