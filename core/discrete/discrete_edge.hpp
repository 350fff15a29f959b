#pragma once
// A model edge of a discrete model. Private to core/discrete.
#include <memory>
#include <vector>

#include "core/discrete/polyline.hpp"
#include "tetloom/model.hpp"

namespace tetloom::detail {

/// t is the arc length along the polyline; a closed edge has its length as period and accepts any t, other edges clamp
/// t to their range. The derivative is the unit direction of the piece (at a point between two: of the later one). The
/// curvature at a point of the polyline is that of the circle through it and its two neighbours, linear in between.
class DiscreteEdge final : public EdgeGeometry {
 public:
  explicit DiscreteEdge(std::shared_ptr<const Polyline> line);

  ParameterRange range() override { return {0, length()}; }
  double period() override { return line_.closed ? length() : 0; }
  Vec3 evaluate(double t) override;
  Vec3 derivative(double t) override;
  double curvature(double t) override;
  CurvePoint closest_point(const Vec3& x) override;

 private:
  double length() const { return line_.lengths.back(); }
  std::size_t piece_count() const { return line_.points.size() - 1; }
  /// t brought into the range.
  double normalize(double t) const;
  /// The piece that holds a normalised t.
  std::size_t find_piece(double t) const;
  double curvature_at(std::size_t point) const;
  void box_pieces();

  static constexpr std::size_t kPiecesPerBox = 16;
  std::shared_ptr<const Polyline> held_;
  const Polyline& line_;
  std::vector<Box3> boxes_;  // of runs of pieces
};

}  // namespace tetloom::detail
