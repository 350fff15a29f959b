#pragma once
// The space around a model.
#include <memory>

#include "tetloom/model.hpp"

namespace tetloom {

/// The space between a model and a box around it, as a model: for flows around it. The box has the centre of the
/// model's bounding box and `factor` times its sides, where those of a flat model count as a tenth of the longest. Its
/// one region is named "far_field", and so are the faces of the box, "far_field_1" to "far_field_6" (-x, +x, -y, +y,
/// -z, +z), which come last. Before them come the faces of the given model that the space around it touches, with their
/// names, in their order, with the region on the sides that were outside; what is inside of solids, voids in them among
/// it, is left out. Sheets have the region on both sides. The volume of the region is the box less the volumes of the
/// solids and of voids in them, which are taken from facets. Shares ownership of `model`.
/// Errors: InvalidArgument for no model and unless 1 < factor < infinity; InputUnsuitable for a model without faces.
/// Solids that touch without common faces touch in the result as well.
std::unique_ptr<GeometricModel> put_into_box(std::shared_ptr<const GeometricModel> model, double factor);

}  // namespace tetloom
