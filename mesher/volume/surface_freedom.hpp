#pragma once
// In which ways the surface of the complexes may change while they are filled, and what comes of it.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/tets/surface_improvement.hpp"
#include "mesher/volume/complex.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

/// What the complexes share of that. Immutable, so that it may be used from any number of threads. Refers to the input.
class SurfaceFreedom {
 public:
  SurfaceFreedom(const VolumeInput& input, std::span<const Complex> complexes);

  const VolumeInput& input() const { return input_; }
  /// Whether the edge between two points of the input is a piece of a model edge.
  bool is_kept(std::uint32_t a, std::uint32_t b) const;
  /// What a point of the input may slide within; nothing for points that belong to more than one complex, or to
  /// triangles that are in none, and for those at which pieces of several model edges meet.
  ModelEntity entity_of(std::uint32_t vertex) const;

 private:
  const VolumeInput& input_;
  std::vector<std::array<std::uint32_t, 2>> kept_edges_;  // ascending, the lower end first
  std::vector<std::uint8_t> may_slide_;                   // per point
};

/// The complex whose surface is improved, and what of it may change.
struct ImprovementInput {
  const Complex& complex;
  const intersection::TriangleTree& tree;  ///< of the complex
  const SurfaceFreedom& freedom;
  const tets::OptimizeOptions& options;
  std::span<const char> is_frozen = {};  ///< per point of the complex: it stays, and so do edges at it; empty: none is
};

/// Improves the filled complex with its surface, and returns the complex's triangles as they have become. The first
/// points of `mesh` are the complex's. As tets::improve_surface.
std::vector<std::array<std::uint32_t, 3>> improve(tets::TetMesh& mesh, const ImprovementInput& input,
                                                  tets::OptimizeReport& report, const TaskRunner& runner);

}  // namespace tetloom::volume
