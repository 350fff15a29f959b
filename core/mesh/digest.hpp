#pragma once
// A fingerprint of a mesh that does not depend on how it is stored.
#include <string>

#include "core/mesh/mesh.hpp"

namespace tetloom {

/// 32 hexadecimal digits over the coordinates (bit for bit, but -0 equals +0), the connectivity and the classification
/// of everything in `mesh`.
///
/// Laws: unchanged when points or elements are renumbered, and when the vertices of an element are permuted evenly
/// (an odd permutation turns the element over and changes the digest). Any other change of a coordinate, a
/// connection or a classification changes it. Names, colours and face sides do not count.
/// Not guaranteed: two points that agree in coordinates and in classification are not told apart by the elements that
/// use them, and the digest resists accidents, not attackers.
///
/// SipHash-2-4 with 128-bit output (Aumasson & Bernstein 2012) of each point; of each element over the 64-bit point
/// hashes in ascending order, its orientation and its entity; these are added up modulo 2^128 per kind, which makes a
/// hash of the multiset (Bellare & Micciancio 1997), and hashed once more together with the counts.
///
/// Pre: indices in range, arrays of matching lengths; throws Error(InvalidArgument) otherwise. Linear; 8 bytes per
/// point of working memory. Thread safety: pure.
std::string mesh_digest(const Mesh& mesh);

}  // namespace tetloom
