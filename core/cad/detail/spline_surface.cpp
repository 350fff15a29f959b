#include "core/cad/detail/spline_surface.hpp"

#include <algorithm>
#include <TColStd_Array1OfReal.hxx>

namespace tetloom::cad {
namespace {

std::vector<double> to_vector(const TColStd_Array1OfReal& array) { return {array.begin(), array.end()}; }

double wrap(double t, double lo, double period) { return t - period * std::floor((t - lo) / period); }

/// dst += factor · (a + b·s) · src, for polynomials of degree < order.
void add_linear_multiple(double* dst, const double* src, double a, double b, int order) {
  for (int k = 0; k < order; ++k) dst[k] += a * src[k] + (k > 0 ? b * src[k - 1] : 0.0);
}

Handle(Geom_BSplineSurface) without_periods(const Handle(Geom_BSplineSurface) & surface) {
  if (!surface->IsUPeriodic() && !surface->IsVPeriodic()) return surface;
  Handle(Geom_BSplineSurface) copy = Handle(Geom_BSplineSurface)::DownCast(surface->Copy());
  copy->SetUNotPeriodic();
  copy->SetVNotPeriodic();
  return copy;
}

}  // namespace

SplineAxis::SplineAxis(int degree, std::vector<double> flat_knots, double period) : degree_(degree), period_(period) {
  const std::size_t p = static_cast<std::size_t>(degree);
  for (std::size_t i = p; i + p + 1 < flat_knots.size(); ++i)
    if (flat_knots[i] < flat_knots[i + 1]) add_span(flat_knots, i);
}

// Cox–de Boor recursion on polynomials instead of numbers.
void SplineAxis::add_span(const std::vector<double>& t, std::size_t i) {
  const int order = degree_ + 1;
  const double middle = 0.5 * (t[i] + t[i + 1]), half = 0.5 * (t[i + 1] - t[i]);
  if (breaks_.empty()) breaks_.push_back(t[i]);
  breaks_.push_back(t[i + 1]);
  first_pole_.push_back(i - static_cast<std::size_t>(degree_));
  const auto row = [order](int j) { return static_cast<std::size_t>(j) * static_cast<std::size_t>(order); };
  std::vector<double> now(static_cast<std::size_t>(order) * (order + 1), 0.0), next;
  now[row(degree_)] = 1;  // row j holds basis function i - degree + j
  for (int k = 1; k <= degree_; ++k) {
    next.assign(now.size(), 0.0);
    for (int j = degree_ - k; j <= degree_; ++j) {
      const std::size_t f = i - static_cast<std::size_t>(degree_) + static_cast<std::size_t>(j);
      const double rise = t[f + k] - t[f], fall = t[f + k + 1] - t[f + 1];
      if (rise > 0) add_linear_multiple(&next[row(j)], &now[row(j)], (middle - t[f]) / rise, half / rise, order);
      if (fall > 0)
        add_linear_multiple(&next[row(j)], &now[row(j + 1)], (t[f + k + 1] - middle) / fall, -half / fall, order);
    }
    now.swap(next);
  }
  basis_.insert(basis_.end(), now.begin(), now.begin() + static_cast<std::ptrdiff_t>(row(order)));
}

SplineAxis::Place SplineAxis::locate(double t) {
  if (period_ > 0) t = wrap(t, breaks_.front(), period_);
  if (!(t >= breaks_[last_] && t < breaks_[last_ + 1])) {
    const auto above = std::upper_bound(breaks_.begin() + 1, breaks_.end() - 1, t);
    last_ = static_cast<std::size_t>(above - breaks_.begin()) - 1;
  }
  const double lo = breaks_[last_], hi = breaks_[last_ + 1], scale = 2 / (hi - lo);
  return {last_, (t - 0.5 * (lo + hi)) * scale, scale};
}

SplineSurface::SplineSurface(const Handle(Geom_BSplineSurface) & periodic)
    : u_(periodic->UDegree(), to_vector(without_periods(periodic)->UKnotSequence()),
         periodic->IsUPeriodic() ? periodic->UPeriod() : 0),
      v_(periodic->VDegree(), to_vector(without_periods(periodic)->VKnotSequence()),
         periodic->IsVPeriodic() ? periodic->VPeriod() : 0),
      components_(periodic->IsURational() || periodic->IsVRational() ? 4 : 3) {
  const Handle(Geom_BSplineSurface) surface = without_periods(periodic);
  v_poles_ = static_cast<std::size_t>(surface->NbVPoles());
  for (int i = 1; i <= surface->NbUPoles(); ++i) {
    for (int j = 1; j <= surface->NbVPoles(); ++j) {
      const gp_Pnt& pole = surface->Pole(i, j);
      const double weight = components_ == 4 ? surface->Weight(i, j) : 1;
      poles_.insert(poles_.end(), {weight * pole.X(), weight * pole.Y(), weight * pole.Z()});
      if (components_ == 4) poles_.push_back(weight);
    }
  }
  patches_.resize(u_.span_count() * v_.span_count());
}

const double* SplineSurface::patch(std::size_t u_span, std::size_t v_span) {
  std::unique_ptr<double[]>& slot = patches_[u_span * v_.span_count() + v_span];
  if (!slot) {
    slot = std::make_unique<double[]>(static_cast<std::size_t>((u_.degree() + 1) * (v_.degree() + 1) * components_));
    make_patch(u_span, v_span, slot.get());
  }
  return slot.get();
}

void SplineSurface::make_patch(std::size_t u_span, std::size_t v_span, double* coefficients) const {
  const int p = u_.degree(), q = v_.degree(), dim = components_;
  std::vector<double> row(static_cast<std::size_t>((q + 1) * dim));
  for (int i = 0; i <= p; ++i) {
    const double* poles = &poles_[((u_.first_pole(u_span) + i) * v_poles_ + v_.first_pole(v_span)) * dim];
    std::fill(row.begin(), row.end(), 0.0);
    for (int j = 0; j <= q; ++j)
      for (int l = 0; l <= q; ++l)
        for (int c = 0; c < dim; ++c) row[l * dim + c] += v_.basis(v_span, j, l) * poles[j * dim + c];
    for (int k = 0; k <= p; ++k)
      for (std::size_t e = 0; e < row.size(); ++e) coefficients[k * row.size() + e] += u_.basis(u_span, i, k) * row[e];
  }
}

namespace {

/// Value and derivatives of a homogeneous patch in local parameters: [0] value, [1] s, [2] t, [3] ss, [4] st, [5] tt.
template <int Dim, int Order>
void horner(const double* c, int p, int q, double s, double t, double (&out)[6][4]) {
  double d[6][4] = {};
  for (int k = p; k >= 0; --k) {
    const double* row = c + k * (q + 1) * Dim;
    double r0[Dim] = {}, r1[Dim] = {}, r2[Dim] = {};
    for (int l = q; l >= 0; --l) {
      for (int e = 0; e < Dim; ++e) {
        if constexpr (Order >= 2) r2[e] = r2[e] * t + r1[e];
        if constexpr (Order >= 1) r1[e] = r1[e] * t + r0[e];
        r0[e] = r0[e] * t + row[l * Dim + e];
      }
    }
    for (int e = 0; e < Dim; ++e) {
      if constexpr (Order >= 2) {
        d[3][e] = d[3][e] * s + d[1][e];
        d[4][e] = d[4][e] * s + d[2][e];
        d[5][e] = d[5][e] * s + 2 * r2[e];
      }
      if constexpr (Order >= 1) {
        d[1][e] = d[1][e] * s + d[0][e];
        d[2][e] = d[2][e] * s + r1[e];
      }
      d[0][e] = d[0][e] * s + r0[e];
    }
  }
  for (int n = 0; n < 6; ++n)
    for (int e = 0; e < Dim; ++e) out[n][e] = d[n][e] * (n == 3 ? 2 : 1);
}

Vec3 vec(const double (&a)[4]) { return {a[0], a[1], a[2]}; }

}  // namespace

template <int Order>
SurfaceJet SplineSurface::evaluate(const Vec2& uv) {
  const SplineAxis::Place u = u_.locate(uv.u), v = v_.locate(uv.v);
  const double* coefficients = patch(u.span, v.span);
  double h[6][4];
  if (components_ == 3)
    horner<3, Order>(coefficients, u_.degree(), v_.degree(), u.s, v.s, h);
  else
    horner<4, Order>(coefficients, u_.degree(), v_.degree(), u.s, v.s, h);
  SurfaceJet jet{vec(h[0]), vec(h[1]), vec(h[2]), vec(h[3]), vec(h[4]), vec(h[5])};
  if (components_ == 4) {  // the quotient rule
    const double w = 1 / h[0][3];
    jet.point = w * jet.point;
    if constexpr (Order >= 1) {
      jet.du = w * (jet.du - h[1][3] * jet.point);
      jet.dv = w * (jet.dv - h[2][3] * jet.point);
    }
    if constexpr (Order >= 2) {
      jet.duu = w * (jet.duu - h[3][3] * jet.point - 2 * h[1][3] * jet.du);
      jet.duv = w * (jet.duv - h[4][3] * jet.point - h[1][3] * jet.dv - h[2][3] * jet.du);
      jet.dvv = w * (jet.dvv - h[5][3] * jet.point - 2 * h[2][3] * jet.dv);
    }
  }
  if constexpr (Order >= 1) jet.du *= u.scale, jet.dv *= v.scale;
  if constexpr (Order >= 2) jet.duu *= u.scale * u.scale, jet.duv *= u.scale * v.scale, jet.dvv *= v.scale * v.scale;
  return jet;
}

Vec3 SplineSurface::point(const Vec2& uv) { return evaluate<0>(uv).point; }

SurfaceDerivatives SplineSurface::derivatives(const Vec2& uv) {
  const SurfaceJet jet = evaluate<1>(uv);
  return {jet.point, jet.du, jet.dv};
}

SurfaceJet SplineSurface::jet(const Vec2& uv) { return evaluate<2>(uv); }

}  // namespace tetloom::cad
