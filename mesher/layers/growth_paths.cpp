#include "mesher/layers/growth_paths.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>

#include "core/base/grain.hpp"
#include "mesher/layers/front_spreading.hpp"
#include "mesher/layers/growth_direction.hpp"
#include "mesher/layers/layer_cells.hpp"

namespace tetloom::layers {
namespace {

constexpr double kBlind = 0.0872;    // cos 85°: a wall that is seen less has no direction
constexpr double kBesideSide = 0.5;  // sin 30°: between wall and side face
constexpr double kMostStretch = 2;
constexpr double kStep = 0.3;                                 // of the width
constexpr double kLeastFirstStep = 0.004, kLeastStep = 0.04;  // of the width: a curve with shorter steps ends
constexpr double kPaceSlope = 0.01;                           // of the widths that steps are taken from
constexpr int kPaceSweeps = 60;
constexpr int kMostSteps = 60;
constexpr int kSweeps = 8;
constexpr double kKeptAtFoot = 0.966;   // cos 15°: of the best visibility, for the first step
constexpr double kRidge = 0.9397;       // cos 20°: a best visibility below is that of an edge
constexpr double kNearNormal = 0.9703;  // cos 14°: away from edges the first step leans no more, where it need not
constexpr double kKeptAbove = 0.8;
constexpr double kMostShift = 1.5;  // of the step
constexpr double kRoomAtFan = 0.4;  // of the width: a fan needs layers as thick as that
constexpr double kLeastShape = 0.01;
constexpr double kTilt = 0.02;       // of a front above a flat wall, where steps differ: no reason to stretch heights
constexpr double kSoundPrism = 0.1;  // scaled Jacobian between fronts; less above narrow triangles

class Marching {
 public:
  Marching(const GrowthStart& start, const TaskRunner& runner, const KeptPaths& kept)
      : start_(start),
        walls_(start.walls),
        sides_(start.sides),
        runner_(runner),
        kept_(kept),
        replays_(kept.paths && kept.paths->fans_without_room.empty()),
        pace_(walls_.curve_to_width),
        wanted_(walls_.curve_count(), 0),
        step_(walls_.curve_count(), 0),
        stretch_(walls_.curve_count(), 1),
        freedom_(walls_.curve_count()),
        direction_(walls_.curve_count()),
        front_(feet(start.mesh, walls_)),
        spreading_(walls_, front_) {
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) (is_replayed(c) ? replayed_ : active_).push_back(c);
    open_walls_.resize(walls_.triangles.size()), normals_.resize(walls_.triangles.size());
    std::iota(open_walls_.begin(), open_walls_.end(), 0u);
    paths_.reached.assign(walls_.curve_count(), 0);
    paths_.stretch.assign(walls_.curve_count(), 1);
    paths_.limits.assign(walls_.curve_count(), LayerLimit::None);
    paths_.fronts.push_back(front_);
    paths_.heights.push_back(paths_.reached);
  }

  GrowthPaths run() {
    find_places();
    find_shapes();
    look_ahead();
    find_directions(true);
    find_lengths();
    find_fans_without_room();
    if (!paths_.fans_without_room.empty()) return std::move(paths_);
    for (int i = 0; i < kMostSteps && go_on(); ++i) {
      leave_out_ended();
      look_ahead();
      find_directions(false);
    }
    for (const std::uint32_t c : active_)
      if (direction_[c] != Vec3{} && is_growing(c)) paths_.limits[c] = LayerLimit::Concave;
    return std::move(paths_);
  }

 private:
  static std::vector<Vec3> feet(const Mesh& mesh, const Walls& walls) {
    std::vector<Vec3> feet;
    for (const std::uint32_t v : walls.curve_to_vert) feet.push_back(mesh.points[v]);
    return feet;
  }

  bool is_kept(std::uint32_t curve) const { return kept_.paths && kept_.curves[curve] != kNone; }
  bool is_replayed(std::uint32_t curve) const { return replays_ && is_kept(curve); }

  // Curves that are replayed: where they go next. They ask for no heights.
  void look_ahead() {
    const std::size_t last = replayed_.empty() ? 0 : kept_.paths->fronts.size() - 1;
    const std::size_t here = std::min(last, paths_.fronts.size() - 1), next = std::min(last, here + 1);
    for (const std::uint32_t c : replayed_) {
      const std::uint32_t old = kept_.curves[c];
      paths_.stretch[c] = kept_.paths->stretch[old], paths_.limits[c] = kept_.paths->limits[old];
      if (kept_.paths->heights[next][old] > kept_.paths->heights[here][old])
        direction_[c] = normalized(kept_.paths->fronts[next][old] - kept_.paths->fronts[here][old]);
    }
  }

