#include "mesher/features/eliminate_in_zone.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <queue>
#include <utility>

#include "core/base/lists.hpp"
#include "core/spatial/distances.hpp"
#include "core/spatial/triangle_shape.hpp"
#include "mesher/features/displacement.hpp"
#include "mesher/features/local_change.hpp"
#include "mesher/features/shape_check.hpp"

namespace tetloom::features {
namespace {

// Least height of new triangles as a share of the least one before: a collapse may leave a flatter one, which a snap
// then takes; each snap has to gain.
constexpr double kCollapseHeight = 0.5, kSnapHeight = 1.01;
// Least mean ratio of triangles after a swap for the sake of their shape, as a share of the least one before.
constexpr double kSwapShape = 1.001;
// Edges beside merged vertices that are shorter than this share of the size are collapsed as well.
constexpr double kShort = 0.5;
// The distance, in sizes, by which that may move the surface beside what the tolerance allows: a half of the sagitta
// of an arc of 24 edges per turn.
constexpr double kSmoothing = 0.016;
// An edge is swapped beside merged vertices where its triangles' normals differ by at most this.
constexpr double kFlatCosine = 0.94;

struct Task {
  double urgency;  // a length over the one that is wanted
  std::uint32_t triangle;
  bool operator<(const Task& other) const {  // std::priority_queue takes the largest
    return urgency != other.urgency ? urgency > other.urgency : triangle > other.triangle;
  }
};

class Eliminator {
 public:
  Eliminator(const Zone& zone, std::span<const FaceSides> sides, const TaskRunner& runner)
      : zone_(zone),
        runner_(runner),
        surface_(zone.items, sides),
        displacement_(zone.items.points),
        is_touched_(zone.items.points.size(), 0),
        merged_into_(zone.items.points.size(), kNone) {}

  ZoneChange run() {
    for (const std::uint32_t t : zone_.small) push(t);
    // Every merge takes a point; swaps are bounded by their gain, and by this where rounding decides.
    std::size_t budget = 50 * zone_.small.size() + 1000;
    for (; !tasks_.empty() && budget > 0; --budget) {
      const Task task = tasks_.top();
      tasks_.pop();
      is_queued_[task.triangle] = false;
      if (budget % 256 == 0) runner_.check_cancelled();
      if (surface_.is_alive(task.triangle)) better(task.triangle);
    }
    return finish();
  }

 private:
  double tolerance_of(const Triangle& t) const {
    return (zone_.tolerances[t[0]] + zone_.tolerances[t[1]] + zone_.tolerances[t[2]]) / 3;
  }
  double length(std::uint32_t a, std::uint32_t b) const { return distance(surface_.point(a), surface_.point(b)); }
  double size_of_edge(std::uint32_t a, std::uint32_t b) const { return 0.5 * (zone_.sizes[a] + zone_.sizes[b]); }
  bool any_touched(const Triangle& t) const {
    return std::ranges::any_of(t, [&](std::uint32_t v) { return is_touched_[v] != 0; });
  }

  // A triangle that waits already is not put in twice: its urgency never changes, so both would be taken at once.
  void push(std::uint32_t t) {
    is_queued_.resize(surface_.triangle_count(), false);
    if (is_queued_[t]) return;
    const Triangle& verts = surface_.triangle(t);
    const auto [a, b, c] = corners(surface_, t);
    const double height = least_height(a, b, c) / tolerance_of(verts);
    const bool is_small = height < 1;
    if (!is_small && !any_touched(verts)) return;
    // Beside merged vertices shapes matter too, after all that is small.
    tasks_.push({is_small ? height : 1 + triangle_mean_ratio(a, b, c), t});
    is_queued_[t] = true;
  }

  // Edges of a triangle, as the corner opposite to them, the shortest first.
  std::array<std::size_t, 3> by_length(const Triangle& verts) const {
    const std::array<double, 3> lengths{length(verts[1], verts[2]), length(verts[2], verts[0]),
                                        length(verts[0], verts[1])};
    std::array<std::size_t, 3> order{0, 1, 2};
    std::ranges::sort(order, {}, [&](std::size_t i) { return std::pair(lengths[i], i); });
    return order;
  }

  void better(std::uint32_t t) {
    const Triangle verts = surface_.triangle(t);
    const std::array<std::size_t, 3> order = by_length(verts);
    for (const std::size_t i : order)
      if (collapse(verts[(i + 1) % 3], verts[(i + 2) % 3])) return;
    snap(t, order[2]);
  }

