#pragma once
// Which lattice fills the inside of a volume.

namespace tetloom {

/// Bcc: body-centred cubic. A15: of fewer and better tetrahedra for the same mean edge.
enum class LatticeKind { Bcc, A15 };

}  // namespace tetloom
