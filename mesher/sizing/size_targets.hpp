#pragma once
// The size options with every default resolved and every entity looked up. Private to mesher/sizing.
#include <vector>

#include "mesher/sizing/build_size_field.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

namespace tetloom {

/// Sizes per entity are infinite where none is asked for. A region's size has been handed to its faces.
struct SizeTargets {
  double global = 0;             ///< the target size, and the largest
  double floor = 0;              ///< for sizes from curvature and proximity
  bool floor_is_default = true;  ///< nobody asked for it: thin parts may go below
  double gradation = 0;          ///< at most 1: a mesh cannot follow a faster growth
  double curvature = 0;          ///< edges per turn; 0: off
  double proximity = 0;          ///< layers; 0: off
  SmallWidth small;              ///< faces and edges below it ask for no sizes for their curvature
  std::vector<double> wires;     ///< edges per turn on each face around a wire where `curvature` is off; 0: no wire
  std::vector<double> vertex, edge, face, region;
  double smallest_region = 0;  ///< the least of `region`
};

/// Checks the options against the model and resolves them.
/// Errors: InvalidArgument naming the option; InputUnsuitable for a model without extent.
SizeTargets resolve_sizes(const GeometricModel& model, const SizeOptions& options);

}  // namespace tetloom