  bool collapse(std::uint32_t a, std::uint32_t b) {
    const double edge = length(a, b), tolerance = 0.5 * (zone_.tolerances[a] + zone_.tolerances[b]);
    const bool is_feature = edge < tolerance;
    if (!is_feature && !(edge < kShort * size_of_edge(a, b) && (is_touched_[a] || is_touched_[b]))) return false;
    std::optional<LocalChange> best;
    Motion best_motion;
    double best_shape = 0;
    for (const auto& [gone, kept] : {std::pair{a, b}, std::pair{b, a}}) {
      if (zone_.is_locked[gone] || zone_.is_locked[kept]) continue;
      std::optional<LocalChange> change = plan_collapse(surface_, gone, kept);
      if (!change) continue;
      const std::optional<Motion> motion = allowed_motion(*change, tolerance);
      if (!motion) continue;
      const BeforeAfter shapes = compare_shapes(surface_, *change), heights = compare_heights(surface_, *change);
      const bool gains = is_feature ? heights.after > kCollapseHeight * heights.before : shapes.after > shapes.before;
      if (!gains || (best && shapes.after <= best_shape) || !keeps_shape(surface_, *change, tolerance)) continue;
      best_shape = shapes.after;
      best_motion = *motion;
      best = std::move(change);
    }
    if (!best) return false;
    if (best_motion.is_direct)
      displacement_.merge(best->gone, best->kept, best->place);
    else
      displacement_.note(best->kept, best_motion.distance);
    is_touched_[best->kept] = 1;
    merged_into_[best->gone] = best->kept;
    ++collapses_;
    make(*best);
    return true;
  }

  struct Motion {
    double distance = 0;     ///< of the surface from the given one
    bool is_direct = false;  ///< all of the vertex that goes is now at the one that stays
  };

  // How far the surface will be from the given one; none where that is too far.
  std::optional<Motion> allowed_motion(const LocalChange& change, double tolerance) const {
    const double direct = displacement_.from(change.gone, change.place);
    if (direct <= tolerance) return Motion{direct, true};
    const double before = displacement_.from(change.gone, surface_.point(change.gone));
    const std::optional<double> beside = distance_beside(change);
    const double most = std::max(tolerance, kSmoothing * size_of_edge(change.gone, change.kept));
    if (!beside || before + *beside > most) return {};
    return Motion{before + *beside, false};
  }

  // The distance of a vertex from the surface without it, where it lies inside of a face, or inside of a model edge
  // along which it is merged; none elsewhere.
  std::optional<double> distance_beside(const LocalChange& change) const {
    const Vec3& x = surface_.point(change.gone);
    const ModelEntity entity = surface_.entity(change.gone);
    double nearest = HUGE_VAL;
    for (const AddedTriangle& added : change.added) {
      const auto [a, b, c] = corners(surface_, change, added.verts);
      nearest = std::min(nearest, distance_to_triangle(x, a, b, c));
    }
    const auto pieces = surface_.pieces_at(change.gone);
    if (entity.dim == 2 && pieces.empty()) return nearest;
    if (entity.dim != 1 || pieces.size() != 2) return {};
    const std::uint32_t along = surface_.find_piece(change.gone, change.kept);
    if (along == kNone || surface_.piece_edge(pieces[0]) != surface_.piece_edge(pieces[1])) return {};
    const Piece& other = surface_.piece(pieces[0] == along ? pieces[1] : pieces[0]);
    const std::uint32_t far = other[0] == change.gone ? other[1] : other[0];
    return std::max(nearest, distance_to_segment(x, change.place, surface_.point(far)));
  }

  void snap(std::uint32_t t, std::size_t i) {
    const Triangle verts = surface_.triangle(t);
    const std::uint32_t apex = verts[i], u = verts[(i + 1) % 3], v = verts[(i + 2) % 3];
    if (zone_.is_locked[apex] || zone_.is_locked[u] || zone_.is_locked[v]) return;
    const auto [a, b, c] = corners(surface_, t);
    const double height = least_height(a, b, c), tolerance = tolerance_of(verts);
    const bool is_feature = height < tolerance;
    const std::optional<LocalChange> change = plan_snap(surface_, t, static_cast<int>(i));
    if (!change || (!is_feature && !is_flat_swap(*change))) return;
    const BeforeAfter heights = compare_heights(surface_, *change), shapes = compare_shapes(surface_, *change);
    if (!(is_feature ? heights.after > kSnapHeight * heights.before : is_better_swap(*change, heights, shapes))) return;
    const Vec3& start = surface_.point(u);
    const Vec3 along = surface_.point(v) - start;
    const double share = std::clamp(dot(change->place - start, along) / norm2(along), 0.0, 1.0);
    const double moved =
        std::max(displacement_.from_edge(u, v, share, change->place), displacement_.from(apex, change->place));
    if ((is_feature && moved > tolerance) || !keeps_shape(surface_, *change, tolerance)) return;
    if (is_feature) {
      displacement_.merge_edge(u, v, share, apex, change->place);
      is_touched_[apex] = 1;
    }
    ++snaps_;
    make(*change);
  }

