#pragma once
// How good a mesh is, with the values that figures of several meshes together are made of.
#include "tetloom/check.hpp"
#include "tetloom/growing_array.hpp"

namespace tetloom {

/// One per element.
struct QualityValues {
  GrowingArray<float> mean_ratios;  ///< of tets
  GrowingArray<float> shapes;       ///< of triangles
};

/// As compute_quality in tetloom/check.hpp; `values` are replaced.
QualityReport compute_quality(const Mesh& mesh, const SizeField* sizes, const BlockLoop& loop, QualityValues& values);

}  // namespace tetloom