  bool replays_on() const { return !replayed_.empty() && paths_.fronts.size() < kept_.paths->fronts.size(); }

  // Curves that are replayed go on to the next front, or stay at the last one.
  void replay(std::vector<std::uint8_t>& is_moving, std::vector<double>& rise, std::vector<Vec3>& next) const {
    if (!replays_on()) return;
    const std::size_t up = paths_.fronts.size();
    for (const std::uint32_t c : replayed_) {
      const std::uint32_t old = kept_.curves[c];
      rise[c] = kept_.paths->heights[up][old] - kept_.paths->heights[up - 1][old];
      is_moving[c] = rise[c] > 0;
      next[c] = kept_.paths->fronts[up][old];
    }
  }

  // The prism above a narrow triangle cannot be better than the triangle.
  void find_shapes() {
    for (const WallTriangle& wall : walls_.triangles) {
      const auto& [a, b, c] = wall.curves;
      const Vec3 up = cross(front_[b] - front_[a], front_[c] - front_[a]);
      const Vec3 height = std::sqrt(norm(up)) * normalized(up);
      const std::array prism{front_[a],          front_[b],          front_[c],
                             front_[a] + height, front_[b] + height, front_[c] + height};
      shapes_.push_back(static_cast<float>(std::max(scaled_jacobian(prism), kLeastShape)));
    }
  }

  // Neighbours go on at about one speed, or the front would tilt without a reason; but no slower than ends in time.
  void even_out_pace() {
    std::vector<std::uint32_t> asked = active_;  // those around what the last sweep has changed
    std::vector<double> next;
    for (int sweep = 0; sweep < kPaceSweeps && !asked.empty(); ++sweep) {
      next.resize(asked.size());
      for_each_of(asked, [&](std::size_t i) { next[i] = pace_beside_others(asked[i]); });
      std::vector<std::uint32_t> changed;
      for (std::size_t i = 0; i < asked.size(); ++i) {
        if (next[i] == pace_[asked[i]]) continue;
        pace_[asked[i]] = next[i];
        changed.push_back(asked[i]);
      }
      asked = active_around(changed);
    }
  }

  double pace_beside_others(std::uint32_t curve) const {
    constexpr double kInTime = 0.5;
    double pace = pace_[curve];
    const double least = std::min(pace, wanted_[curve] / (kInTime * kMostSteps * kStep));
    for (const std::uint32_t w : walls_.triangles_at(curve))
      for (const std::uint32_t other : walls_.triangles[w].curves)
        pace = std::min(pace, pace_[other] + kPaceSlope * distance(front_[curve], front_[other]));
    return std::max(pace, least);
  }

  // The active ones of the curves and of their neighbours, each once.
  std::vector<std::uint32_t> active_around(std::span<const std::uint32_t> curves) const {
    std::vector<std::uint8_t> is_near(walls_.curve_count(), 0);
    for (const std::uint32_t c : curves) walls_.mark_around(c, is_near);
    std::vector<std::uint32_t> near;
    std::ranges::copy_if(active_, std::back_inserter(near), [&](std::uint32_t c) { return is_near[c] != 0; });
    return near;
  }

