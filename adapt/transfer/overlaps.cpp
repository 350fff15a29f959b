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

void NumberSet::clear() {
  ++round_, count_ = 0;
  if (round_ >> 32 == 0) return;
  round_ = 1;
  std::fill(slots_.begin(), slots_.end(), 0);
}

std::size_t NumberSet::slot_of(std::uint32_t number) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t slot = mix_bits(number) & mask;
  while (!is_free(slot) && (slots_[slot] & 0xffffffffu) != number) slot = (slot + 1) & mask;
  return slot;
}

bool NumberSet::insert(std::uint32_t number) {
  const std::size_t slot = slot_of(number);
  if (!is_free(slot)) return false;
  slots_[slot] = round_ << 32 | number;
  if (++count_ * 2 > slots_.size()) grow();
  return true;
}

void NumberSet::grow() {
  std::vector<std::uint64_t> old(slots_.size() * 2, 0);
  old.swap(slots_);
  for (const std::uint64_t entry : old)
    if (entry >> 32 == round_) slots_[slot_of(static_cast<std::uint32_t>(entry))] = entry;
}

OverlapFinder::OverlapFinder(const BackgroundMesh& mesh, std::span<const std::uint32_t> regions)
    : mesh_(mesh), regions_(regions) {}

// The mesh is in one piece.
std::uint32_t OverlapFinder::tet_at(const Vec3& x, BackgroundTet hint) const {
  return static_cast<std::uint32_t>(mesh_.locate(x, hint).tet);
}

void OverlapFinder::start(std::uint32_t tet) {
  if (seen_.insert(tet)) queue_.push_back(tet);
}

std::span<const Overlap> OverlapFinder::find(const TetView& to, const TetVerts& verts, std::uint32_t region,
                                             const std::array<BackgroundTet, 4>& hints) {
  const Corners corners{to.points[verts[0]], to.points[verts[1]], to.points[verts[2]], to.points[verts[3]]};
  center_ = tet_at(center_of(corners), hints[0]);
  covered_ = 0;
  if (regions_[center_] == region) {
    seen_.clear(), queue_.clear(), start(center_);
    spread(to, verts, corners, region, false);
  }
  if (std::abs(covered_ - 1) <= kFull) return overlaps_;
  seen_.clear(), queue_.clear(), start(center_);
  for (std::size_t i = 0; i < 4; ++i) start(tet_at(corners[i], hints[i]));
  spread(to, verts, corners, region, true);
  return overlaps_;
}

void OverlapFinder::spread(const TetView& to, const TetVerts& verts, const Corners& corners, std::uint32_t region,
                           bool touching) {
  overlaps_.clear(), covered_ = 0;
  const TetView from = mesh_.mesh();
  for (std::size_t next = 0; next < queue_.size(); ++next) {
    const std::uint32_t tet = queue_[next];
    FaceValues values;
    for (std::size_t face = 0; face < 4; ++face) values[face] = face_values(from, from.tets[tet], face, corners);
    ClippedTet clipped;
    if (regions_[tet] == region) clipped = clip_tet(values);
    const bool overlaps = clipped.share > kLeastShare;
    if (overlaps) {
      overlaps_.push_back({tet, clipped.share, clipped.moment});
      covered_ += clipped.share;
    }
    const bool all = touching && touches(values, to, verts, tet);
    for (const FaceCode face : FaceCode::of(tet)) {
      const FaceCode behind = mesh_.behind(face);
      if (behind.valid() && (all || (overlaps && clipped.crossed[face.side()]))) start(behind.tet());
    }
  }
}

/// False only where a plane of one of them has the two on different sides.
bool OverlapFinder::touches(const FaceValues& values, const TetView& to, const TetVerts& verts,
                            std::uint32_t tet) const {
  if (std::any_of(values.begin(), values.end(), lies_behind)) return false;
  const Corners corners = corners_of(mesh_.mesh(), tet);
  for (std::size_t face = 0; face < 4; ++face)
    if (lies_behind(face_values(to, verts, face, corners))) return false;
  return true;
}

std::uint32_t OverlapFinder::nearest(std::uint32_t region) {
  seen_.clear(), queue_.clear(), start(center_);
  for (std::size_t next = 0; next < queue_.size() && next < kMostAround; ++next) {
    const std::uint32_t tet = queue_[next];
    if (regions_[tet] == region) return tet;
    for (const FaceCode face : FaceCode::of(tet)) {
      const FaceCode behind = mesh_.behind(face);
      if (behind.valid()) start(behind.tet());
    }
  }
  return kNone;
}

}  // namespace tetloom::adapt
