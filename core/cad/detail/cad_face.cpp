#include "core/cad/detail/cad_face.hpp"

#include <algorithm>
#include <BRep_Tool.hxx>
#include <BRepTools.hxx>
#include <Geom2d_Curve.hxx>
#include <TopoDS.hxx>

#include "core/cad/detail/conversions.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "core/cad/detail/tessellate.hpp"

namespace tetloom::cad {
namespace {

/// How far from a degenerate point, as a share of the box, the limits of normal and curvature are taken.
constexpr double kNudge = 1e-4;
/// How far the projection may leave the box, as a share of it: edges stray from their parameter curves by a tolerance.
constexpr double kSearchMargin = 0.01;

template <class Body>
auto on_face(const NamedEntity& who, const char* doing, Body&& body) {
  return translate_failures(who, ErrorCode::FaceFailed, doing, body);
}

}  // namespace

CadFace::CadFace(std::shared_ptr<const FaceShape> shape, const ModelTopology& topology, ModelFaceId id, NamedEntity who)
    : shape_(std::move(shape)), topology_(topology), id_(id), who_(std::move(who)) {
  on_face(who_, "taking the surface", [&] {
    geometry_ = untrimmed(BRep_Tool::Surface(shape_->face()));
    if (geometry_.IsNull()) throw Error(ErrorCode::FaceFailed, "the face has no surface");
    surface_ = make_evaluator(geometry_);
    period_ = {geometry_->IsUPeriodic() ? geometry_->UPeriod() : 0,
               geometry_->IsVPeriodic() ? geometry_->VPeriod() : 0};
    for (const ModelLoop& loop : topology_.face_to_loops[id_.value])
      for (const EdgeUse& use : loop) parameter_curve(use);
    find_box();
  });
}

CadFace::CadFace(const CadFace& other)
    : shape_(other.shape_),
      topology_(other.topology_),
      id_(other.id_),
      who_(other.who_),
      geometry_(other.geometry_),
      surface_(make_evaluator(geometry_)),
      box_(other.box_),
      search_box_(other.search_box_),
      period_(other.period_),
      length_scale_(other.length_scale_) {
  curves_.reserve(other.curves_.size());
  for (const ParameterCurve& curve : other.curves_)  // an adaptor of its own: they keep spans of splines
    curves_.push_back({curve.use, Geom2dAdaptor_Curve(curve.curve.Curve()), curve.range, curve.scale, curve.shift});
}

std::unique_ptr<CadFace> CadFace::another() const {
  return on_face(who_, "taking the surface", [&] { return std::unique_ptr<CadFace>(new CadFace(*this)); });
}

Vec3 CadFace::evaluate(const Vec2& uv) {
  return on_face(who_, "evaluation", [&] { return surface_->point(uv); });
}

SurfaceDerivatives CadFace::derivatives(const Vec2& uv) {
  return on_face(who_, "differentiation", [&] { return surface_->derivatives(uv); });
}

void CadFace::find_box() {
  BRepTools::UVBounds(shape_->face(), box_.lo.u, box_.hi.u, box_.lo.v, box_.hi.v);
  for (ParameterCurve& curve : curves_) {  // UVBounds may cut a loop off that leaves the surface's domain
    for (int i = 0; i <= 16; ++i) {
      const Vec2 p = edge_parameters(curve.use, curve.range.lo + (curve.range.hi - curve.range.lo) * i / 16);
      box_.lo = {std::min(box_.lo.u, p.u), std::min(box_.lo.v, p.v)};
      box_.hi = {std::max(box_.hi.u, p.u), std::max(box_.hi.v, p.v)};
    }
  }
  double lo[2], hi[2];
  geometry_->Bounds(lo[0], hi[0], lo[1], hi[1]);
  const auto widen = [](double& a, double& b, double period, double domain_lo, double domain_hi) {
    const double margin = kSearchMargin * (b - a);
    if (period > 0 && b - a + 2 * margin >= period) {
      a = -HUGE_VAL, b = HUGE_VAL;
    } else if (period > 0) {
      a -= margin, b += margin;
    } else {
      a = std::min(a, std::max(a - margin, domain_lo)), b = std::max(b, std::min(b + margin, domain_hi));
    }
  };
  search_box_ = box_;
  widen(search_box_.lo.u, search_box_.hi.u, period_.u, lo[0], hi[0]);
  widen(search_box_.lo.v, search_box_.hi.v, period_.v, lo[1], hi[1]);
  Box3 extent;
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; j <= 4; ++j)
      extent.add(
          surface_->point({box_.lo.u + (box_.hi.u - box_.lo.u) * i / 4, box_.lo.v + (box_.hi.v - box_.lo.v) * j / 4}));
  length_scale_ = extent.diagonal() > 0 ? extent.diagonal() : 1;
}

CadFace::ParameterCurve& CadFace::parameter_curve(const EdgeUse& use) {
  const auto key = [](const EdgeUse& u) { return 2 * std::size_t{u.edge.value} + (u.second_side ? 1 : 0); };
  const auto less = [&](const ParameterCurve& curve, std::size_t k) { return key(curve.use) < k; };
  auto place = std::lower_bound(curves_.begin(), curves_.end(), key(use), less);
  if (place == curves_.end() || key(place->use) != key(use)) place = curves_.insert(place, make_parameter_curve(use));
  return *place;
}

