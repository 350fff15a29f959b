#pragma once
// Repairing what OpenCASCADE can repair, and only that: valid shapes stay as they are. Private to core/cad.
#include "core/cad/detail/document.hpp"
#include "tetloom/model.hpp"

namespace tetloom::cad {

/// Adds what a mesher cannot do without: curves in space for edges that have none, parameter curves for edges of
/// curved faces, locations without scale or mirror. Changes the shapes in place where it can.
/// Errors: InputUnsuitable (a face without surface).
void complete_geometry(Document& document, std::vector<HealingStep>& steps);

/// Repairs invalid solids and sheets (wires, pcurves, tolerances, orientation), sews loose faces into shells, makes
/// solids of closed shells and turns solids right side out. A repair that does not lessen the faults is undone.
/// Names and colours follow the shapes. Returns whether everything is known to be valid now.
bool heal(Document& document, std::vector<HealingStep>& steps, const CancelToken* cancel, const BlockLoop& loop);

/// Sews the faces that belong to no solid, and makes solids of the closed shells among them; a closed shell inside
/// another one becomes its cavity.
void sew_loose_faces(Document& document, std::vector<HealingStep>& steps, const CancelToken* cancel);

/// Replaces the root by what `successors` gives, and lets the attributes follow.
void replace_shapes(Document& document, const TopoDS_Shape& root, const ShapeSuccessors& successors);

/// Adds a step unless nothing was done.
void add_step(std::vector<HealingStep>& steps, const char* what, std::size_t count);

}  // namespace tetloom::cad
