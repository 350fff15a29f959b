#pragma once
// Where a size field that was refined differs from the one before.
#include <optional>
#include <span>
#include <vector>

#include "tetloom/size_field.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// Leaves of `after` in which it has other sizes than `before`. Pre: `after` has no larger size anywhere, as
/// where sizes were added to those of `before`. None where the two have no leaves in common, because their octrees
/// stand on different grids or one of them is uniform; nothing can be said then. Linear.
std::optional<std::vector<Box3>> find_changes(const SizeField& before, const SizeField& after);

/// Whether the field has the same sizes, to a fifth, at points and where `motion` takes them: a mesh of one place will
/// do in the other.
bool has_same_sizes(const SizeField& sizes, const RigidMotion& motion, std::span<const Vec3> points);

}  // namespace tetloom
