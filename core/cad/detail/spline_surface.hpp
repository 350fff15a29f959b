#pragma once
// B-spline surfaces as one polynomial per knot span, made when the span is first visited.
//
// Private to core/cad.
#include <Geom_BSplineSurface.hxx>
#include <vector>

#include "core/cad/detail/surface_evaluator.hpp"

namespace tetloom::cad {

/// The spans of one parameter direction: on each, the basis functions that do not vanish, as polynomials in
/// s = (t - middle) / half_width, so that |s| <= 1 inside the span and the power basis stays well conditioned.
class SplineAxis {
 public:
  /// `flat_knots` repeats knots by multiplicity; `period` is 0 for a curve that is not periodic.
  SplineAxis(int degree, std::vector<double> flat_knots, double period);

  struct Place {
    std::size_t span;
    double s;      ///< local parameter
    double scale;  ///< ds/dt
  };
  /// Where `t` lies. Parameters outside the domain belong to the first or last span.
  Place locate(double t);
  int degree() const { return degree_; }
  std::size_t span_count() const { return breaks_.size() - 1; }
  /// The index of the first pole that matters on a span.
  std::size_t first_pole(std::size_t span) const { return first_pole_[span]; }
  /// Coefficient of s^power of basis function `index` (0 … degree) on a span.
  double basis(std::size_t span, int index, int power) const {
    const std::size_t order = static_cast<std::size_t>(degree_) + 1;
    return basis_[(span * order + static_cast<std::size_t>(index)) * order + static_cast<std::size_t>(power)];
  }

 private:
  void add_span(const std::vector<double>& flat_knots, std::size_t index);

  int degree_;
  double period_;
  std::vector<double> breaks_;  ///< ends of the spans, ascending
  std::vector<std::size_t> first_pole_;
  std::vector<double> basis_;
  std::size_t last_ = 0;  ///< the span of the previous call; the next point is mostly near
};

/// A B-spline surface, evaluated piece by piece in the power basis.
class SplineSurface final : public SurfaceEvaluator {
 public:
  /// Highest degree for which the power basis keeps about eleven digits.
  static constexpr int kMaxDegree = 11;

  explicit SplineSurface(const Handle(Geom_BSplineSurface) & surface);
  Vec3 point(const Vec2& uv) override;
  SurfaceDerivatives derivatives(const Vec2& uv) override;
  SurfaceJet jet(const Vec2& uv) override;
  std::optional<Vec2> invert(const Vec3&, const Vec2&) override { return std::nullopt; }
  std::array<int, 2> pieces() const override {
    return {static_cast<int>(u_.span_count()), static_cast<int>(v_.span_count())};
  }

 private:
  template <int Order>
  SurfaceJet evaluate(const Vec2& uv);
  const double* patch(std::size_t u_span, std::size_t v_span);
  void make_patch(std::size_t u_span, std::size_t v_span, double* coefficients) const;

  SplineAxis u_, v_;
  int components_;  ///< 3, or 4 for rational surfaces (w·x, w·y, w·z, w)
  std::size_t v_poles_ = 0;
  std::vector<double> poles_;                       ///< [u][v][component]
  std::vector<std::unique_ptr<double[]>> patches_;  ///< [u_span][v_span] → [u power][v power][component]
};

}  // namespace tetloom::cad
