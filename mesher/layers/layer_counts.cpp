#include "mesher/layers/layer_counts.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/base/grain.hpp"

namespace tetloom::layers {
namespace {

constexpr double kSlope = 0.7;  // of the thickness from curve to curve
constexpr double kRounding = 1e-9;
constexpr double kPoor = 0.4;        // scaled Jacobian
constexpr std::size_t kOneIn = 102;  // cells may be poor, so that one in a hundred is in the end
constexpr int kMostRounds = 12;
constexpr double kMostSkewness = 3.9;  // of faces between cells of one layer; checkMesh complains of 4
constexpr double kMayBeSkewed = 2;     // with rough centres
constexpr double kCalm = 1;            // the same in every fourth layer: no other one is skewed

}  // namespace

LayerCounts::LayerCounts(const Walls& walls, const SideFaces& sides, const GrowthPaths& paths, const TaskRunner& runner,
                         std::span<const KeptCount> kept)
    : walls_(walls),
      feet_(paths.fronts.front()),
      sound_(walls, feet_, runner),
      stretch_(paths.stretch),
      begin_(walls.curve_count() + 1, 0),
      counts_(walls.curve_count(), 0),
      limits_(paths.limits),
      changed_(walls.curve_count(), 1),
      unsettled_(walls.curve_count(), 1),
      unchecked_(walls.curve_count(), 1),
      unmeasured_(walls.curve_count(), 1) {
  for (std::uint32_t c = 0; c < walls.curve_count(); ++c) {
    const LayerHeights& heights = walls.curve_to_heights[c];
    int& count = counts_[c];
    count = count_within(c, paths.reached[c] * stretch_[c]);
    if (count == heights.count) limits_[c] = LayerLimit::None;
    begin_[c + 1] = begin_[c] + static_cast<std::size_t>(count);
  }
  points_.resize(begin_.back());
  runner.for_blocks(walls.curve_count(), kStarGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const auto c = static_cast<std::uint32_t>(i);
      for (int level = 1; level <= counts_[c]; ++level)
        points_[begin_[c] + static_cast<std::size_t>(level) - 1] =
            paths.point_at(c, walls_.curve_to_heights[c].sum(level));
    }
  });
  put_on(sides, runner);
  take(kept);
  even_out_fans();
}

// They are settled among each other.
void LayerCounts::take(std::span<const KeptCount> kept) {
  if (kept.empty()) return;
  for (std::uint32_t c = 0; c < kept.size(); ++c) {
    unchecked_[c] = kept[c].count < 0;
    if (kept[c].count < counts_[c] && kept[c].count >= 0) counts_[c] = kept[c].count, limits_[c] = kept[c].limit;
  }
  unmeasured_ = unchecked_;
  unsettled_ = with_neighbours(unchecked_);
}

// All curves of stacks that have one of them.
std::vector<std::uint8_t> LayerCounts::with_neighbours(const std::vector<std::uint8_t>& curves) const {
  std::vector<std::uint8_t> more = curves;
  for (std::size_t stack = 0; stack < walls_.stack_count(); ++stack) {
    const auto around = walls_.curves_of(stack);
    if (std::ranges::any_of(around, [&](std::uint32_t c) { return curves[c] != 0; }))
      for (const std::uint32_t c : around) more[c] = 1;
  }
  return more;
}

// All curves of one foot have as many layers.
void LayerCounts::even_out_fans() {
  for (const FanVertex& fan : walls_.fan_vertices) {
    const std::uint32_t least = *std::ranges::min_element(fan.curves, {}, [&](std::uint32_t c) { return counts_[c]; });
    for (const std::uint32_t c : fan.curves) lower_one(c, counts_[least], limits_[least]);
  }
}

Vec3 LayerCounts::apex(const FanElement& fan) const {
  constexpr double kHeight = 0.28;  // of the mean diagonal
  std::array<Vec3, 4> x;
  for (std::size_t i = 0; i < 4; ++i) x[i] = top(fan.curves[i]);
  const Vec3 one = x[2] - x[0], other = x[3] - x[1];
  return 0.25 * (x[0] + x[1] + x[2] + x[3]) + kHeight * 0.5 * (norm(one) + norm(other)) * normalized(cross(one, other));
}

