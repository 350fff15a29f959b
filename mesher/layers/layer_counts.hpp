#pragma once
// How many layers each growth curve has.
#include <array>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "mesher/layers/face_skewness.hpp"
#include "mesher/layers/growth_paths.hpp"
#include "mesher/layers/sound_stacks.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// What a curve had in the end when it was grown before.
struct KeptCount {
  int count = -1;  ///< negative: it is grown anew
  LayerLimit limit = LayerLimit::None;
};

/// The points of all layers that fit on the paths, and how many of them are used. Counts only fall: the first layers
/// keep their heights.
class LayerCounts {
 public:
  /// All layers that fit on the paths, but no more than are kept, per curve where any are. Refers to `walls`. Errors:
  /// Cancelled.
  LayerCounts(const Walls& walls, const SideFaces& sides, const GrowthPaths& paths, const TaskRunner& runner,
              std::span<const KeptCount> kept = {});

  int count(std::uint32_t curve) const { return counts_[curve]; }
  LayerLimit limit(std::uint32_t curve) const { return limits_[curve]; }
  /// `level` from 0, the foot, to count.
  Vec3 point(std::uint32_t curve, int level) const {
    return level == 0 ? feet_[curve] : points_[begin_[curve] + static_cast<std::size_t>(level) - 1];
  }
  Vec3 top(std::uint32_t curve) const { return point(curve, counts_[curve]); }
  /// The apex of a stack on an element of a fan that has four tops.
  Vec3 apex(const FanElement& fan) const;
  /// Of all layers, along the curve.
  double thickness(std::uint32_t curve) const { return thickness_of(curve, counts_[curve]); }

  /// Leaves at most so many, on all curves of the foot.
  void lower(std::uint32_t curve, int count, LayerLimit limit);
  /// Leaves so much less of the thickness, one layer at least. Pre: it has more than one.
  void thin(std::uint32_t curve, double thickness, LayerLimit limit);
  /// Lowers counts until the thickness varies from curve to curve by no more than .7 of what lies between them, or one
  /// layer, and all cells are sound (SoundStacks). Errors: Cancelled.
  void settle(const TaskRunner& runner);
  /// Lowers counts, the poorest cells first, until no more than one in a hundred has a scaled Jacobian below .4; leaves
  /// them where first layers, and what they allow above them, are poorer than that. Pre: settled; they are again.
  /// Errors: Cancelled.
  void mend_shapes(const TaskRunner& runner);
  /// Curves whose count has changed since the last call, or ever.
  std::vector<std::uint8_t> take_changes();

 private:
  // Of the cells of a stack.
  struct StackShape {
    std::uint32_t cells = 0, fixed = 0;  // all; poor ones that may be flat, or are as good as their first layer allows
    float least = 1;                     // scaled Jacobian of all poor ones
    std::vector<float> above;            // those of the poor ones that are not fixed
  };

  // Of a cell at a fan. Its key are level and curve of the corners, ascending; a triangle has the last one twice.
  struct SideOfCell {
    std::array<std::pair<int, std::uint32_t>, 4> key;
    CellSide corners;
    Vec3 centre;  // of the cell
  };

  // The edge of a wall triangle from a corner on, which another one shares.
  struct WallEdge {
    std::uint32_t wall = 0, other = 0;
    std::size_t corner = 0;  // of `wall`
  };
  // Between two cells of a layer.
  struct SharedFace {
    FrontCell cell, other;
    CellSide corners;
  };

  void take(std::span<const KeptCount> kept);
  void even_out_fans();
  void put_on(const SideFaces& sides, const TaskRunner& runner);
  void lower_one(std::uint32_t curve, int count, LayerLimit limit);
  double thickness_of(std::uint32_t curve, int count) const;
  int count_within(std::uint32_t curve, double thickness) const;
  std::vector<std::uint8_t> with_neighbours(const std::vector<std::uint8_t>& curves) const;
  bool limit_slopes(const TaskRunner& runner);
  std::vector<std::uint32_t> beside_unsettled() const;
  KeptCount limited_beside_unsettled(std::uint32_t curve) const;
  bool lower_at_bad_cells(const TaskRunner& runner);
  int sound_levels(std::uint32_t stack, double least) const;
  bool lower_to(std::span<const int> levels);
  StackShape judge_shape(std::uint32_t stack) const;
  bool lower_at_skewed_faces(const TaskRunner& runner);
  std::array<int, 2> levels_at(std::uint32_t curve, int layer) const;
  bool is_at_fan(std::uint32_t curve) const;
  bool lower_at_skewed_fans(const std::vector<std::uint8_t>& concerned);
  template <std::size_t N>
  void add_sides_at_fans(const std::array<CurveLevel, N>& cell, std::vector<SideOfCell>& sides) const;
  FrontCell cell_of(std::uint32_t wall, int layer) const;
  SharedFace face_between(const WallEdge& edge, int layer) const;
  static double rough_skewness(const SharedFace& face);
  static bool is_skewed(const SharedFace& face);
  int straight_levels(const WallEdge& edge, int most) const;
  int straight_levels(std::uint32_t wall, std::size_t corner) const;

  const Walls& walls_;
  std::vector<Vec3> feet_;
  SoundStacks sound_;
  std::vector<double> stretch_;
  std::vector<std::size_t> begin_;
  std::vector<Vec3> points_;
  std::vector<int> counts_;
  std::vector<LayerLimit> limits_;
  std::vector<std::uint8_t> changed_, unsettled_;  // unsettled: slopes beside it were not limited since
  // Neither cells nor faces between them have been judged since the count was lowered.
  std::vector<std::uint8_t> unchecked_, unmeasured_;
};

}  // namespace tetloom::layers
