#pragma once
// Model faces that lie on each other between the same edges, with nothing between them: a wall of no thickness, or a
// crack of no width. Both are left out of the surface mesh.
#include <vector>

#include "mesher/surface/face_mesher.hpp"

namespace tetloom {

/// Two faces that lie on each other.
struct CoincidentFaces {
  ModelFaceId first, second;  ///< ascending
};

/// The pairs of meshed faces with the same rim nodes of which the second lies on the first, within the tolerances of
/// the two or a thousandth of its triangles' size, and takes back what the first divides: behind the two together is
/// the region that is before them. A face is in one pair at most. Complexity: the rims, and projections for faces with
/// the same rim.
std::vector<CoincidentFaces> find_cancelling_faces(const GeometricModel& model, const RimNodes& rim,
                                                   const std::vector<FaceMesh>& faces);

}  // namespace tetloom
