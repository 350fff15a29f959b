#pragma once
// Two doubles at a time, by a vector type that both GCC and Clang have on every machine: the sums over a vertex's star
// are most of what its motion costs. Lanes never mix but in `sum`, so results do not depend on the machine's width.
#include <cstddef>
#include <span>

#include "core/tets/star_tet.hpp"
#include "tetloom/vec.hpp"

namespace tetloom::tets::pairs {

using Pair = double __attribute__((vector_size(16)));

inline Pair pair_of(double value) { return Pair{value, value}; }
inline double sum(Pair a) { return a[0] + a[1]; }
inline Pair max(Pair a, Pair b) { return a > b ? a : b; }
inline Pair min(Pair a, Pair b) { return a < b ? a : b; }

/// Two vectors, side by side for vector instructions.
struct PairVec {
  Pair x, y, z;
};

inline PairVec pair_of(const Vec3& a, const Vec3& b) { return {Pair{a.x, b.x}, Pair{a.y, b.y}, Pair{a.z, b.z}}; }
inline PairVec pair_of(const Vec3& a) { return pair_of(a, a); }
inline Vec3 lane(const PairVec& a, int i) { return {a.x[i], a.y[i], a.z[i]}; }
inline PairVec operator+(const PairVec& a, const PairVec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline PairVec operator-(const PairVec& a, const PairVec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline PairVec operator*(Pair s, const PairVec& a) { return {s * a.x, s * a.y, s * a.z}; }
inline Pair dot(const PairVec& a, const PairVec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline PairVec cross(const PairVec& a, const PairVec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Two tets of a star.
struct TetPair {
  PairVec normal, middle;
  Pair volume, squares;
};

inline TetPair pair_of(const StarTet& a, const StarTet& b) {
  return {pair_of(a.normal, b.normal), pair_of(a.middle, b.middle), Pair{a.volume, b.volume},
          Pair{a.squares, b.squares}};
}

/// The second of a pair whose first is the last of an odd number: it adds nothing to any sum.
inline StarTet neutral_tet() { return {{}, {}, 1e100, 0}; }

/// Both tets of a pair.
inline void store(const TetPair& pair, StarTet& first, StarTet& second) {
  second = {lane(pair.normal, 1), lane(pair.middle, 1), pair.volume[1], pair.squares[1]};
  first = {lane(pair.normal, 0), lane(pair.middle, 0), pair.volume[0], pair.squares[0]};
}

/// Calls visit(TetPair) for all tets of a star, in order.
template <class Visit>
void for_each_pair(std::span<const StarTet> star, Visit&& visit) {
  std::size_t i = 0;
  for (; i + 1 < star.size(); i += 2) visit(pair_of(star[i], star[i + 1]));
  if (i < star.size()) visit(pair_of(star[i], neutral_tet()));
}

/// star_tet for two tets.
inline TetPair star_pair(const PairVec& a, const PairVec& b, const PairVec& c) {
  const PairVec p = b - a, q = c - a, r = c - b;
  const PairVec normal = cross(p, q);
  return {normal, a + b + c, -dot(normal, a), dot(p, p) + dot(q, q) + dot(r, r) + dot(a, a) + dot(b, b) + dot(c, c)};
}

}  // namespace tetloom::tets::pairs
