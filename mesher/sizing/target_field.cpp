#include "mesher/sizing/target_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetloom {
namespace {

constexpr double kHalfDiagonal = 0.8660254037844386;      // of the unit cube
constexpr double kWidthAtSource = 0.8, kWidthAway = 1.1;  // of leaves, in sizes

}  // namespace

double TargetField::finest_width() const { return kWidthAtSource * std::min(sources_.smallest(), targets_.global); }

double TargetField::region_size(const Vec3& x) const {
  const ModelRegionId region = facets_->region_at(x);
  return region.valid() ? targets_.region[region.value] : HUGE_VAL;
}

double TargetField::callback_size(const Vec3& x) const {
  const double wish = callback_(x);
  return std::isfinite(wish) && wish > 0 ? std::min(wish, targets_.global) : targets_.global;
}

double TargetField::size_at(const Vec3& x, std::uint32_t& winner) const {
  double size = sources_.size_at(x, targets_.global, winner);
  if (facets_ != nullptr && size > targets_.smallest_region) size = std::min(size, region_size(x));
  if (callback_) size = std::min(size, callback_size(x));
  return size;
}

double TargetField::lower_bound(const Vec3& center, double radius, std::uint32_t& winner) const {
  const double cap = targets_.global + targets_.gradation * radius;
  const double bound = sources_.size_at(center, cap, winner) - targets_.gradation * radius;
  return std::max(bound, std::min(sources_.smallest(), targets_.global));
}

CellVerdict TargetField::classify(const Vec3& center, double width, std::uint32_t& winner) const {
  bool below_global = false;
  if (callback_ && callback_needs_split(center, width, below_global)) return CellVerdict::Split;
  const CellVerdict constant = callback_ ? CellVerdict::Leaf : CellVerdict::Global;
  if (sources_.empty()) return below_global ? CellVerdict::Leaf : constant;

  const double radius = kHalfDiagonal * width;
  const double drop = targets_.gradation * radius;
  const double at_center = sources_.size_at(center, targets_.global + drop, winner);
  const double bound = at_center - drop;
  if (bound >= targets_.global) return constant;
  // The sources bound every region that has a size: a cell that stays above the size of its region lies inside it.
  if (facets_ != nullptr && bound >= targets_.smallest_region && bound >= region_size(center)) return CellVerdict::Leaf;
  const double source = winner == SourceTree::kNoSource ? targets_.global : sources_.source_size(winner);
  const bool touches_source = at_center < source + drop;
  const double least = std::max(bound, std::min(sources_.smallest(), targets_.global));
  return width <= (touches_source ? kWidthAtSource : kWidthAway) * least ? CellVerdict::Leaf : CellVerdict::Split;
}

/// Compares the callback on a 3 x 3 x 3 grid with its trilinear interpolation from the cell's corners.
bool TargetField::callback_needs_split(const Vec3& center, double width, bool& below_global) const {
  constexpr double kTolerance = 0.05, kWidthToSize = 0.5;
  std::array<double, 27> values;
  double smallest = HUGE_VAL;
  for (int i = 0; i < 27; ++i) {
    const Vec3 offset{double(i % 3 - 1), double(i / 3 % 3 - 1), double(i / 9 - 1)};
    values[static_cast<std::size_t>(i)] = callback_size(center + (0.5 * width) * offset);
    smallest = std::min(smallest, values[static_cast<std::size_t>(i)]);
  }
  below_global = smallest < targets_.global;
  if (!below_global || width <= kWidthToSize * smallest) return false;
  const auto corner = [&](int x, int y, int z) { return values[static_cast<std::size_t>(2 * x + 6 * y + 18 * z)]; };
  for (int i = 0; i < 27; ++i) {
    const double x = i % 3 * 0.5, y = i / 3 % 3 * 0.5, z = i / 9 * 0.5;
    const double lower = (1 - y) * ((1 - x) * corner(0, 0, 0) + x * corner(1, 0, 0)) +
                         y * ((1 - x) * corner(0, 1, 0) + x * corner(1, 1, 0));
    const double upper = (1 - y) * ((1 - x) * corner(0, 0, 1) + x * corner(1, 0, 1)) +
                         y * ((1 - x) * corner(0, 1, 1) + x * corner(1, 1, 1));
    const double value = values[static_cast<std::size_t>(i)];
    if (std::abs((1 - z) * lower + z * upper - value) > kTolerance * value) return true;
  }
  return false;
}

}  // namespace tetloom
