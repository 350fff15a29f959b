#include "mesher/sizing/target_field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tetloom {
namespace {

constexpr double kHalfDiagonal = 0.8660254037844386;      // of the unit cube
constexpr double kWidthAtSource = 1.1, kWidthAway = 1.5;  // of leaves, in sizes, at a gradation of up to 0.3

/// The error of the interpolation grows with the gradation, more than in proportion, and with the square of the width.
double width_scale(double gradation) { return gradation > 0.3 ? std::pow(0.3 / gradation, 0.65) : 1; }

}  // namespace

TargetField::TargetField(const SizeTargets& targets, const FieldSources& sources, const FacetTree& facets,
                         const std::function<double(const Vec3&)>& callback)
    : targets_(targets),
      sources_(sources),
      facets_(facets),
      callback_(callback),
      width_at_source_(kWidthAtSource * width_scale(targets.gradation)),
      width_away_(kWidthAway * width_scale(targets.gradation)) {}

double TargetField::region_size(const Vec3& x) const {
  const ModelRegionId region = facets_.region_at(x);
  return region.valid() ? targets_.region[region.value] : HUGE_VAL;
}

double TargetField::callback_size(const Vec3& x) const {
  const double wish = callback_(x);
  return std::isfinite(wish) && wish > 0 ? std::min(wish, targets_.global) : targets_.global;
}

double TargetField::size_at(const Vec3& x, std::uint32_t& winner) const {
  double size = sources_.model.size_at(x, targets_.global, winner);
  std::uint32_t unknown = SourceTree::kNoSource;
  size = sources_.refinements.size_at(x, size, unknown);
  if (size > targets_.smallest_region) size = std::min(size, region_size(x));
  if (callback_) size = std::min(size, callback_size(x));
  return size;
}

double TargetField::lowered_at(const Vec3& x, double before) const {
  std::uint32_t unknown = SourceTree::kNoSource;
  return sources_.latest.size_at(x, before, unknown);
}

double TargetField::lower_bound(const Vec3& center, double radius, std::uint32_t& winner) const {
  const double least = sources_.model.least_within(center, radius, targets_.global, winner);
  std::uint32_t unknown = SourceTree::kNoSource;
  return sources_.refinements.least_within(center, radius, least, unknown);
}

CellVerdict TargetField::classify(const Vec3& center, double width, const JudgedCell* before, CellState& state) const {
  // What holds in the parent holds here.
  const bool fine = width <= width_at_source_ * state.least;
  if (fine) {
    state.is_own = false;
  } else {
    const bool known = before != nullptr && before->state.is_own;
    find_least(center, kHalfDiagonal * width, known ? &before->state : nullptr, state);
    if (known && state.least == before->state.least) {
      state = before->state;
      return before->verdict;
    }
  }
  CellVerdict verdict = fine ? CellVerdict::Leaf : judge_by_sources(width, state);
  if (callback_) verdict = std::max(verdict, judge_by_callback(center, width));
  return verdict == CellVerdict::Split ? judge_by_surface(center, width, state) : verdict;
}

/// `before`: with a least size of its own.
void TargetField::find_least(const Vec3& center, double radius, const CellState* before, CellState& state) const {
  const auto lower_by = [&](const SourceTree& sources, std::uint32_t& winner) {
    const double least = sources.least_within(center, radius, state.least, winner);
    if (winner == SourceTree::kNoSource) return;
    state.least = least;
    state.on_source = least == sources.source_size(winner);
  };
  std::uint32_t unknown = SourceTree::kNoSource;
  if (before != nullptr) {
    state = *before;
    return lower_by(sources_.latest, unknown);
  }
  state.is_own = true;
  state.on_source = false;
  state.least = targets_.global;
  lower_by(sources_.model, state.winner);
  lower_by(sources_.refinements, unknown);
}

CellVerdict TargetField::judge_by_sources(double width, const CellState& state) const {
  if (state.least >= targets_.global) return CellVerdict::Global;
  return width <= (state.on_source ? width_at_source_ : width_away_) * state.least ? CellVerdict::Leaf
                                                                                   : CellVerdict::Split;
}

/// Of a cell that is too wide for the sizes in it.
CellVerdict TargetField::judge_by_surface(const Vec3& center, double width, CellState& state) const {
  constexpr double kMargin = 0.5;  // in sizes: vertices lie a little beside the facets
  if (state.region == CellState::kNearSurface) {
    const double size = std::min(state.least + targets_.gradation * kHalfDiagonal * width, targets_.global);
    const double half = 0.5 * width + kMargin * size;
    if (!facets_.is_complete() || facets_.any_in(center, half)) return CellVerdict::Split;
    const ModelRegionId region = facets_.region_at(center);
    if (!region.valid()) return CellVerdict::Leaf;
    state.region = region.value;
  }
  // Inside of a region with a size of its own, larger sizes do not matter.
  const bool overruled = state.least >= targets_.region[state.region];
  return overruled && !callback_ ? CellVerdict::Leaf : CellVerdict::Split;
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