CadFace::ParameterCurve CadFace::make_parameter_curve(const EdgeUse& use) const {
  const TopoDS_Edge& edge = shape_->edge(use.edge);
  const TopoDS_Shape side = edge.Oriented(use.second_side ? TopAbs_REVERSED : TopAbs_FORWARD);
  double first = 0, last = 0;
  const Handle(Geom2d_Curve) curve = BRep_Tool::CurveOnSurface(TopoDS::Edge(side), shape_->face(), first, last);
  if (curve.IsNull()) {
    Diagnostic diagnostic{ErrorCode::FaceFailed, "an edge of the face has no parameter curve", {}, {}, {}};
    diagnostic.entities = {who_, {use.edge, ""}};
    throw Error(std::move(diagnostic));
  }
  ParameterCurve result{use, Geom2dAdaptor_Curve(curve), {first, last}, 1, 0};
  if (topology_.edges[use.edge.value].degenerate) return result;
  BRep_Tool::Range(edge, result.range.lo, result.range.hi);
  const double width = result.range.hi - result.range.lo;
  if ((result.range.lo != first || result.range.hi != last) && width > 0) {
    result.scale = (last - first) / width;
    result.shift = first - result.scale * result.range.lo;
  }
  return result;
}

Vec2 CadFace::edge_parameters(const EdgeUse& use, double t) {
  return on_face(who_, "evaluating a parameter curve", [&] {
    ParameterCurve& curve = parameter_curve(use);
    return to_vec2(curve.curve.Value(curve.scale * t + curve.shift));
  });
}

ParameterRange CadFace::edge_range(const EdgeUse& use) {
  return on_face(who_, "taking a parameter curve", [&] { return parameter_curve(use).range; });
}

Vec2 CadFace::pull_inside(const Vec2& uv, double share) const {
  const Vec2 middle = 0.5 * (box_.lo + box_.hi), width = box_.hi - box_.lo;
  const auto towards = [share](double x, double m, double w) { return x < m ? x + share * w : x - share * w; };
  return {towards(uv.u, middle.u, width.u), towards(uv.v, middle.v, width.v)};
}

Vec3 CadFace::normal(const Vec2& uv) {
  return on_face(who_, "the normal", [&] {
    const SurfaceDerivatives d = surface_->derivatives(uv);
    const Vec3 n = cross(d.du, d.dv);
    const double du = norm(d.du), dv = norm(d.dv), small = kCollapsed * length_scale_;
    const bool collapsed = du * (box_.hi.u - box_.lo.u) <= small || dv * (box_.hi.v - box_.lo.v) <= small;
    if (!collapsed && norm(n) > kCollapsed * du * dv) return normalized(n);
    return limit_normal(uv);
  });
}

// Where du or dv vanishes, the next order of the Taylor series towards the inside decides; if that vanishes too, the
// normal a little inside does.
Vec3 CadFace::limit_normal(const Vec2& uv) {
  const SurfaceJet jet = surface_->jet(uv);
  const Vec2 step = pull_inside(uv, kNudge) - uv;
  const Vec3 du = jet.du + step.u * jet.duu + step.v * jet.duv, dv = jet.dv + step.u * jet.duv + step.v * jet.dvv;
  const Vec3 n = cross(du, dv);
  if (norm(n) > kCollapsed * norm(du) * norm(dv) && norm(n) > 0) {
    // With one direction collapsed its mixed derivative alone gives the limit, without the error of a finite step.
    const bool u_collapsed = norm(jet.du) < kNudge * norm(du), v_collapsed = norm(jet.dv) < kNudge * norm(dv);
    if (u_collapsed && !v_collapsed) return normalized((step.v > 0 ? 1.0 : -1.0) * cross(jet.duv, jet.dv));
    if (v_collapsed && !u_collapsed) return normalized((step.u > 0 ? 1.0 : -1.0) * cross(jet.du, jet.duv));
    return normalized(n);
  }
  const SurfaceDerivatives inside = surface_->derivatives(pull_inside(uv, 10 * kNudge));
  return normalized(cross(inside.du, inside.dv));
}

PrincipalCurvatures CadFace::curvature(const Vec2& uv) {
  return on_face(who_, "the curvature", [&] {
    for (const double share : {0.0, kNudge, 10 * kNudge, 100 * kNudge}) {
      const SurfaceJet jet = surface_->jet(share > 0 ? pull_inside(uv, share) : uv);
      const double e = dot(jet.du, jet.du), f = dot(jet.du, jet.dv), g = dot(jet.dv, jet.dv);
      const double area = e * g - f * f;
      const double u_width = box_.hi.u - box_.lo.u, v_width = box_.hi.v - box_.lo.v;
      const double small = kCollapsed * length_scale_;
      if (!(area > 1e-16 * e * g) || std::sqrt(e) * u_width <= small || std::sqrt(g) * v_width <= small) continue;
      const Vec3 n = cross(jet.du, jet.dv) / std::sqrt(area);
      const double l = dot(jet.duu, n), m = dot(jet.duv, n), k = dot(jet.dvv, n);
      const double mean = 0.5 * (e * k - 2 * f * m + g * l) / area, gauss = (l * k - m * m) / area;
      const double root = std::sqrt(std::max(0.0, mean * mean - gauss));
      PrincipalCurvatures result{mean >= 0 ? mean + root : mean - root, mean >= 0 ? mean - root : mean + root};
      if (std::isfinite(result.largest) && std::isfinite(result.smallest)) return result;
    }
    return PrincipalCurvatures{};
  });
}

Tessellation CadFace::tessellate(double chord, double angle) {
  return on_face(who_, "tessellation", [&] { return tessellate_face(*shape_, topology_, id_, chord, angle); });
}

}  // namespace tetloom::cad