  // Whether a swap improves shapes and makes no feature: that would be swapped back, and so on.
  bool is_better_swap(const LocalChange& change, const BeforeAfter& heights, const BeforeAfter& shapes) const {
    double largest = 0;  // tolerance
    for (const AddedTriangle& added : change.added)
      for (const std::uint32_t v : added.verts) largest = std::max(largest, zone_.tolerances[v]);
    return shapes.after > kSwapShape * shapes.before && (heights.after > heights.before || heights.after > largest);
  }

  // Whether a snap swaps an edge inside of a face that is flat there.
  bool is_flat_swap(const LocalChange& change) const {
    if (change.removed.size() != 2 || surface_.find_piece(change.split[0], change.split[1]) != kNone) return false;
    const auto normal = [&](std::uint32_t t) {
      const auto [a, b, c] = corners(surface_, t);
      return normalized(cross(b - a, c - a));
    };
    return surface_.face(change.removed[0]) == surface_.face(change.removed[1]) &&
           dot(normal(change.removed[0]), normal(change.removed[1])) > kFlatCosine;
  }

  void make(const LocalChange& change) {
    apply(change, surface_);
    for (const std::uint32_t p : surface_.pieces_at(change.kept))
      for (const std::uint32_t v : surface_.piece(p)) is_touched_[v] = 1;
    std::vector<std::uint32_t> around;
    for (const AddedTriangle& added : change.added)
      for (const std::uint32_t v : added.verts) {
        const auto triangles = surface_.triangles_at(v);
        around.insert(around.end(), triangles.begin(), triangles.end());
      }
    sort_unique(around);
    for (const std::uint32_t t : around) push(t);
  }

  std::uint32_t root(std::uint32_t v) const {
    while (merged_into_[v] != kNone) v = merged_into_[v];
    return v;
  }

  // A point that was on a model edge of which it has no piece any more lies on what there is now.
  void reclassify_points() {
    for (std::uint32_t v = 0; v < surface_.point_count(); ++v) {
      const ModelEntity entity = surface_.entity(v);
      if (!is_touched_[v] || entity.dim != 1 || surface_.triangles_at(v).empty()) continue;
      std::uint32_t lowest = kNone;
      bool has_own = false;
      for (const std::uint32_t p : surface_.pieces_at(v)) {
        lowest = std::min(lowest, surface_.piece_edge(p));
        has_own = has_own || surface_.piece_edge(p) == entity.index;
      }
      if (has_own) continue;
      const ModelEntity now = lowest != kNone ? ModelEntity(ModelEdgeId(lowest))
                                              : ModelEntity(ModelFaceId(surface_.face(surface_.triangles_at(v)[0])));
      surface_.move_point(v, surface_.point(v), now);
    }
  }

  ZoneChange finish() {
    ZoneChange change;
    change.collapses = collapses_, change.snaps = snaps_;
    if (collapses_ + snaps_ == 0) return change;
    reclassify_points();
    for (std::uint32_t v = 0; v < surface_.point_count(); ++v) {
      change.items.points.push_back(surface_.point(v));
      change.items.point_to_entity.push_back(surface_.entity(v));
      change.now.push_back(root(v));
      change.moved.push_back(is_touched_[v] ? displacement_.from(v, surface_.point(v)) : 0);
      change.is_gone.push_back(surface_.is_gone(v));
    }
    for (const std::uint32_t t : surface_.triangles_left()) {
      change.items.triangles.push_back(surface_.triangle(t));
      change.items.tri_to_face.push_back(surface_.face(t));
      change.tri_source.push_back(surface_.source(t));
    }
    for (const std::uint32_t p : surface_.pieces_left()) {
      change.items.pieces.push_back(surface_.piece(p));
      change.items.piece_to_edge.push_back(surface_.piece_edge(p));
      change.piece_source.push_back(surface_.piece_source(p));
    }
    change.is_touched = std::move(is_touched_);
    return change;
  }

  const Zone& zone_;
  const TaskRunner& runner_;
  SurfaceComplex surface_;
  Displacement displacement_;
  std::vector<std::uint8_t> is_touched_;    // per point: something was merged there
  std::vector<std::uint32_t> merged_into_;  // per point, kNone for those that are there
  std::priority_queue<Task> tasks_;
  std::vector<bool> is_queued_;  // per triangle
  std::size_t collapses_ = 0, snaps_ = 0;
};

}  // namespace

ZoneChange eliminate_in_zone(const Zone& zone, std::span<const FaceSides> sides, const TaskRunner& runner) {
  return Eliminator(zone, sides, runner).run();
}

}  // namespace tetloom::features
