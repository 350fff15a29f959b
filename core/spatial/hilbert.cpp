#include "core/spatial/hilbert.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace tetloom {

namespace {

/// How the curve runs through one cube: the corner where it enters and the axis along which it leaves.
struct Pose {
  unsigned corner = 0, axis = 0;
};

constexpr unsigned rotate_left(unsigned v, unsigned by) { return ((v << by) | (v >> (3 - by))) & 7; }
constexpr unsigned rotate_right(unsigned v, unsigned by) { return ((v >> by) | (v << (3 - by))) & 7; }
constexpr unsigned gray(unsigned v) { return v ^ (v >> 1); }
constexpr unsigned gray_rank(unsigned v) { return v ^ (v >> 1) ^ (v >> 2); }
constexpr unsigned trailing_ones(unsigned v) { return static_cast<unsigned>(std::countr_one(v)); }

/// The eighth of the cube with the corner bits `octant` comes as number `rank` and has the pose `inner`.
struct CurveStep {
  unsigned rank;
  Pose inner;
};

constexpr CurveStep step(Pose pose, unsigned octant) {
  const unsigned turn = (pose.axis + 1) % 3;
  const unsigned rank = gray_rank(rotate_right(octant ^ pose.corner, turn));
  const unsigned entry = rank == 0 ? 0 : gray((rank - 1) & ~1U);
  const unsigned leaving = rank == 0 ? 0 : trailing_ones(rank % 2 == 0 ? rank - 1 : rank) % 3;
  return {rank, {pose.corner ^ rotate_left(entry, turn), (pose.axis + leaving + 1) % 3}};
}

/// By 8 · pose + octant: 8 · inner pose + rank, a pose counted as 3 · corner + axis.
constexpr auto kSteps = [] {
  std::array<std::uint8_t, 24 * 8> table{};
  for (unsigned pose = 0; pose < 24; ++pose)
    for (unsigned octant = 0; octant < 8; ++octant) {
      const CurveStep s = step({pose / 3, pose % 3}, octant);
      table[8 * pose + octant] = static_cast<std::uint8_t>(8 * (3 * s.inner.corner + s.inner.axis) + s.rank);
    }
  return table;
}();

/// The same for two levels at once, by 64 · pose + the last two bits of x, y and z: 64 · inner pose + both ranks.
constexpr auto kDoubleSteps = [] {
  std::array<std::uint16_t, 24 * 64> table{};
  for (unsigned pose = 0; pose < 24; ++pose) {
    for (unsigned x = 0; x < 4; ++x)
      for (unsigned y = 0; y < 4; ++y)
        for (unsigned z = 0; z < 4; ++z) {
          const unsigned outer = kSteps[8 * pose + ((x >> 1) | (y >> 1) << 1 | (z >> 1) << 2)];
          const unsigned inner = kSteps[(outer & ~7U) + ((x & 1) | (y & 1) << 1 | (z & 1) << 2)];
          table[64 * pose + (x | y << 2 | z << 4)] =
              static_cast<std::uint16_t>((inner & ~7U) << 3 | (outer & 7) << 3 | (inner & 7));
        }
  }
  return table;
}();

static_assert(kHilbertBits % 2 == 1);
constexpr int kTop = kHilbertBits - 1;

/// The way down to a cell: its key from the most significant bits on.
class Descent {
 public:
  Descent(std::int64_t x, std::int64_t y, std::int64_t z) : x_(x), y_(y), z_(z) {
    const unsigned first = kSteps[static_cast<unsigned>((x >> kTop & 1) | (y >> kTop & 1) << 1 | (z >> kTop & 1) << 2)];
    key = first & 7;
    pose_ = (first & ~7U) << 3;
  }
  /// Two levels; `bit` is the lower one of them.
  void go_down(int bit) {
    const auto place = static_cast<unsigned>((x_ >> bit & 3) | (y_ >> bit & 3) << 2 | (z_ >> bit & 3) << 4);
    const unsigned next = kDoubleSteps[pose_ + place];
    key = key << 6 | (next & 63);
    pose_ = next & ~63U;
  }

  std::uint64_t key;  ///< as far as it is known

 private:
  std::int64_t x_, y_, z_;
  unsigned pose_;  // times 64
};

}  // namespace

std::uint64_t hilbert_key(std::int64_t x, std::int64_t y, std::int64_t z) {
  Descent descent(x, y, z);
  for (int bit = kTop - 2; bit >= 0; bit -= 2) descent.go_down(bit);
  return descent.key;
}

std::size_t hilbert_piece(std::int64_t x, std::int64_t y, std::int64_t z, std::span<const std::uint64_t> cuts) {
  Descent descent(x, y, z);
  // Those before `first` are not above the key, those from `last` on are.
  auto first = cuts.begin(), last = cuts.end();
  for (int bit = kTop;; descent.go_down(bit)) {
    const auto known = [bit](std::uint64_t cut) { return cut >> (3 * bit); };
    first = std::ranges::lower_bound(first, last, descent.key, {}, known);
    last = std::ranges::upper_bound(first, last, descent.key, {}, known);
    if (bit == 0 || first == last) break;
    bit -= 2;
  }
  return static_cast<std::size_t>(last - cuts.begin());
}

}  // namespace tetloom
