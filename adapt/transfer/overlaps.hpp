#pragma once
// Which tets of the mesh as it was a new tet overlaps, and by how much.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "adapt/transfer/clip_tet.hpp"
#include "adapt/transfer/old_tets.hpp"

namespace tetloom::adapt {

/// What an old tet has in common with a new one.
struct Overlap {
  BackgroundTet tet = kNoTet;
  double share = 0;                ///< of the volume of the new tet
  std::array<double, 4> moment{};  ///< see ClippedTet
};

/// A set of numbers that is emptied at no cost. Its order is never looked at.
class NumberSet {
 public:
  void clear();
  /// Whether it was not there yet.
  bool insert(std::uint64_t number);

 private:
  void grow();
  std::size_t slot_of(std::uint64_t number) const;
  bool is_free(std::size_t slot) const { return slots_[slot].round != round_; }

  struct Slot {
    std::uint64_t number = 0, round = 0;
  };
  std::vector<Slot> slots_ = std::vector<Slot>(64);
  std::uint64_t round_ = 1;
  std::size_t count_ = 0;
};

/// Finds overlaps, for one task at a time. What it finds does not depend on what it found before.
///
/// It starts in the tet that holds the new one's centre, and goes on through the faces that the new tet crosses
/// (Farrell & Maddison 2011). Where that does not fill the new tet, because of round-off or because it lies partly
/// outside of the mesh or of its region as they were, all tets are looked at that touch it, of any region, from its
/// corners as well.
class OverlapFinder {
 public:
  /// `from` is used while the finder lives.
  explicit OverlapFinder(const OldTets& from) : from_(from) {}

  /// Overlaps of the tet `verts` of `to` with tets of the region `region`. `hints`: a place near each corner. The
  /// result is valid until the next call. Where the mesh lies in tiles, MissingTile may be thrown.
  std::span<const Overlap> find(const TetView& to, const TetVerts& verts, std::uint32_t region,
                                const std::array<BackgroundTet, 4>& hints);
  /// The sum of the shares of what was found last, 1 but for round-off where the new tet lies in its region as it was.
  double covered() const { return covered_; }
  /// A tet of that region which is the fewest faces away from what the last one holds its centre in, kNoTet where there
  /// is none within thousands of tets.
  BackgroundTet nearest(std::uint32_t region);

 private:
  void spread(const TetView& to, const TetVerts& verts, const Corners& corners, std::uint32_t region, bool touching);
  bool touches(const FaceValues& values, const TetView& to, const TetVerts& verts, const Corners& corners) const;
  void start(BackgroundTet tet);

  const OldTets& from_;
  std::vector<Overlap> overlaps_;
  std::vector<BackgroundTet> queue_;
  NumberSet seen_;
  BackgroundTet center_ = kNoTet;
  double covered_ = 0;
};

}  // namespace tetloom::adapt
