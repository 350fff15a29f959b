#pragma once
// One edge of an OpenCASCADE shape as an EdgeGeometry. Private to core/cad.
#include <GeomAdaptor_Curve.hxx>
#include <TopoDS_Edge.hxx>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::cad {

/// A curve of OpenCASCADE's as the model's edge.
class CadEdge final : public EdgeGeometry {
 public:
  /// `edge` runs forward, is not degenerate and has a 3D curve. Errors: EdgeFailed.
  CadEdge(const TopoDS_Edge& edge, NamedEntity who);

  ParameterRange range() override { return range_; }
  double period() override { return period_; }
  Vec3 evaluate(double t) override;
  Vec3 derivative(double t) override;
  double curvature(double t) override;
  CurvePoint closest_point(const Vec3& x) override;

 private:
  CurvePoint refine(const Vec3& x, double lo, double hi);
  void make_samples();

  NamedEntity who_;
  GeomAdaptor_Curve curve_;  ///< with a span cache of its own
  ParameterRange range_;
  double period_ = 0;
  std::vector<double> sample_t_;  ///< empty until the first closest_point
  std::vector<Vec3> samples_;
};

}  // namespace tetloom::cad
