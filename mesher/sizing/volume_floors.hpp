#pragma once
// Curved faces where the floor of sizes would take too much of a solid's volume: the rounded grooves of a long and thin
// profile, of which the size says nothing because it comes from the whole box. Private to mesher/sizing.
#include <vector>

#include "mesher/sizing/size_targets.hpp"
#include "tetloom/model.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// A curved face, as far as the volume beside it depends on the size there.
struct CurvedFace {
  double area = 0;
  double bend = 0;   ///< the integral of the sum of the principal curvatures; a length, signed by the normal
  double width = 0;  ///< across the curvature, at least; no size makes the face lose more than this one does
  double wish = 0;   ///< the size that its curvature asks for
};

/// What the volume on one side of the face changes by, where its edges have the length `size`; without sign. The mean
/// sag of an inscribed triangle is a sixteenth of size² (k1 + k2), that of a chord across a strip a twelfth of width² k
/// (see curvature_size.hpp).
double volume_lost(const CurvedFace& face, double size);

/// `floors`, one per face, lowered where a solid would lose, or gain, more than half a percent of its volume between
/// its faces and their mesh. Faces get the sizes that meet this with the fewest triangles, which fall with the fourth
/// root of the curvature, but none below its wish. Where all of these take too many triangles, the solids that take
/// most may lose more. `faces`: one per face of the model; those without an area do not count.
std::vector<double> lower_floors_for_volumes(const GeometricModel& model, const std::vector<CurvedFace>& faces,
                                             std::vector<double> floors);

/// The face from a few samples; without an area where it is flat, or everywhere coarser than `floor`.
CurvedFace measure_curved_face(const GeometricModel& model, ModelFaceId face, FaceGeometry& geometry,
                               const Tessellation& facets, double edges_per_turn, double floor);

}  // namespace tetloom
