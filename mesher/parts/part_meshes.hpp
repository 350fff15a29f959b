#pragma once
// What the parts have made, handed on as parts or put together.
#include "mesher/parts/all_parts.hpp"
#include "mesher/volume/volume_parts.hpp"

namespace tetloom::parts {

struct HandedOn {
  std::vector<VolumePart> parts;         ///< those of this rank; points and triangles numbered as in the complex
  std::vector<std::uint64_t> first_new;  ///< per part of this rank: the number of the first new point that it made
  std::uint64_t new_points = 0;          ///< of all parts
};

enum class HandsOn { Tets, TetsAndTriangles };

/// Each part's tets with the vertices that they use. New points are numbered by the part that made them, then in the
/// order in which they were made. The states are emptied first. A collective call. Errors: Cancelled.
HandedOn hand_on_parts(const AllParts& all, HandsOn what);

/// All tets, those of each part together, over the given points and then the new ones. The parts are freed one by one
/// while the whole grows. Pre: these are all parts. Errors: OutOfMemory; Cancelled.
volume::Filling put_together(const AllParts& all, HandedOn&& handed_on);

}  // namespace tetloom::parts
