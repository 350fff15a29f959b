#include "core/cad/detail/face_integrals.hpp"

#include <algorithm>
#include <array>
#include <BRep_Tool.hxx>
#include <cmath>
#include <Geom2d_Curve.hxx>
#include <Geom2d_Line.hxx>
#include <Geom2dAdaptor_Curve.hxx>
#include <Precision.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Iterator.hxx>
#include <vector>

#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/gauss_rule.hpp"
#include "core/cad/detail/smooth_pieces.hpp"
#include "core/cad/detail/surface_evaluator.hpp"

namespace tetloom::cad {
namespace {

/// A parameter curve along which the boundary of a face runs.
struct BoundaryCurve {
  Geom2dAdaptor_Curve curve;
  double first, last;
  bool reversed;

  Vec2 at(double t) const { return to_vec2(curve.Value(t)); }
  bool is_straight() const { return curve.GetType() == GeomAbs_Line; }
};

std::vector<BoundaryCurve> natural_boundary(const Handle(Geom_Surface) & surface) {
  double u[2], v[2];
  surface->Bounds(u[0], u[1], v[0], v[1]);
  for (const double bound : {u[0], u[1], v[0], v[1]})
    if (Precision::IsInfinite(bound)) return {};
  const auto line = [](double x, double y, double dx, double dy) -> Handle(Geom2d_Curve) {
    return new Geom2d_Line(gp_Pnt2d(x, y), gp_Dir2d(dx, dy));
  };
  return {{Geom2dAdaptor_Curve(line(u[0], v[0], 1, 0)), 0, u[1] - u[0], false},
          {Geom2dAdaptor_Curve(line(u[1], v[0], 0, 1)), 0, v[1] - v[0], false},
          {Geom2dAdaptor_Curve(line(u[1], v[1], -1, 0)), 0, u[1] - u[0], false},
          {Geom2dAdaptor_Curve(line(u[0], v[1], 0, -1)), 0, v[1] - v[0], false}};
}

std::vector<BoundaryCurve> boundary_of(const TopoDS_Face& face) {
  std::vector<BoundaryCurve> result;
  bool has_wire = false;
  for (TopoDS_Iterator wire(face); wire.More(); wire.Next()) {
    if (wire.Value().ShapeType() != TopAbs_WIRE) continue;
    has_wire = true;
    for (TopoDS_Iterator use(wire.Value()); use.More(); use.Next()) {
      const TopoDS_Edge edge = TopoDS::Edge(use.Value());
      const bool reversed = edge.Orientation() == TopAbs_REVERSED;
      if (!reversed && edge.Orientation() != TopAbs_FORWARD) continue;
      double first, last;
      const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(edge, face, first, last);
      if (!curve.IsNull() && last > first)
        result.push_back({Geom2dAdaptor_Curve(curve, first, last), first, last, reversed});
    }
  }
  return has_wire ? result : natural_boundary(untrimmed(BRep_Tool::Surface(face)));
}

/// Sums over a face, or their density in the parameter plane.
struct Sums {
  double area = 0;
  Vec3 vector;
  double moment = 0;

  void add(double weight, const Sums& other) {
    area += weight * other.area;
    vector += weight * other.vector;
    moment += weight * other.moment;
  }
};

/// The integral over a domain from its boundary: sums across the face, summed along the boundary.
class FaceIntegrator {
 public:
  FaceIntegrator(const Handle(Geom_Surface) & surface, const std::vector<BoundaryCurve>& boundary)
      : boundary_(boundary), surface_(make_evaluator(surface)) {
    for (const BoundaryCurve& curve : boundary_) places_.push_back(smooth_places(curve.curve, curve.first, curve.last));
    find_range();
    axes_ = surface_axes(surface, lo_, hi_);
    const auto cost = [](const SmoothAxis& axis) { return (axis.breaks.size() + 1) * std::size_t(axis.nodes); };
    across_u_ = cost(axes_[0]) <= cost(axes_[1]);
    origin_ = surface_->point(clamped(boundary_.front().at(boundary_.front().first)));
  }

  FaceIntegrals integrate() {
    Sums total;
    for (std::size_t i = 0; i < boundary_.size(); ++i) {
      const std::vector<double> cuts = cut(boundary_[i], places_[i]);
      for (std::size_t k = 0; k + 1 < cuts.size(); ++k) add_piece(boundary_[i], cuts[k], cuts[k + 1], total);
    }
    return {total.area, total.vector, origin_, total.moment};
  }