void LayerCounts::put_on(const SideFaces& sides, const TaskRunner& runner) {
  constexpr std::size_t kSideGrain = 64;
  runner.for_blocks(sides.curves().size(), kSideGrain, [&](std::size_t begin, std::size_t end) {
    SideProjector projector(sides);
    for (std::size_t i = begin; i < end; ++i) {
      const CurveSides& curve = sides.curves()[i];
      if (curve.is_blocked || counts_[curve.curve] == 0) continue;
      SidePlace place = projector.at_foot(curve);
      for (std::size_t p = begin_[curve.curve]; p < begin_[curve.curve + 1]; ++p) {
        place = projector.put(curve, points_[p], place);
        points_[p] = place.point;
      }
    }
  });
}

double LayerCounts::thickness_of(std::uint32_t curve, int count) const {
  return walls_.curve_to_heights[curve].sum(count) * stretch_[curve];
}

int LayerCounts::count_within(std::uint32_t curve, double thickness) const {
  const LayerHeights& heights = walls_.curve_to_heights[curve];
  const double sum = thickness * (1 + kRounding) / stretch_[curve];
  if (heights.sum(heights.count) <= sum) return heights.count;
  if (!(sum >= heights.first)) return 0;
  const double guess = heights.growth == 1
                           ? sum / heights.first
                           : std::log1p(sum * (heights.growth - 1) / heights.first) / std::log(heights.growth);
  int count = std::clamp(static_cast<int>(guess), 1, heights.count);
  while (count > 0 && heights.sum(count) > sum) --count;
  while (count < heights.count && heights.sum(count + 1) <= sum) ++count;
  return count;
}

void LayerCounts::lower(std::uint32_t curve, int count, LayerLimit limit) {
  const std::uint32_t fan = walls_.curve_to_fan_vertex[curve];
  if (fan == kNone) return lower_one(curve, count, limit);
  for (const std::uint32_t c : walls_.fan_vertices[fan].curves) lower_one(c, count, limit);
}

void LayerCounts::lower_one(std::uint32_t curve, int count, LayerLimit limit) {
  if (count >= counts_[curve]) return;
  counts_[curve] = std::max(count, 0);
  limits_[curve] = limit;
  changed_[curve] = unsettled_[curve] = unchecked_[curve] = unmeasured_[curve] = 1;
}

void LayerCounts::thin(std::uint32_t curve, double thickness, LayerLimit limit) {
  const int left = count_within(curve, thickness_of(curve, counts_[curve]) - thickness);
  lower(curve, std::clamp(left, 1, counts_[curve] - 1), limit);
}

std::vector<std::uint8_t> LayerCounts::take_changes() {
  std::vector<std::uint8_t> changes(changed_.size(), 0);
  changes.swap(changed_);
  return changes;
}

void LayerCounts::settle(const TaskRunner& runner) {
  for (;;) {
    runner.check_cancelled();
    while (limit_slopes(runner)) runner.check_cancelled();
    const bool skewed = lower_at_skewed_faces(runner);
    if (!lower_at_bad_cells(runner) && !skewed) break;
  }
}

// Beside those that have changed since, from the counts as they are, all curves at once. True when one has changed.
bool LayerCounts::limit_slopes(const TaskRunner& runner) {
  const std::vector<std::uint32_t> asked = beside_unsettled();
  std::vector<KeptCount> lowered(asked.size());
  runner.for_blocks(asked.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) lowered[i] = limited_beside_unsettled(asked[i]);
  });
  std::ranges::fill(unsettled_, 0);
  bool any = false;
  for (std::size_t i = 0; i < asked.size(); ++i) {
    any = any || lowered[i].count < counts_[asked[i]];
    lower(asked[i], lowered[i].count, lowered[i].limit);
  }
  return any;
}

std::vector<std::uint32_t> LayerCounts::beside_unsettled() const {
  std::vector<std::uint8_t> is_beside(counts_.size(), 0);
  for (std::uint32_t c = 0; c < counts_.size(); ++c)
    if (unsettled_[c]) walls_.mark_around(c, is_beside);
  std::vector<std::uint32_t> beside;
  for (std::uint32_t c = 0; c < counts_.size(); ++c)
    if (is_beside[c]) beside.push_back(c);
  return beside;
}

