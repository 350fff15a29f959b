#include "mesher/tets/insertion_order.hpp"

#include <algorithm>
#include <bit>

#include "core/base/mix_bits.hpp"
#include "core/spatial/hilbert.hpp"

namespace tetloom::tets {

namespace {

constexpr int kRoundBits = 3;                  // each round is 8 times as large as all before it
constexpr std::uint64_t kInsertionRounds = 5;  // so the first takes 1 point in 4096
constexpr int kGridBits = 19;

struct KeyedVert {
  std::uint64_t key;  // round, then the place along the curve
  std::uint32_t vert;
  friend bool operator<(const KeyedVert& a, const KeyedVert& b) {
    return a.key != b.key ? a.key < b.key : a.vert < b.vert;
  }
};

std::uint64_t hash_of(std::uint64_t x) { return finish_mixing((x + 0x9e3779b97f4a7c15u) * 0xbf58476d1ce4e5b9u); }

std::uint64_t round_of(std::uint32_t vert) {
  const int zeros = std::countr_zero(hash_of(vert) | std::uint64_t{1} << 60);
  return kInsertionRounds - 1 -
         std::min<std::uint64_t>(kInsertionRounds - 1, static_cast<std::uint64_t>(zeros / kRoundBits));
}

}  // namespace

std::vector<std::uint32_t> make_insertion_order(std::span<const Vec3> points, std::span<const std::uint32_t> verts) {
  Box3 box;
  for (const std::uint32_t v : verts) box.add(points[v]);
  const Vec3 extent = box.hi - box.lo;
  const double width = std::max({extent.x, extent.y, extent.z, 1e-300});
  const double scale = ((1 << kGridBits) - 1) / width;
  std::vector<KeyedVert> places;
  places.reserve(verts.size());
  for (const std::uint32_t v : verts) {
    const Vec3 x = scale * (points[v] - box.lo);
    const std::uint64_t key = hilbert_key(static_cast<std::int64_t>(x.x) << 2, static_cast<std::int64_t>(x.y) << 2,
                                          static_cast<std::int64_t>(x.z) << 2);
    places.push_back({round_of(v) << 60 | key >> 6, v});
  }
  std::sort(places.begin(), places.end());
  std::vector<std::uint32_t> order;
  order.reserve(verts.size());
  for (const KeyedVert& place : places) order.push_back(place.vert);
  return order;
}

}  // namespace tetloom::tets
