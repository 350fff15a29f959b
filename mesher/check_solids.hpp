#pragma once
// Whether the surface mesh bounds what the model says: volumes, orientation, and solids that lie in each other.
#include <span>
#include <vector>

#include "tetloom/error.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// A mesh of the model's faces.
struct MeshedModel {
  const GeometricModel& model;
  const Mesh& surface;
  const SizeField& sizes;
};

/// Warnings, ascending by region: RegionInsideOut where the surface mesh bounds a negative volume, VolumeDiffers where
/// that volume is off by more than a hundredth of the model's (`model_volumes`, one per region, model length^3). With
/// the region, its faces (those whose areas differ most first, ten at most) and a point on the first. Regions without
/// any triangle were left out of the mesh and are not judged. Triangles of second order are curved. Linear.
std::vector<Diagnostic> check_volumes(const MeshedModel& meshed, std::span<const double> model_volumes);

/// Warnings of code RegionsOverlap, ascending by regions: pairs of regions that share no face, and of which one has a
/// point of its surface mesh inside of the other, a quarter of the size deep. With both regions, the faces at a point,
/// and the point. Overlaps that are smaller than triangles may go unnoticed, and so may small ones of large solids. A
/// ray for each of at most 1,000 points per solid that lie in the box of another, O(log n + crossings) each. Errors:
/// Cancelled.
std::vector<Diagnostic> check_overlaps(const MeshedModel& meshed, const TaskRunner& runner);

}  // namespace tetloom
