#pragma once
// A fingerprint of a mesh that does not depend on how it is stored.
#include <string>

#include "core/base/block_loop.hpp"
#include "core/mesh/mesh.hpp"

namespace tetloom {

/// 32 hexadecimal digits over the coordinates (bit for bit, but -0 equals +0), the connectivity and the classification
/// of everything in `mesh`.
///
/// Laws: unchanged when points or elements are renumbered, and when the vertices of an element are permuted as a
/// rotation does it (evenly, for triangles and tets); one that turns the element over changes the digest. Any other
/// change of a coordinate, a connection or a classification changes it. Names, colours, face sides and fields do not
/// count. A mesh of edges, triangles and tets alone has the digest that it had before there were other elements.
/// Not guaranteed: two points that agree in coordinates and in classification are not told apart by the elements that
/// use them, and the digest resists accidents, not attackers.
///
/// SipHash-2-4 with 128-bit output (Aumasson & Bernstein 2012) of each point; of each element over the 64-bit point
/// hashes and its entity, for edges, triangles and tets in ascending order with the orientation, for others in the
/// smallest order that a rotation gives; these are added up modulo 2^128 per kind, which makes a hash of the multiset
/// (Bellare & Micciancio 1997), and hashed once more together with the counts.
///
/// Pre: indices in range, arrays of matching lengths; throws Error(InvalidArgument) otherwise. Linear; 8 bytes per
/// point of working memory. `loop` carries out the work; the digest does not depend on it. Thread safety: pure.
std::string mesh_digest(const Mesh& mesh, const BlockLoop& loop = serial_loop());

/// The same for the fields of `mesh`: 32 digits over the name, the number of components and the values (bit for bit,
/// but -0 equals +0) of each, every tuple together with the hash of the point or cell that it hangs on.
///
/// Laws: unchanged when points, cells or fields are renumbered together with what hangs on them; changed by any change
/// of a value, a name, or of a carrier that has a value. Says nothing of a mesh without fields.
/// Pre, complexity and thread safety as for `mesh_digest`, times the number of fields.
std::string field_digest(const Mesh& mesh, const BlockLoop& loop = serial_loop());

}  // namespace tetloom
