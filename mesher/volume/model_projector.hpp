#pragma once
// Finds the places on a geometric model that are nearest to points beside it.
#include "mesher/tets/surface_geometry.hpp"
#include "tetloom/model.hpp"

namespace tetloom::volume {

/// Answers for the faces and edges of `model`, which must outlive it. Copies share evaluators: each task makes its own
/// and shares it with nobody. Answers are the same up to the model's precision whatever was asked before, where the
/// nearest place is unique; the same questions in the same order get the same answers.
tets::SurfaceProjector make_projector(const GeometricModel& model);

}  // namespace tetloom::volume
