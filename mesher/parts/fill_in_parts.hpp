#pragma once
// Fills a complex in parts: each part by its own task, what lies between them after it has moved.
//
// The steps, all of them through the scheduler:
//   points     sites of the lattices in the part's box; those near other parts are sent there
//   core       tets of the undisturbed lattice in closed form; points of the shell near other parts are sent there
//   shell      the Delaunay tetrahedralisation of surface and shell points, certified: see shell_steps.hpp
//   optimize   core and shell joined, and all that does not touch other parts optimised
//   strips     in rounds: what lies between parts moves and is optimised: see strips.hpp
//   finish     the surface improved where it is free, everything looked at once more
// The decomposition is de Cougny & Shephard's (1999a): octants of the inside by templates, parts by bisection, what
// lies between parts after it has moved. Departures: what one part may do is decided by certified Delaunay tets and not
// by the distance from its boundary, so that no part of the volume is left open between the parts, and strips hold what
// is to be bettered only.
#include "mesher/parts/part_state.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "mesher/volume/volume_parts.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::parts {

/// A complex that was filled in parts.
struct FilledParts {
  VolumeParts volume;  ///< points and triangles numbered as in the complex; after a fault, figures alone
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;  ///< the complex's triangles as they have become
  tets::Fault fault;  ///< any: why the parts do not fit together; one part may succeed where they do not
};

/// The result depends on the input alone. Nothing when the complex is too small for two parts. Errors: Cancelled,
/// OutOfMemory. The ranks that share the parts call it, in `together`; all give the same input, and know all but the
/// parts of the others then.
std::optional<FilledParts> fill_in_parts(const volume::FillingInput& input, const SharedWork& work);

}  // namespace tetloom::parts
