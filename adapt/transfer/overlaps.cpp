#include "adapt/transfer/overlaps.hpp"

#include <algorithm>
#include <cmath>

#include "core/base/mix_bits.hpp"

namespace tetloom::adapt {
namespace {

constexpr double kFull = 1e-10;               // a share that may be missing
constexpr double kLeastShare = 1e-15;         // round-off below
constexpr double kApart = 1e-9;               // of the largest distance from a plane: beyond this two tets do not touch
constexpr std::size_t kMostAround = 1 << 14;  // tets looked at for one of a region

bool lies_behind(const std::array<double, 4>& values) {
  double most = 0;
  for (const double value : values) most = std::max(most, std::abs(value));
  return std::all_of(values.begin(), values.end(), [&](double value) { return value < -kApart * most; });
}

}  // namespace

void NumberSet::clear() { ++round_, count_ = 0; }

std::size_t NumberSet::slot_of(std::uint64_t number) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = mix_bits(number) & mask;
  while (!is_free(slot) && slots_[slot].number != number) slot = (slot + 1) & mask;
  return slot;
}

bool NumberSet::insert(std::uint64_t number) {
  const std::size_t slot = slot_of(number);
  if (!is_free(slot)) return false;
  slots_[slot] = {number, round_};
  if (++count_ * 2 > slots_.size()) grow();
  return true;
}

void NumberSet::grow() {
  std::vector<Slot> old(slots_.size() * 2);
  old.swap(slots_);
  for (const Slot& slot : old)
    if (slot.round == round_) slots_[slot_of(slot.number)] = slot;
}

void OverlapFinder::start(BackgroundTet tet) {
  if (seen_.insert(tet)) queue_.push_back(tet);
}

std::span<const Overlap> OverlapFinder::find(const TetView& to, const TetVerts& verts, std::uint32_t region,
                                             const std::array<BackgroundTet, 4>& hints) {
  const Corners corners = corners_of(to.points, verts);
  center_ = from_.tet_at(center_of(corners), hints[0]);
  covered_ = 0;
  if (from_[center_].region == region) {
    seen_.clear(), queue_.clear(), start(center_);
    spread(to, verts, corners, region, false);
  }
  if (std::abs(covered_ - 1) <= kFull) return overlaps_;
  seen_.clear(), queue_.clear(), start(center_);
  for (std::size_t i = 0; i < 4; ++i) start(from_.tet_at(corners[i], hints[i]));
  spread(to, verts, corners, region, true);
  return overlaps_;
}

void OverlapFinder::spread(const TetView& to, const TetVerts& verts, const Corners& corners, std::uint32_t region,
                           bool touching) {
  overlaps_.clear(), covered_ = 0;
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const BackgroundTet tet = queue_[next];
    const OldTet old = from_[tet];
    FaceValues values;
    for (std::size_t face = 0; face < 4; ++face) values[face] = face_values(old.points, old.verts, face, corners);
    ClippedTet clipped;
    if (old.region == region) clipped = clip_tet(values);
    const bool overlaps = clipped.share > kLeastShare;
    if (overlaps) {
      overlaps_.push_back({tet, clipped.share, clipped.moment});
      covered_ += clipped.share;
    }
    const bool all = touching && touches(values, to, verts, old.corners());
    for (std::uint32_t side = 0; side < 4; ++side) {
      if (!all && !(overlaps && clipped.crossed[side])) continue;
      const BackgroundFace behind = from_.behind({tet, side});
      if (behind.valid()) start(behind.tet());
    }
  }
}

/// False only where a plane of one of them has the two on different sides.
bool OverlapFinder::touches(const FaceValues& values, const TetView& to, const TetVerts& verts,
                            const Corners& corners) const {
  if (std::any_of(values.begin(), values.end(), lies_behind)) return false;
  for (std::size_t face = 0; face < 4; ++face)
    if (lies_behind(face_values(to.points, verts, face, corners))) return false;
  return true;
}

BackgroundTet OverlapFinder::nearest(std::uint32_t region) {
  seen_.clear(), queue_.clear(), start(center_);
  for (std::size_t next = 0; next < queue_.size() && next < kMostAround; ++next) {
    const BackgroundTet tet = queue_[next];
    if (from_[tet].region == region) return tet;
    for (std::uint32_t side = 0; side < 4; ++side) {
      const BackgroundFace behind = from_.behind({tet, side});
      if (behind.valid()) start(behind.tet());
    }
  }
  return kNoTet;
}

}  // namespace tetloom::adapt
