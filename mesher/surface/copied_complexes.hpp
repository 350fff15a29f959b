#pragma once
// Complexes of faces that are one shape in several places.
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "tetloom/model.hpp"

namespace tetloom {

/// A complex whose faces are those of another one, moved.
struct CopiedComplex {
  RigidMotion motion;                                      ///< from where the other one stands
  std::vector<std::pair<ModelFaceId, ModelFaceId>> faces;  ///< of the other one and of this one, ascending
  std::vector<std::pair<ModelEdgeId, ModelEdgeId>> edges;  ///< likewise, degenerate ones too
};

/// The complexes that are copies of an earlier one, in ascending order. `face_to_complex`: as find_complexes gives it.
/// Complexes that share edges or vertices with others are none.
std::vector<CopiedComplex> find_copied_complexes(const GeometricModel& model,
                                                 const std::vector<std::uint32_t>& face_to_complex);

}  // namespace tetloom
