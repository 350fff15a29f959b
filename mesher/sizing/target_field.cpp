#include "mesher/sizing/target_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetloom {
namespace {

constexpr double kHalfDiagonal = 0.8660254037844386;      // of the unit cube
constexpr double kWidthAtSource = 1.1, kWidthAway = 1.5;  // of leaves, in sizes, at a gradation of up to 0.3

/// The error of the interpolation grows with the gradation and with the square of the width.
double width_scale(double gradation) { return gradation > 0.3 ? std::sqrt(0.3 / gradation) : 1; }

}  // namespace

TargetField::TargetField(const SizeTargets& targets, const SourceTree& sources, const FacetTree& facets,
                         const std::function<double(const Vec3&)>& callback)
    : targets_(targets),
      sources_(sources),
      facets_(facets),
      callback_(callback),
      width_at_source_(kWidthAtSource * width_scale(targets.gradation)),
      width_away_(kWidthAway * width_scale(targets.gradation)) {}

double TargetField::finest_width() const { return width_at_source_ * std::min(sources_.smallest(), targets_.global); }

double TargetField::region_size(const Vec3& x) const {
  const ModelRegionId region = facets_.region_at(x);
  return region.valid() ? targets_.region[region.value] : HUGE_VAL;
}

double TargetField::callback_size(const Vec3& x) const {
  const double wish = callback_(x);
  return std::isfinite(wish) && wish > 0 ? std::min(wish, targets_.global) : targets_.global;
}

double TargetField::size_at(const Vec3& x, std::uint32_t& winner) const {
  double size = sources_.size_at(x, targets_.global, winner);
  if (size > targets_.smallest_region) size = std::min(size, region_size(x));
  if (callback_) size = std::min(size, callback_size(x));
  return size;
}

double TargetField::lower_bound(const Vec3& center, double radius, std::uint32_t& winner) const {
  const double cap = targets_.global + targets_.gradation * radius;
  const double bound = sources_.size_at(center, cap, winner) - targets_.gradation * radius;
  return std::max(bound, std::min(sources_.smallest(), targets_.global));
}

CellVerdict TargetField::classify(const Vec3& center, double width, CellState& state) const {
  CellVerdict verdict = judge_by_sources(center, width, state);
  if (callback_) verdict = std::max(verdict, judge_by_callback(center, width));
  if (verdict != CellVerdict::Split) return verdict;
  const double radius = kHalfDiagonal * width;
  if (state.region == CellState::kNearSurface) {
    const double margin = std::min(state.at_center, targets_.global);
    if (!facets_.is_complete() || facets_.any_within(center, radius + margin)) return CellVerdict::Split;
    const ModelRegionId region = facets_.region_at(center);
    if (!region.valid()) return CellVerdict::Leaf;
    state.region = region.value;
  }
  // Inside of a region with a size of its own, larger sizes do not matter.
  const bool overruled = state.at_center - targets_.gradation * radius >= targets_.region[state.region];
  return overruled && !callback_ ? CellVerdict::Leaf : CellVerdict::Split;
}

CellVerdict TargetField::judge_by_sources(const Vec3& center, double width, CellState& state) const {
  if (sources_.empty()) {
    state.at_center = targets_.global;
    return CellVerdict::Global;
  }
  // From the parent's centre to this one, and from there to a corner, it is half a diagonal each.
  const double drop = targets_.gradation * kHalfDiagonal * width;
  if (width <= width_at_source_ * (state.at_center - 2 * drop)) {
    state.at_center -= drop;
    return CellVerdict::Leaf;
  }
  state.at_center = sources_.size_at(center, targets_.global + drop, state.winner);
  const double bound = state.at_center - drop;
  if (bound >= targets_.global) return CellVerdict::Global;
  const double source = state.winner == SourceTree::kNoSource ? targets_.global : sources_.source_size(state.winner);
  const bool touches_source = state.at_center < source + drop;
  const double least = std::max(bound, std::min(sources_.smallest(), targets_.global));
  return width <= (touches_source ? width_at_source_ : width_away_) * least ? CellVerdict::Leaf : CellVerdict::Split;
}

/// Compares the callback on a 3 x 3 x 3 grid with its trilinear interpolation from the cell's corners. No cell is
/// global: gradation may carry a small size from the neighbours into it.
CellVerdict TargetField::judge_by_callback(const Vec3& center, double width) const {
  constexpr double kTolerance = 0.05, kWidthToSize = 0.5;
  std::array<double, 27> values;
  double smallest = HUGE_VAL;
  for (int i = 0; i < 27; ++i) {
    const Vec3 offset{double(i % 3 - 1), double(i / 3 % 3 - 1), double(i / 9 - 1)};
    values[static_cast<std::size_t>(i)] = callback_size(center + (0.5 * width) * offset);
    smallest = std::min(smallest, values[static_cast<std::size_t>(i)]);
  }
  if (smallest >= targets_.global || width <= kWidthToSize * smallest) return CellVerdict::Leaf;
  const auto corner = [&](int x, int y, int z) { return values[static_cast<std::size_t>(2 * x + 6 * y + 18 * z)]; };
  for (int i = 0; i < 27; ++i) {
    const double x = i % 3 * 0.5, y = i / 3 % 3 * 0.5, z = i / 9 * 0.5;
    const double lower = (1 - y) * ((1 - x) * corner(0, 0, 0) + x * corner(1, 0, 0)) +
                         y * ((1 - x) * corner(0, 1, 0) + x * corner(1, 1, 0));
    const double upper = (1 - y) * ((1 - x) * corner(0, 0, 1) + x * corner(1, 0, 1)) +
                         y * ((1 - x) * corner(0, 1, 1) + x * corner(1, 1, 1));
    const double value = values[static_cast<std::size_t>(i)];
    if (std::abs((1 - z) * lower + z * upper - value) > kTolerance * value) return CellVerdict::Split;
  }
  return CellVerdict::Leaf;
}

}  // namespace tetloom