KeptCount LayerCounts::limited_beside_unsettled(std::uint32_t curve) const {
  KeptCount lowered{counts_[curve], limits_[curve]};
  for (const std::uint32_t w : walls_.triangles_at(curve))
    for (const std::uint32_t other : walls_.triangles[w].curves) {
      if (other == curve || !unsettled_[other] || lowered.count <= counts_[other] + 1) continue;
      const double most = thickness(other) + kSlope * distance(feet_[curve], feet_[other]);
      if (thickness_of(curve, lowered.count) <= most) continue;
      lowered = {std::max(count_within(curve, most), counts_[other] + 1), limits_[other]};
    }
  return lowered;
}

// Below and above the cells of a layer. Late curves have no first layer beside others.
std::array<int, 2> LayerCounts::levels_at(std::uint32_t curve, int layer) const {
  const int low = std::min(layer - 1, counts_[curve]);
  return {low, layer == 1 && walls_.curve_is_late[curve] ? low : std::min(layer, counts_[curve])};
}

FrontCell LayerCounts::cell_of(std::uint32_t wall, int layer) const {
  FrontCell cell;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::uint32_t curve = walls_.triangles[wall].curves[i];
    const auto [low, high] = levels_at(curve, layer);
    cell.low[i] = point(curve, low), cell.high[i] = point(curve, high);
  }
  return cell;
}

LayerCounts::SharedFace LayerCounts::face_between(const WallEdge& edge, int layer) const {
  SharedFace shared{cell_of(edge.wall, layer), cell_of(edge.other, layer), {}};
  const std::size_t i = edge.corner, k = (i + 1) % 3;
  shared.corners = {shared.cell.low[i], shared.cell.low[k], shared.cell.high[k], shared.cell.high[i]};
  return shared;
}

// 0 where there is no face. Above 2 it is not right.
double LayerCounts::rough_skewness(const SharedFace& face) {
  if (face.corners[0] == face.corners[3] && face.corners[1] == face.corners[2]) return 0;
  return skewness(face.corners, rough_centre_of(face.cell), rough_centre_of(face.other));
}

bool LayerCounts::is_skewed(const SharedFace& face) {
  return rough_skewness(face) > kMayBeSkewed &&
         skewness(face.corners, centre_of(face.cell), centre_of(face.other)) > kMostSkewness;
}

// Below the first face at an edge that is skewed; `most` where none is. Layers of all six curves are much alike from
// one to the next.
int LayerCounts::straight_levels(const WallEdge& edge, int most) const {
  constexpr int kStride = 4;
  int all = most;
  for (const std::uint32_t w : {edge.wall, edge.other})
    for (const std::uint32_t c : walls_.triangles[w].curves) all = std::min(all, counts_[c]);
  bool are_calm = true;
  for (int layer = 1; are_calm && layer <= all; layer = layer < all ? std::min(layer + kStride, all) : all + 1)
    are_calm = rough_skewness(face_between(edge, layer)) <= kCalm;
  for (int layer = are_calm ? all + 1 : 1; layer <= most; ++layer)
    if (is_skewed(face_between(edge, layer))) return layer - 1;
  return most;
}

int LayerCounts::straight_levels(std::uint32_t wall, std::size_t corner) const {
  const auto& curves = walls_.triangles[wall].curves;
  const std::uint32_t next = curves[(corner + 1) % 3];
  int straight = std::max(counts_[curves[corner]], counts_[next]);
  for (const std::uint32_t w : walls_.triangles_at(curves[corner]))
    if (w > wall && std::ranges::count(walls_.triangles[w].curves, next) > 0)
      straight = straight_levels({wall, w, corner}, straight);
  return straight;
}

