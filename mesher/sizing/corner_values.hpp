#pragma once
// Sizes at the corners of the octree's leaves. Private to mesher/sizing.
#include <cstdint>
#include <vector>

#include "mesher/sizing/octree_builder.hpp"
#include "mesher/sizing/target_field.hpp"
#include "tetloom/size_field.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// What the field says at corners of a tree's leaves, by their Morton codes, which ascend.
struct CornerSizes {
  std::vector<std::uint64_t> codes;
  std::vector<double> sizes;
};

/// Fills `tree.corner_ratios` from the field, which is asked once for each corner however many leaves share it. Where
/// the field may be steeper than the gradation (a callback), corners are lowered until |h(a) - h(b)| <= g |a - b| for
/// any two corners of a leaf: the largest such values, which are unique, whatever the order of the sweeps. Leaves that
/// turn out to hold the global size throughout lose their entry. `known`: of a tree in the same frame without the
/// field's latest refinements, or none. Returns what the field says at the corners that this rank looked at.
CornerSizes fill_corner_ratios(SizeOctree& tree, const std::vector<OctreeBlock>& blocks, const TargetField& field,
                               const CornerSizes& known, const SharedWork& work);

}  // namespace tetloom
