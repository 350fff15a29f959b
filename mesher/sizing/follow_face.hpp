#pragma once
// Facets brought nearer to their face where the geometry kernel has left them far from it. Private to mesher/sizing.
#include "tetloom/model.hpp"

namespace tetloom {

/// Halves edges of facets in the parameter plane until the middle of each lies within `chord` of the face, so far as
/// four million facets go. Edges on the rim stay, so neighbours fit as before. An edge is halved for both its facets,
/// which are cut into two, three or four; facets keep their orientation. Pre: a smooth parametrisation; facets with
/// (u,v) and valid indices. Complexity: a round evaluates the face once per edge; a round halves all that is too long.
void follow_face(FaceGeometry& face, ModelFaceId id, double chord, Tessellation& facets);

}  // namespace tetloom
