#pragma once
// How good a mesh is, with the values that figures of several meshes together are made of.
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "tetloom/check.hpp"
#include "tetloom/storage.hpp"

namespace tetloom {

/// One per element.
struct QualityValues {
  GrowingArray<float> mean_ratios;  ///< of tets
  GrowingArray<float> shapes;       ///< of triangles
  GrowingArray<float> jacobians;    ///< of cells that are no tets, as scaled_jacobian_p1
};

/// Which edges of a piece of a mesh are measured there: those of its elements that pass a test, where there is one, and
/// more.
struct MeasuredEdges {
  using Edges = std::vector<std::array<std::uint32_t, 2>>;
  std::function<bool(std::uint32_t, std::uint32_t)> test;  ///< of two points, the lower one first
  Edges more_of_tets, more_of_triangles;                   ///< whether elements of the piece have them or not
};

/// As compute_quality in tetloom/check.hpp; `values` are replaced.
QualityReport compute_quality(const Mesh& mesh, const SizeField* sizes, const BlockLoop& loop, QualityValues& values,
                              const MeasuredEdges& measured = {});

}  // namespace tetloom