bool LayerCounts::lower_at_skewed_faces(const TaskRunner& runner) {
  std::vector<int> straight(3 * walls_.triangles.size(), std::numeric_limits<int>::max());
  const std::vector<std::uint8_t> concerned = with_neighbours(unmeasured_);
  runner.for_blocks(walls_.triangles.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
    for (auto w = static_cast<std::uint32_t>(begin); w < end; ++w)
      for (std::size_t i = 0; i < 3; ++i)
        if (concerned[walls_.triangles[w].curves[i]]) straight[3 * w + i] = straight_levels(w, i);
  });
  std::ranges::fill(unmeasured_, 0);
  bool any = lower_at_skewed_fans(concerned);
  for (std::size_t e = 0; e < straight.size(); ++e) {
    const auto& curves = walls_.triangles[e / 3].curves;
    for (const std::uint32_t c : {curves[e % 3], curves[(e % 3 + 1) % 3]}) {
      any = any || counts_[c] > straight[e];
      lower(c, straight[e], LayerLimit::Concave);
    }
  }
  return any;
}

// The same of faces between cells at fans, of which one may have the fan's edge for its wall.
bool LayerCounts::lower_at_skewed_fans(const std::vector<std::uint8_t>& concerned) {
  std::vector<SideOfCell> sides;
  for (std::size_t s = 0; s < walls_.stack_count(); ++s) {
    const auto curves = walls_.curves_of(s);
    if (std::ranges::none_of(curves, [&](std::uint32_t c) { return is_at_fan(c); }) ||
        std::ranges::none_of(curves, [&](std::uint32_t c) { return concerned[c] != 0; }))
      continue;
    for_each_cell_on(
        walls_, s, [&](std::uint32_t c) { return counts_[c]; },
        [&](const auto& cell, int) { add_sides_at_fans(cell, sides); });
  }
  std::vector<std::uint32_t> order(sides.size());
  std::iota(order.begin(), order.end(), 0u);
  std::ranges::sort(order, [&](std::uint32_t a, std::uint32_t b) {
    return sides[a].key != sides[b].key ? sides[a].key < sides[b].key : a < b;
  });
  bool any = false;
  for (std::size_t i = 0; i + 1 < order.size(); ++i) {
    const SideOfCell &side = sides[order[i]], &other = sides[order[i + 1]];
    const int layer = side.key.back().first;
    if (layer == 0 || side.key != other.key || !(skewness(side.corners, side.centre, other.centre) > kMostSkewness))
      continue;
    for (const auto& [level, curve] : side.key) {
      any = any || counts_[curve] >= layer;
      lower(curve, layer - 1, LayerLimit::Fan);
    }
  }
  return any;
}

// One of a fan, or the only one where a fan ends.
bool LayerCounts::is_at_fan(std::uint32_t curve) const {
  return walls_.curve_to_fan_vertex[curve] != kNone || walls_.curve_is_late[curve] != 0;
}

// Those that have a point of a fan, but none at an apex.
template <std::size_t N>
void LayerCounts::add_sides_at_fans(const std::array<CurveLevel, N>& cell, std::vector<SideOfCell>& sides) const {
  if (std::ranges::any_of(cell, &CurveLevel::is_apex)) return;
  std::array<CellSide, 6> corners;
  std::size_t count = 0;
  const std::size_t first = sides.size();
  for (const LocalFace& face : shape_of(kind_of_cell(N)).faces()) {
    const auto verts = face.vertices();
    SideOfCell side;
    for (std::size_t i = 0; i < 4; ++i) {
      const CurveLevel& x = cell[verts[std::min(i, verts.size() - 1)]];
      side.corners[i] = point(x.curve, x.level);
      side.key[i] = {x.level, x.level == 0 ? walls_.first_at_foot(x.curve) : x.curve};
    }
    corners[count++] = side.corners;
    std::ranges::sort(side.key);
    const auto end = std::unique(side.key.begin(), side.key.end());
    std::fill(end, side.key.end(), *(end - 1));
    if (std::ranges::any_of(side.key, [&](const auto& x) { return is_at_fan(x.second); })) sides.push_back(side);
  }
  const Vec3 centre = centre_of(std::span(corners).first(count));
  for (std::size_t i = first; i < sides.size(); ++i) sides[i].centre = centre;
}

