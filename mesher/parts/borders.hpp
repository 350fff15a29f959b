#pragma once
// What parts know of each other's borders: how far they look for each other there, and whether their open faces fit
// together in the end.
#include <span>

#include "mesher/parts/all_parts.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

/// How far from an open face the boxes of parts are looked for that may have it, too.
double reach_of(const tets::TetMesh& mesh, tets::FaceCode open_face);

/// No more than that, for a third of the work.
double least_reach_of(const tets::TetMesh& mesh, tets::FaceCode open_face);

/// Tells the neighbours of the part's open faces, of its points of the surface, and of the angle of its worst tet where
/// that will stay.
BorderCheck send_borders(const SharedInput& input, const PartTets& part, std::span<const tets::FaceCode> open_faces,
                         PartTask& task);

/// Notes what the neighbours have told: points of the surface elsewhere, the least angle, and which open faces none of
/// them has. The fault: several have the same.
tets::Fault take_borders(BorderCheck& check, PartTask& task);

/// Whether every open face is one of two parts. Strips may have brought together parts that do not tell each other of
/// all they have: what they have not been told of is asked of all. A collective call.
bool all_faces_met(const AllParts& parts);

}  // namespace tetloom::parts
