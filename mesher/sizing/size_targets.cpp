#include "mesher/sizing/size_targets.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>

namespace tetloom {
namespace {

[[noreturn]] void refuse(const std::string& option, const std::string& demand, double value) {
  std::ostringstream message;
  message << option << " must be " << demand << ", not " << value;
  throw Error(ErrorCode::InvalidArgument, message.str());
}

void check_positive(const std::string& option, double value) {
  if (!(std::isfinite(value) && value > 0)) refuse(option, "positive and finite", value);
}

void check_unset_or_positive(const std::string& option, double value) {
  if (!(std::isfinite(value) && value >= 0)) refuse(option, "positive and finite (or 0 to leave it unset)", value);
}

void check_numbers(const SizeOptions& options) {
  check_unset_or_positive("size", options.size);
  check_unset_or_positive("relative_size", options.relative_size);
  if (options.relative_size > 1) refuse("relative_size", "at most 1", options.relative_size);
  check_unset_or_positive("min_size", options.min_size);
  check_unset_or_positive("curvature", options.curvature);
  if (options.curvature > 0 && options.curvature < 3)
    refuse("curvature", "at least 3 edges per turn", options.curvature);
  check_unset_or_positive("proximity", options.proximity);
  check_positive("gradation", options.gradation);
}

/// One slot of the tables, found by an entity that has been checked.
void lower(SizeTargets& targets, const GeometricModel& model, const EntitySize& wish, std::size_t position) {
  const std::string option = "entity_sizes[" + std::to_string(position) + "]";
  check_positive(option + ".size", wish.size);
  if (wish.entity.dim > 3) refuse(option + ".entity.dim", "0, 1, 2 or 3", wish.entity.dim);
  const std::size_t count = model.topology().count(wish.entity.dim);
  if (wish.entity.index >= count)
    refuse(option + ".entity.index", "below " + std::to_string(count) + ", the number of such entities of the model",
           wish.entity.index);
  std::vector<double>* const tables[] = {&targets.vertex, &targets.edge, &targets.face, &targets.region};
  double& slot = (*tables[wish.entity.dim])[wish.entity.index];
  slot = std::min(slot, wish.size);
}

void check_points(const SizeOptions& options) {
  for (std::size_t i = 0; i < options.point_sizes.size(); ++i) {
    const std::string option = "point_sizes[" + std::to_string(i) + "]";
    check_positive(option + ".size", options.point_sizes[i].size);
    if (!is_finite(options.point_sizes[i].point))
      throw Error(ErrorCode::InvalidArgument, option + ".point must be finite");
  }
}

double global_size(const GeometricModel& model, const SizeOptions& options) {
  constexpr double kDefaultShare = 1.0 / 40;
  const Box3& box = model.bounding_box();
  if (box.empty() || !is_finite(box.lo) || !is_finite(box.hi) || !(box.diagonal() > 0))
    throw Error(ErrorCode::InputUnsuitable, "the model has no extent");
  if (options.size > 0) return options.size;
  return (options.relative_size > 0 ? options.relative_size : kDefaultShare) * box.diagonal();
}

}  // namespace

SizeTargets resolve_sizes(const GeometricModel& model, const SizeOptions& options) {
  check_numbers(options);
  check_points(options);
  const ModelTopology& topology = model.topology();
  SizeTargets targets;
  targets.global = global_size(model, options);
  targets.floor = std::min(options.min_size > 0 ? options.min_size : targets.global / 10, targets.global);
  targets.floor_is_default = !(options.min_size > 0);
  targets.gradation = std::min(options.gradation, 1.0);
  targets.curvature = options.curvature;
  targets.proximity = options.proximity;
  targets.vertex.assign(topology.vertex_count, HUGE_VAL);
  targets.edge.assign(topology.edge_count(), HUGE_VAL);
  targets.face.assign(topology.face_count(), HUGE_VAL);
  targets.region.assign(topology.region_count(), HUGE_VAL);
  for (std::size_t i = 0; i < options.entity_sizes.size(); ++i) lower(targets, model, options.entity_sizes[i], i);
  targets.smallest_region = HUGE_VAL;
  for (std::size_t r = 0; r < targets.region.size(); ++r) {
    targets.smallest_region = std::min(targets.smallest_region, targets.region[r]);
    for (const ModelFaceId face : topology.region_to_faces[r])
      targets.face[face.value] = std::min(targets.face[face.value], targets.region[r]);
  }
  return targets;
}

}  // namespace tetloom
