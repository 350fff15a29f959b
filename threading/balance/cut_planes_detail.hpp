#pragma once
// Along which plane each set of items is cut.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "threading/balance/bisection_detail.hpp"
#include "threading/balance/items_detail.hpp"

namespace tetloom::balance_detail {

/// The normal of a plane, in whole numbers from -1 to 1.
using Normal = std::array<std::int64_t, 3>;

constexpr std::uint64_t kHighestHeight = (std::uint64_t{1} << (Frame::kPlaceBits + 3)) - 1;

/// Where a place lies along a normal; never negative.
inline std::uint64_t height(const Normal& n, const std::array<std::int64_t, 3>& place) {
  constexpr std::int64_t lift = std::int64_t{1} << (Frame::kPlaceBits + 2);
  return static_cast<std::uint64_t>(n[0] * place[0] + n[1] * place[1] + n[2] * place[2] + lift);
}

/// Compares planes on a sample of the items. Whether an item is in the sample depends on its place alone. Where there
/// are too many sets for that, sets are cut across the longest side of what is known of their boxes.
class PlaneChooser {
 public:
  PlaneChooser(const Items& items, TargetRange range, CutPlanes planes);

  /// A normal for each set, and the interval in which the cut is expected (not promised).
  std::vector<Normal> choose(std::span<ItemSet> sets);
  /// Follows the cuts.
  void split(std::span<const ItemSet> sets, std::span<const Normal> normals);

 private:
  struct Sample {
    std::array<std::int32_t, 3> place;
    std::uint32_t weight;
    std::uint32_t label;
  };
  /// The set's box along each axis, as far as it is known.
  using Box = std::array<std::array<std::uint64_t, 2>, 3>;

  void draw(const Items& items);
  void measure_costs(const Items& items, std::uint64_t mask);
  std::vector<std::array<std::uint64_t, 2>> find_ranges(std::span<const ItemSet> sets) const;
  std::vector<std::int64_t> count_bins(std::span<const ItemSet> sets,
                                       std::span<const std::array<std::uint64_t, 2>> ranges) const;
  Normal choose_by_sample(ItemSet& set, std::span<const std::array<std::uint64_t, 2>> ranges,
                          std::span<const std::int64_t> bins) const;
  Normal choose_by_box(ItemSet& set, const Box& box) const;
  void number(std::span<const ItemSet> sets);

  const Items& items_;
  TargetRange range_;
  std::span<const Normal> normals_;
  std::vector<double> costs_;                 // by normal: faces cut per area and density
  std::vector<std::vector<Sample>> samples_;  // by chunk of work
  std::vector<std::uint32_t> set_of_;         // by label - range_.first
  std::vector<Box> boxes_;                    // by label - range_.first
};

}  // namespace tetloom::balance_detail