 private:
  // Along the boundary the face lies in [lo_, hi_].
  void find_range() {
    lo_ = {HUGE_VAL, HUGE_VAL}, hi_ = {-HUGE_VAL, -HUGE_VAL};
    for (std::size_t i = 0; i < boundary_.size(); ++i)
      for (const double t : places_[i]) {
        const Vec2 p = boundary_[i].at(t);
        lo_ = {std::min(lo_.u, p.u), std::min(lo_.v, p.v)};
        hi_ = {std::max(hi_.u, p.u), std::max(hi_.v, p.v)};
      }
  }

  Vec2 clamped(const Vec2& p) const {
    return {std::clamp(p.u, axes_[0].lo, axes_[0].hi), std::clamp(p.v, axes_[1].lo, axes_[1].hi)};
  }

  /// The places of a curve with those where it leaves a smooth piece of the surface.
  std::vector<double> cut(const BoundaryCurve& curve, const std::vector<double>& places) const {
    std::vector<double> cuts = places;
    for (std::size_t i = 0; i + 1 < places.size(); ++i) {
      const Vec2 a = curve.at(places[i]), b = curve.at(places[i + 1]);
      add_crossings(curve, {places[i], places[i + 1]}, {a.u, b.u}, axes_[0].breaks, &Vec2::u, cuts);
      add_crossings(curve, {places[i], places[i + 1]}, {a.v, b.v}, axes_[1].breaks, &Vec2::v, cuts);
    }
    std::sort(cuts.begin(), cuts.end());
    return cuts;
  }

  using Ends = std::array<double, 2>;

  static void add_crossings(const BoundaryCurve& curve, const Ends& t, const Ends& x, const std::vector<double>& breaks,
                            double Vec2::*coordinate, std::vector<double>& cuts) {
    const auto [least, most] = std::minmax(x[0], x[1]);
    for (auto at = std::upper_bound(breaks.begin(), breaks.end(), least); at != breaks.end() && *at < most; ++at)
      cuts.push_back(crossing(curve, t, {x[0] - *at, x[1] - *at}, *at, coordinate));
  }

  // False position in the manner of Illinois: for lines the first step is exact.
  static double crossing(const BoundaryCurve& curve, Ends t, Ends excess, double target, double Vec2::*coordinate) {
    constexpr int kMostSteps = 20;
    const double small = 1e-10 * (std::abs(excess[0]) + std::abs(excess[1]));
    double middle = t[0];
    int kept = -1;
    for (int i = 0; i < kMostSteps; ++i) {
      middle = t[0] + (t[1] - t[0]) * excess[0] / (excess[0] - excess[1]);
      const double now = curve.at(middle).*coordinate - target;
      if (std::abs(now) <= small) break;
      const int side = (now > 0) == (excess[0] > 0) ? 0 : 1;
      t[side] = middle, excess[side] = now;
      if (kept == 1 - side) excess[1 - side] *= 0.5;
      kept = 1 - side;
    }
    return middle;
  }

  int nodes_along(const BoundaryCurve& curve) const {
    const int most = std::max(axes_[0].nodes, axes_[1].nodes);
    if (curve.is_straight()) return std::min(most + 1, kMostGaussNodes);
    const bool is_spline =
        curve.curve.GetType() == GeomAbs_BSplineCurve || curve.curve.GetType() == GeomAbs_BezierCurve;
    return std::clamp(std::max(most + 3, is_spline ? curve.curve.Degree() + 2 : 7), 1, kMostGaussNodes);
  }

  void add_piece(const BoundaryCurve& curve, double from, double to, Sums& total) {
    const double half = 0.5 * (to - from);
    if (!(half > 0)) return;
    for (const GaussNode& node : gauss_rule(nodes_along(curve))) {
      gp_Pnt2d point;
      gp_Vec2d along;
      curve.curve.D1(0.5 * (from + to) + half * node.x, point, along);
      const double step = across_u_ ? along.Y() : -along.X();
      if (step == 0) continue;
      total.add((curve.reversed ? -1 : 1) * half * node.weight * step, sum_across(to_vec2(point)));
    }
  }

  /// The integral of the density from the side of the range to `place`, along the parameter across.
  Sums sum_across(const Vec2& place) {
    const SmoothAxis& axis = axes_[across_u_ ? 0 : 1];
    const double end = std::clamp(across_u_ ? place.u : place.v, axis.lo, axis.hi);
    double from = across_u_ ? lo_.u : lo_.v;
    Sums total;
    auto next = std::upper_bound(axis.breaks.begin(), axis.breaks.end(), from);
    for (; next != axis.breaks.end() && *next < end; ++next) {
      add_across(axis.nodes, from, *next, place, total);
      from = *next;
    }
    add_across(axis.nodes, from, end, place, total);
    return total;
  }

