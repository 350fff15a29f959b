#pragma once
// Finds the places on a geometric model that are nearest to points beside it.
#include <functional>
#include <optional>

#include "tetloom/ids.hpp"
#include "tetloom/model.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// A place on a model face or edge. The direction has length 1: a face's normal, which points to the side from which
/// the face's triangles turn counter-clockwise, or an edge's tangent.
struct SurfaceSpot {
  Vec3 point, direction;
};

/// The place on a model face or edge nearest to a point; nothing where that cannot be said.
using SurfaceProjector = std::function<std::optional<SurfaceSpot>(ModelEntity, const Vec3& x)>;

/// Answers for the faces and edges of `model`, which must outlive it. Copies share evaluators: each task makes its own
/// and shares it with nobody. Answers are the same up to the model's precision whatever was asked before, where the
/// nearest place is unique; the same questions in the same order get the same answers.
SurfaceProjector make_projector(const GeometricModel& model);

}  // namespace tetloom
