#pragma once
// One body in several places, as an assembly has its screws.
#include <memory>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom::test_models {

/// `body` moved to every place; the ids of each follow those of the places before it. Its faces know their places.
std::unique_ptr<GeometricModel> place_body(std::shared_ptr<const GeometricModel> body, std::vector<RigidMotion> places);

/// A turn by `angle` about the axis through the origin, then a shift.
RigidMotion turn_about(const Vec3& axis, double angle, const Vec3& shift);

}  // namespace tetloom::test_models