  void add_across(int nodes, double from, double to, const Vec2& place, Sums& total) {
    const double half = 0.5 * (to - from);
    if (half == 0) return;
    for (const GaussNode& node : gauss_rule(nodes)) {
      const double x = 0.5 * (from + to) + half * node.x;
      total.add(half * node.weight, density(across_u_ ? Vec2{x, place.v} : Vec2{place.u, x}));
    }
  }

  Sums density(const Vec2& uv) {
    const SurfaceDerivatives d = surface_->derivatives(clamped(uv));
    const Vec3 normal = cross(d.du, d.dv);
    return {norm(normal), normal, dot(d.point - origin_, normal)};
  }

  const std::vector<BoundaryCurve>& boundary_;
  std::vector<std::vector<double>> places_;  // of each curve
  std::unique_ptr<SurfaceEvaluator> surface_;
  std::array<SmoothAxis, 2> axes_;
  Vec2 lo_, hi_;
  bool across_u_ = true;
  Vec3 origin_;
};

}  // namespace

FaceIntegrals integrate_face(const TopoDS_Face& oriented) {
  const TopoDS_Face face = TopoDS::Face(oriented.Oriented(TopAbs_FORWARD));
  const Handle(Geom_Surface) surface = BRep_Tool::Surface(face);
  const std::vector<BoundaryCurve> boundary = boundary_of(face);
  if (surface.IsNull() || boundary.empty()) return {};
  return FaceIntegrator(untrimmed(surface), boundary).integrate();
}

void VolumeSum::add(const FaceIntegrals& face, bool reversed) {
  const double sign = reversed ? -1 : 1;
  terms_.push_back({face.origin, sign * face.area_vector, sign * face.moment});
}

// From the middle of the origins: far from the model the area vectors would have to cancel.
double VolumeSum::volume() const {
  Vec3 middle;
  for (const Term& term : terms_) middle += term.origin / static_cast<double>(terms_.size());
  double sum = 0;
  for (const Term& term : terms_) sum += term.moment + dot(term.origin - middle, term.area_vector);
  return sum / 3;
}

namespace {

TopoDS_Face without_location(const TopoDS_Shape& face) {
  return TopoDS::Face(face.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD));
}

std::vector<TopoDS_Face> bounding_faces(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Face> faces;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) {
    const TopAbs_Orientation orientation = face.Current().Orientation();
    if (orientation == TopAbs_FORWARD || orientation == TopAbs_REVERSED) faces.push_back(TopoDS::Face(face.Current()));
  }
  return faces;
}

void integrate_unknown(const std::vector<TopoDS_Face>& faces, KnownIntegrals& known, const BlockLoop& loop) {
  std::vector<TopoDS_Face> unknown;
  for (const TopoDS_Face& face : faces) {
    const TopoDS_Face local = without_location(face);
    if (known.IsBound(local)) continue;
    known.Bind(local, {});
    unknown.push_back(local);
  }
  std::vector<FaceIntegrals> found(unknown.size());
  loop.for_blocks(unknown.size(), 1, [&](std::size_t i, std::size_t) { found[i] = integrate_face(unknown[i]); });
  for (std::size_t i = 0; i < unknown.size(); ++i) known.ChangeFind(unknown[i]) = found[i];
}

}  // namespace

std::optional<FaceIntegrals> find_integrals(const KnownIntegrals& known, const TopoDS_Face& face) {
  const FaceIntegrals* found = known.Seek(without_location(face));
  if (found == nullptr) return std::nullopt;
  FaceIntegrals placed = *found;
  if (face.Location().IsIdentity()) return placed;
  const gp_Trsf place = face.Location().Transformation();
  const Vec3& n = found->area_vector;
  placed.origin = to_vec3(to_pnt(found->origin).Transformed(place));
  placed.area_vector = to_vec3(gp_Vec(n.x, n.y, n.z).Transformed(place));
  return placed;
}

double enclosed_volume(const TopoDS_Shape& shape, KnownIntegrals& known, const BlockLoop& loop) {
  const std::vector<TopoDS_Face> faces = bounding_faces(shape);
  integrate_unknown(faces, known, loop);
  VolumeSum sum;
  for (const TopoDS_Face& face : faces)
    sum.add(find_integrals(known, face).value(), face.Orientation() == TopAbs_REVERSED);
  return sum.volume();
}

}  // namespace tetloom::cad