bool LayerCounts::lower_at_bad_cells(const TaskRunner& runner) {
  std::vector<int> sound(walls_.stack_count(), std::numeric_limits<int>::max());
  const auto is_concerned = [&](std::uint32_t stack) {
    return std::ranges::any_of(walls_.curves_of(stack), [&](std::uint32_t c) { return unchecked_[c] != 0; });
  };
  runner.for_blocks(sound.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
    for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s)
      if (is_concerned(s)) sound[s] = sound_levels(s, SoundStacks::kLeastAbove);
  });
  std::ranges::fill(unchecked_, 0);
  return lower_to(sound);
}

int LayerCounts::sound_levels(std::uint32_t stack, double least) const {
  return sound_.levels(
      stack, [&](std::uint32_t curve) { return counts_[curve]; },
      [&](std::uint32_t curve, int level) { return curve == kNone ? apex(walls_.fan(stack)) : point(curve, level); },
      least);
}

bool LayerCounts::lower_to(std::span<const int> levels) {
  bool any = false;
  for (std::size_t s = 0; s < levels.size(); ++s)
    for (const std::uint32_t c : walls_.curves_of(s)) {
      any = any || counts_[c] > levels[s];
      lower(c, levels[s], LayerLimit::Cell);
    }
  return any;
}

LayerCounts::StackShape LayerCounts::judge_shape(std::uint32_t stack) const {
  const auto count_of = [&](std::uint32_t curve) { return counts_[curve]; };
  StackShape shape;
  double first = 1;  // scaled Jacobian of the first layer
  for_each_cell_on(walls_, stack, count_of, [&](const auto& cell, int layer) {
    std::array<Vec3, std::tuple_size_v<std::decay_t<decltype(cell)>>> x;
    for (std::size_t i = 0; i < x.size(); ++i)
      x[i] = cell[i].is_apex() ? apex(walls_.fan(stack)) : point(cell[i].curve, cell[i].level);
    ++shape.cells;
    const double jacobian = scaled_jacobian(x);
    if (layer == 1) first = std::min(first, jacobian);
    if (jacobian >= kPoor) return;
    shape.least = std::min(shape.least, static_cast<float>(jacobian));
    if (sound_.may_be_flat(stack, layer, x.size()) || jacobian >= SoundStacks::least_above(kPoor, first)) {
      ++shape.fixed;
    } else {
      shape.above.push_back(static_cast<float>(jacobian));
    }
  });
  return shape;
}

// From round to round there are new steps between counts beside those that were lowered, and other poor cells there.
void LayerCounts::mend_shapes(const TaskRunner& runner) {
  constexpr double kSingle = 1 + 1e-6;  // rounding of scaled Jacobians in single precision
  std::vector<StackShape> shapes(walls_.stack_count());
  std::vector<int> judged;  // counts at which they were
  const auto for_each_stack = [&](const auto& body) {
    runner.for_blocks(shapes.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (auto s = static_cast<std::uint32_t>(begin); s < end; ++s) body(s);
    });
  };
  for (int round = 0; round < kMostRounds; ++round) {
    for_each_stack([&](std::uint32_t s) {
      const auto has_changed = [&](std::uint32_t c) { return judged[c] != counts_[c]; };
      if (judged.empty() || std::ranges::any_of(walls_.curves_of(s), has_changed)) shapes[s] = judge_shape(s);
    });
    judged = counts_;
    std::size_t all = 0, fixed = 0;
    std::vector<float> above;
    for (const StackShape& shape : shapes) {
      all += shape.cells, fixed += shape.fixed;
      above.insert(above.end(), shape.above.begin(), shape.above.end());
    }
    const std::size_t most = all / kOneIn;
    if (fixed > most || fixed + above.size() <= most) return;
    const std::size_t left = most - fixed;  // of those above that may stay as they are
    const auto last = above.end() - static_cast<std::ptrdiff_t>(left) - 1;
    std::ranges::nth_element(above, last);
    const double least = std::min(kPoor, *last * kSingle);
    std::vector<int> sound(shapes.size(), std::numeric_limits<int>::max());
    for_each_stack([&](std::uint32_t s) {
      if (shapes[s].least < least * kSingle) sound[s] = sound_levels(s, least);
    });
    if (!lower_to(sound)) return;
    settle(runner);
  }
}

}  // namespace tetloom::layers