  // Calls body(place) for the places of the list.
  template <class Body>
  void for_each_of(std::span<const std::uint32_t> list, const Body& body) const {
    runner_.for_blocks(list.size(), kStarGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) body(i);
    });
  }
  template <class Body>
  void for_each_curve(const Body& body) const {
    for_each_of(active_, [&](std::size_t i) { body(active_[i]); });
  }

  // Curves that have ended stay as they are, and what lies between such curves with them.
  void leave_out_ended() {
    std::erase_if(active_, [&](std::uint32_t c) { return !is_growing(c); });
    std::vector<std::uint8_t> is_active(walls_.curve_count(), 0);
    for (const std::uint32_t c : active_) is_active[c] = 1;
    std::erase_if(open_walls_, [&](std::uint32_t w) {
      return std::ranges::none_of(walls_.triangles[w].curves, [&](std::uint32_t c) { return is_active[c] != 0; });
    });
  }

  Vec3 normal_of(std::uint32_t wall) const {
    const auto& [a, b, c] = walls_.triangles[wall].curves;
    return normalized(cross(front_[b] - front_[a], front_[c] - front_[a]));
  }

  void gather_normals(std::uint32_t curve, std::vector<Vec3>& normals) const {
    normals.clear();
    for (const std::uint32_t w : walls_.triangles_at(curve)) normals.push_back(normals_[w]);
  }

  double visibility_at(std::uint32_t curve, const Vec3& direction) const {
    double least = 1;
    for (const std::uint32_t w : walls_.triangles_at(curve)) least = std::min(least, dot(direction, normals_[w]));
    return least;
  }

  bool is_growing(std::uint32_t curve) const { return paths_.reached[curve] < wanted_[curve]; }

  void find_directions(bool is_first) {
    for_each_of(open_walls_, [&](std::size_t i) { normals_[open_walls_[i]] = normal_of(open_walls_[i]); });
    visibility_.assign(walls_.curve_count(), 0);
    for_each_curve([&](std::uint32_t c) {
      if (!is_first && !is_growing(c)) return;
      if (walls_.triangles_at(c).empty()) {  // of a fan: straight on
        direction_[c] = walls_.curve_to_direction[c], visibility_[c] = 1;
        return;
      }
      thread_local std::vector<Vec3> normals;
      gather_normals(c, normals);
      direction_[c] = constrain(c, most_normal_direction(normals).direction);
      freedom_[c] = find_freedom(normals);
      visibility_[c] = visibility_of(direction_[c], normals);
      if (is_first) judge(c);
    });
    smooth(is_first);
    for_each_curve([&](std::uint32_t c) {
      if (!is_first && !is_growing(c)) return;
      const double stretch = std::clamp(1 / std::max(visibility_at(c, direction_[c]), kBlind), 1.0, kMostStretch);
      if (is_first || std::abs(stretch - stretch_[c]) > kTilt * stretch_[c]) stretch_[c] = stretch;
    });
    if (!is_first) return;
    for (const std::uint32_t c : active_) paths_.stretch[c] = stretch_[c];
  }

  // Curves without a direction stay where they are.
  void judge(std::uint32_t curve) {
    const CurveSides* sides = sides_.at(curve);
    const bool leaves_sides = sides && dot(direction_[curve], sides->into) <= 0;
    if (sides && (sides->is_blocked || leaves_sides || visibility_[curve] < kBesideSide)) {
      paths_.limits[curve] = LayerLimit::SideAngle;
    } else if (!(visibility_[curve] >= kBlind)) {
      paths_.limits[curve] = LayerLimit::NoNormal;
    } else {
      return;
    }
    direction_[curve] = {};
    visibility_[curve] = 0;
  }

  // Each sweep takes the directions of the last one.
  void smooth(bool is_first) {
    std::vector<Vec3> smoothed = direction_;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for_each_curve([&](std::uint32_t c) {
        if (direction_[c] == Vec3{} || sides_.is_along_edge(c) || (!is_first && !is_growing(c))) return;
        Vec3 sum;
        for (const auto& other : spreading_.neighbours_of(c)) sum += direction_[other.curve];
        if (sum == Vec3{}) return;
        const Vec3 tried =
            constrain(c, normalized(direction_[c] + 0.5 * freedom_[c].within(normalized(sum) - direction_[c])));
        const double least = is_first ? least_at_foot(visibility_[c]) : kKeptAbove * visibility_[c];
        smoothed[c] = visibility_at(c, tried) >= least ? tried : direction_[c];
      });
      direction_ = smoothed;
    }
  }

  static double least_at_foot(double best) {
    const double least = kKeptAtFoot * best;
    return best > kRidge ? std::max(least, std::min(best, kNearNormal)) : least;
  }

  void find_lengths() {
    std::vector<Vec3> directions = direction_;
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c)
      if (is_kept(c)) directions[c] = {};
    WantedHeights& wanted = paths_.wanted;
    wanted = find_wanted_heights({start_.mesh, start_.face_to_sides, walls_, sides_, directions, stretch_}, runner_);
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      if (!is_kept(c)) continue;
      wanted.heights[c] = kept_.paths->wanted.heights[kept_.curves[c]];
      wanted.limits[c] = kept_.paths->wanted.limits[kept_.curves[c]];
    }
    for (const std::uint32_t c : active_) wanted_[c] = wanted.heights[c];
    for (const std::uint32_t c : replayed_) pace_[c] = kept_.paths->pace[kept_.curves[c]];
    even_out_pace();
    paths_.pace = pace_;
    for (const std::uint32_t c : active_) {
      if (wanted.limits[c] != LayerLimit::None) paths_.limits[c] = wanted.limits[c];
      step_[c] = std::max(full_step(c), std::min(walls_.curve_to_heights[c].first, kStep * walls_.curve_to_width[c]));
    }
  }

  void find_fans_without_room() {
    for (const FanVertex& fan : walls_.fan_vertices)
      if (std::ranges::any_of(fan.curves, [&](std::uint32_t c) {
            return !is_replayed(c) && wanted_[c] * stretch_[c] < kRoomAtFan * walls_.curve_to_width[c];
          }))
        paths_.fans_without_room.push_back(walls_.curve_to_vert[fan.curves[0]]);
  }

  // One step of all curves. False when there is nothing left to do.
  bool go_on() {
    runner_.check_cancelled();
    std::vector<std::uint8_t> is_moving(walls_.curve_count(), 0);
    bool any = replays_on();
    for (const std::uint32_t c : active_) {
      is_moving[c] = direction_[c] != Vec3{} && is_growing(c);
      any = any || is_moving[c];
    }
    if (!any) return false;
    std::vector<std::uint8_t> is_new = is_moving;
    std::vector<double> rise(walls_.curve_count(), 0);
    std::vector<Vec3> next = front_;
    replay(is_moving, rise, next);
    for_each_curve([&](std::uint32_t c) {
      if (is_moving[c]) next[c] = front_[c] + height_of_step(c) * stretch_[c] * direction_[c];
    });
    const std::vector<Vec3> shifts = find_shifts(next);
    const auto place = [&](std::uint32_t c) {
      rise[c] = is_moving[c] ? height_of_step(c) : 0;
      if (!is_moving[c]) return;
      const double share = std::min(1.0, rise[c] / full_step(c));
      next[c] = front_[c] + rise[c] * stretch_[c] * direction_[c] + share * shifts[c];
    };
    for_each_curve(place);
    put_on_sides(is_new, next);
    for (;;) {
      const std::vector<std::uint8_t> is_bad = find_bad(is_moving, is_new, next);
      if (std::ranges::count(is_bad, 1) == 0) break;
      for_each_curve([&](std::uint32_t c) {
        if (is_bad[c]) halve(c, is_moving[c], next[c]);
        if (is_bad[c]) place(c);
      });
      put_on_sides(is_bad, next);
      is_new = is_bad;
    }
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      paths_.reached[c] += rise[c];
      if (!is_replayed(c)) step_[c] = std::min(2 * step_[c], full_step(c));
    }
    paths_.heights.push_back(paths_.reached);
    for (std::size_t i = 0; i < tried_.size(); ++i)
      if (is_moving[sides_.curves()[i].curve]) places_[i] = tried_[i];
    front_ = std::move(next);
    paths_.fronts.push_back(front_);
    return true;
  }

  // Those of the curves that are on side faces.
  template <class Body>
  void for_each_on_sides(const Body& body) const {
    constexpr std::size_t kSideGrain = 64;
    runner_.for_blocks(sides_.curves().size(), kSideGrain, [&](std::size_t begin, std::size_t end) {
      SideProjector projector(sides_);
      for (std::size_t i = begin; i < end; ++i)
        if (!sides_.curves()[i].is_blocked) body(i, projector);
    });
  }

  void find_places() {
    places_.resize(sides_.curves().size());
    for_each_on_sides(
        [&](std::size_t i, SideProjector& projector) { places_[i] = projector.at_foot(sides_.curves()[i]); });
    tried_ = places_;
  }

  void put_on_sides(const std::vector<std::uint8_t>& is_tried, std::vector<Vec3>& next) {
    for_each_on_sides([&](std::size_t i, SideProjector& projector) {
      const CurveSides& curve = sides_.curves()[i];
      if (!is_tried[curve.curve]) return;
      tried_[i] = projector.put(curve, next[curve.curve], places_[i]);
      next[curve.curve] = tried_[i].point;
    });
  }

  Vec3 constrain(std::uint32_t curve, const Vec3& direction) const {
    const CurveSides* sides = sides_.at(curve);
    return sides && !sides->is_blocked ? constrained(places_[sides_.index_of(curve)], direction) : direction;
  }

  // The first step leaves the wall straight.
  std::vector<Vec3> find_shifts(const std::vector<Vec3>& next) const {
    if (paths_.fronts.size() == 1) return std::vector<Vec3>(walls_.curve_count());
    std::vector<std::uint8_t> is_free(walls_.curve_count(), 0);
    std::vector<double> most(walls_.curve_count(), 0);
    for_each_curve([&](std::uint32_t c) {
      is_free[c] = direction_[c] != Vec3{} && !sides_.is_along_edge(c) && is_growing(c);
      most[c] = kMostShift * full_step(c);
    });
    return spreading_.find_shifts({next, is_free, freedom_, most}, runner_);
  }

  double full_step(std::uint32_t curve) const { return kStep * pace_[curve]; }

  double height_of_step(std::uint32_t curve) const {
    constexpr double kRest = 1.3;  // rather one longer step than a short one behind it
    const double left = wanted_[curve] - paths_.reached[curve];
    return left <= kRest * step_[curve] ? left * (1 + 1e-12) : step_[curve];
  }

  void halve(std::uint32_t curve, std::uint8_t& is_moving, Vec3& next) {
    step_[curve] = 0.5 * std::min(step_[curve], height_of_step(curve));
    const double least = paths_.fronts.size() == 1 ? kLeastFirstStep : kLeastStep;
    if (step_[curve] >= least * pace_[curve]) return;
    is_moving = 0;
    next = front_[curve];
    wanted_[curve] = paths_.reached[curve];
    paths_.limits[curve] = LayerLimit::Concave;
  }

  // Curves of which a cell between the fronts is not sound, of those at new places.
  std::vector<std::uint8_t> find_bad(const std::vector<std::uint8_t>& is_moving,
                                     const std::vector<std::uint8_t>& is_new, const std::vector<Vec3>& next) const {
    const auto is_concerned = [&](const WallTriangle& wall) {
      return std::ranges::any_of(wall.curves, [&](std::uint32_t c) { return is_new[c] != 0; });
    };
    std::vector<std::uint8_t> wall_is_bad(open_walls_.size(), 0);
    for_each_of(open_walls_, [&](std::size_t i) {
      const std::uint32_t w = open_walls_[i];
      wall_is_bad[i] = is_concerned(walls_.triangles[w]) && !is_sound(w, is_moving, next);
    });
    std::vector<std::uint8_t> is_bad(walls_.curve_count(), 0);
    for (std::size_t i = 0; i < open_walls_.size(); ++i)
      for (const std::uint32_t c : walls_.triangles[open_walls_[i]].curves)
        if (wall_is_bad[i] && is_moving[c] && !is_replayed(c)) is_bad[c] = 1;
    return is_bad;
  }

  bool is_sound(std::size_t wall, const std::vector<std::uint8_t>& is_moving, const std::vector<Vec3>& next) const {
    const auto& curves = walls_.triangles[wall].curves;
    const double least = std::min<double>(kSoundPrism, shapes_[wall] * shapes_[wall]);
    bool sound = true;
    for_each_cell({is_moving[curves[0]], is_moving[curves[1]], is_moving[curves[2]]},
                  [&](CellKind, const auto& corners) {
                    std::array<Vec3, std::tuple_size_v<std::decay_t<decltype(corners)>>> x;
                    for (std::size_t i = 0; i < x.size(); ++i) {
                      const std::uint32_t c = curves[corners[i].corner];
                      x[i] = corners[i].level > 0 ? next[c] : front_[c];
                    }
                    sound = sound && layers::is_sound(x, least);
                  });
    return sound;
  }

  const GrowthStart& start_;
  const Walls& walls_;
  const SideFaces& sides_;
  const TaskRunner& runner_;
  const KeptPaths& kept_;
  const bool replays_;                            // rather than only keeping how high curves may become
  std::vector<std::uint32_t> active_, replayed_;  // all curves, without those of the active ones that have ended
  std::vector<std::uint32_t> open_walls_;         // wall triangles with curves that are active
  std::vector<double> pace_;                      // widths, varying little from curve to curve
  std::vector<double> wanted_, step_, stretch_;   // heights, and lengths over heights
  std::vector<FrontFreedom> freedom_;             // within the front
  std::vector<Vec3> direction_, front_, normals_;
  std::vector<double> visibility_;
  std::vector<float> shapes_;  // scaled Jacobian of straight prisms, per wall triangle
  FrontSpreading spreading_;
  std::vector<SidePlace> places_, tried_;  // per curve on side faces: at the front, and where the next one was tried
  GrowthPaths paths_;
};

}  // namespace

Vec3 GrowthPaths::point_at(std::uint32_t curve, double height) const {
  std::size_t k = 1;
  while (k + 1 < fronts.size() && heights[k][curve] < height) ++k;
  while (k > 1 && heights[k][curve] == heights[k - 1][curve]) --k;  // it has ended before
  if (k >= fronts.size()) return fronts.back()[curve];
  const double low = heights[k - 1][curve], high = heights[k][curve];
  if (!(high > low)) return fronts[k][curve];
  return fronts[k - 1][curve] + (height - low) / (high - low) * (fronts[k][curve] - fronts[k - 1][curve]);
}

GrowthPaths make_paths(const GrowthStart& start, const TaskRunner& runner, const KeptPaths& kept) {
  return Marching(start, runner, kept).run();
}

}  // namespace tetloom::layers
