#include "mesher/layers/growth_paths.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/layers/clearance.hpp"
#include "mesher/layers/growth_direction.hpp"
#include "mesher/layers/layer_cells.hpp"

namespace tetloom::layers {
namespace {

constexpr std::size_t kGrain = 1024;
constexpr double kBlind = 0.0872;    // cos 85°: a wall that is seen less has no direction
constexpr double kBesideSide = 0.5;  // sin 30°: between wall and side face
constexpr double kMostStretch = 2;
constexpr double kStep = 0.3;                                 // of the width
constexpr double kLeastFirstStep = 0.004, kLeastStep = 0.04;  // of the width: a curve with shorter steps ends
constexpr int kMostSteps = 60;
constexpr int kSweeps = 8;
constexpr double kKeptAtFoot = 0.966;  // cos 15°: of the best visibility, for the first step
constexpr double kKeptAbove = 0.8;
constexpr int kShiftSweeps = 4;
constexpr double kShift = 0.7;                     // of the way to the mean of the neighbours, a sweep
constexpr double kShrinking = 0.02;                // of the lengths of the wall's edges: a front that shrinks
constexpr double kMostShift = 0.7;                 // of the step
constexpr double kSoundPrism = 0.1;                // scaled Jacobian between fronts
constexpr double kOfGap = 0.35, kOfFreeGap = 0.7;  // that layers may take, with layers opposite and without
constexpr double kLeftInGap = 0.9;                 // widths that stay for other elements

class Marching {
 public:
  Marching(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls, const SideFaces& sides,
           const TaskRunner& runner)
      : mesh_(mesh),
        face_to_sides_(face_to_sides),
        walls_(walls),
        sides_(sides),
        runner_(runner),
        wanted_(walls.curve_count(), 0),
        step_(walls.curve_count(), 0),
        direction_(walls.curve_count()) {
    paths_.reached.assign(walls.curve_count(), 0);
    paths_.stretch.assign(walls.curve_count(), 1);
    paths_.limits.assign(walls.curve_count(), LayerLimit::None);
    for (const std::uint32_t v : walls.curve_to_vert) front_.push_back(mesh.points[v]);
    paths_.fronts.push_back(front_);
  }

  GrowthPaths run() {
    find_places();
    find_weights();
    find_directions(true);
    find_lengths();
    for (int i = 0; i < kMostSteps && go_on(); ++i) find_directions(false);
    return std::move(paths_);
  }

 private:
  template <class Body>
  void for_each_curve(const Body& body) const {
    runner_.for_blocks(walls_.curve_count(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t c = begin; c < end; ++c) body(static_cast<std::uint32_t>(c));
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

  bool is_growing(std::uint32_t curve) const { return paths_.reached[curve] < wanted_[curve]; }

  void find_directions(bool is_first) {
    normals_.resize(walls_.triangles.size());
    runner_.for_blocks(normals_.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t w = begin; w < end; ++w) normals_[w] = normal_of(static_cast<std::uint32_t>(w));
    });
    visibility_.assign(walls_.curve_count(), 0);
    for_each_curve([&](std::uint32_t c) {
      if (!is_first && !is_growing(c)) return;
      thread_local std::vector<Vec3> normals;
      gather_normals(c, normals);
      direction_[c] = constrain(c, most_normal_direction(normals).direction);
      visibility_[c] = visibility_of(direction_[c], normals);
      if (is_first) judge(c);
    });
    smooth(is_first ? kKeptAtFoot : kKeptAbove, is_first);
    if (!is_first) return;
    for_each_curve([&](std::uint32_t c) {
      thread_local std::vector<Vec3> normals;
      gather_normals(c, normals);
      paths_.stretch[c] = std::clamp(1 / std::max(visibility_of(direction_[c], normals), kBlind), 1.0, kMostStretch);
    });
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
  void smooth(double kept, bool is_first) {
    std::vector<Vec3> smoothed = direction_;
    for (int sweep = 0; sweep < kSweeps; ++sweep) {
      for_each_curve([&](std::uint32_t c) {
        if (direction_[c] == Vec3{} || sides_.is_along_edge(c) || (!is_first && !is_growing(c))) return;
        Vec3 sum;
        for (const std::uint32_t w : walls_.triangles_at(c))
          for (const std::uint32_t other : walls_.triangles[w].curves)
            if (other != c) sum += direction_[other];
        if (sum == Vec3{}) return;
        thread_local std::vector<Vec3> normals;
        gather_normals(c, normals);
        const Vec3 tried = constrain(c, normalized(direction_[c] + normalized(sum)));
        smoothed[c] = visibility_of(tried, normals) >= kept * visibility_[c] ? tried : direction_[c];
      });
      direction_ = smoothed;
    }
  }

  void find_lengths() {
    std::vector<double> reach(walls_.curve_count());
    for_each_curve([&](std::uint32_t c) {
      if (direction_[c] == Vec3{}) return;
      const LayerHeights& heights = walls_.curve_to_heights[c];
      wanted_[c] = heights.sum(heights.count) * paths_.stretch[c];
      step_[c] = kStep * walls_.curve_to_width[c];
      reach[c] = std::max(wanted_[c] / kOfGap, 2 * wanted_[c] + kLeftInGap * walls_.curve_to_width[c]);
      if (const CurveSides* sides = sides_.at(c)) shorten(c, sides->room, LayerLimit::SideAngle);
    });
    const intersection::TriangleTree tree(mesh_.points, mesh_.tri_to_vert, runner_);
    const std::vector<Clearance> clearances =
        find_clearances(mesh_, face_to_sides_, walls_, tree, direction_, reach, runner_);
    for_each_curve([&](std::uint32_t c) {
      if (direction_[c] != Vec3{}) shorten(c, length_in_gap(c, clearances[c]), LayerLimit::Gap);
    });
  }

  // What leaves room for other elements, but one layer where it takes no more than its share.
  double length_in_gap(std::uint32_t curve, const Clearance& clearance) const {
    const double share = (clearance.has_layers ? kOfGap : kOfFreeGap) * clearance.distance;
    const double left = clearance.distance - kLeftInGap * walls_.curve_to_width[curve];
    const double one = walls_.curve_to_heights[curve].first * paths_.stretch[curve];
    return std::max(std::min(share, clearance.has_layers ? left / 2 : left), one <= share ? one : 0);
  }

  void shorten(std::uint32_t curve, double length, LayerLimit limit) {
    if (length >= wanted_[curve]) return;
    wanted_[curve] = length;
    paths_.limits[curve] = limit;
  }

  // One step of all curves. False when there is nothing left to do.
  bool go_on() {
    runner_.check_cancelled();
    std::vector<std::uint8_t> is_moving(walls_.curve_count(), 0);
    bool any = false;
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c) {
      is_moving[c] = direction_[c] != Vec3{} && is_growing(c);
      any = any || is_moving[c];
    }
    if (!any) return false;
    std::vector<Vec3> next = front_;
    const std::vector<Vec3> shifts = find_shifts();
    const auto place = [&](std::uint32_t c) {
      const double length = length_of_step(c);
      if (is_moving[c]) next[c] = front_[c] + length * direction_[c] + length / step_[c] * shifts[c];
    };
    for_each_curve(place);
    put_on_sides(is_moving, next);
    std::vector<std::uint8_t> is_new = is_moving;
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
    for (std::uint32_t c = 0; c < walls_.curve_count(); ++c)
      if (is_moving[c]) paths_.reached[c] += distance(front_[c], next[c]);
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

  // Towards the mean of the ways that the neighbours have come, within the front and where it shrinks, as at concave
  // edges. The weights are those of harmonic maps (Pinkall & Polthier 1993), so that a front that shrinks evenly stays
  // as it is. The first step leaves the wall straight.
  std::vector<Vec3> find_shifts() const {
    std::vector<Vec3> shifts(walls_.curve_count());
    if (paths_.fronts.size() == 1) return shifts;
    std::vector<std::uint8_t> is_shrinking(walls_.curve_count(), 0);
    for_each_curve([&](std::uint32_t c) { is_shrinking[c] = shrinks_at(c); });
    std::vector<Vec3> next = shifts;
    for (int sweep = 0; sweep < kShiftSweeps; ++sweep) {
      for_each_curve([&](std::uint32_t c) {
        if (is_shrinking[c]) next[c] = shift_at(c, shifts);
      });
      shifts.swap(next);
    }
    return shifts;
  }

  // Visits the neighbours of a curve, each once per triangle, with their weight there.
  template <class Visit>
  void for_each_neighbour(std::uint32_t curve, const Visit& visit) const {
    for (const std::uint32_t w : walls_.triangles_at(curve)) {
      const auto& curves = walls_.triangles[w].curves;
      for (std::size_t i = 0; i < 3; ++i)
        if (curves[i] != curve) {
          const std::size_t opposite = curves[(i + 1) % 3] == curve ? (i + 2) % 3 : (i + 1) % 3;
          visit(curves[i], weights_[w][opposite]);
        }
    }
  }

  bool shrinks_at(std::uint32_t curve) const {
    if (direction_[curve] == Vec3{} || sides_.is_along_edge(curve) || !is_growing(curve)) return false;
    double growth = 0, size = 0;
    for_each_neighbour(curve, [&](std::uint32_t other, double) {
      const Vec3 edge = paths_.fronts[0][other] - paths_.fronts[0][curve];
      growth += dot(way_of(other) - way_of(curve), edge);
      size += norm2(edge);
    });
    return growth < -kShrinking * size;
  }

  Vec3 shift_at(std::uint32_t curve, const std::vector<Vec3>& shifts) const {
    Vec3 sum;
    double weights = 0;
    for_each_neighbour(curve, [&](std::uint32_t other, double weight) {
      sum += weight * (way_of(other) + shifts[other]);
      weights += weight;
    });
    const Vec3 shift = kShift * (sum / weights - way_of(curve));
    const Vec3 within = shift - dot(shift, direction_[curve]) * direction_[curve];
    const double most = kMostShift * step_[curve] / std::max(norm(within), 1e-300);
    return std::min(1.0, most) * within;
  }

  // Cotangents of the angles, per triangle and corner; those of blunt angles count little.
  void find_weights() {
    constexpr double kLeast = 0.05;
    weights_.resize(walls_.triangles.size());
    for (std::size_t w = 0; w < weights_.size(); ++w)
      for (std::size_t i = 0; i < 3; ++i) {
        const auto& curves = walls_.triangles[w].curves;
        const Vec3 a = front_[curves[(i + 1) % 3]] - front_[curves[i]],
                   b = front_[curves[(i + 2) % 3]] - front_[curves[i]];
        weights_[w][i] = static_cast<float>(std::max(kLeast, dot(a, b) / std::max(norm(cross(a, b)), 1e-300)));
      }
  }

  Vec3 way_of(std::uint32_t curve) const { return front_[curve] - paths_.fronts[0][curve]; }

  double length_of_step(std::uint32_t curve) const {
    constexpr double kRest = 1.3;  // rather one longer step than a short one behind it
    const double left = wanted_[curve] - paths_.reached[curve];
    return left <= kRest * step_[curve] ? left * (1 + 1e-12) : step_[curve];
  }

  void halve(std::uint32_t curve, std::uint8_t& is_moving, Vec3& next) {
    step_[curve] = 0.5 * std::min(step_[curve], length_of_step(curve));
    const double least = paths_.fronts.size() == 1 ? kLeastFirstStep : kLeastStep;
    if (step_[curve] >= least * walls_.curve_to_width[curve]) return;
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
    std::vector<std::uint8_t> wall_is_bad(walls_.triangles.size(), 0);
    runner_.for_blocks(wall_is_bad.size(), kGrain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t w = begin; w < end; ++w)
        wall_is_bad[w] = is_concerned(walls_.triangles[w]) && !is_sound(walls_.triangles[w].curves, is_moving, next);
    });
    std::vector<std::uint8_t> is_bad(walls_.curve_count(), 0);
    for (std::size_t w = 0; w < wall_is_bad.size(); ++w)
      for (const std::uint32_t c : walls_.triangles[w].curves)
        if (wall_is_bad[w] && is_moving[c]) is_bad[c] = 1;
    return is_bad;
  }

  bool is_sound(const std::array<std::uint32_t, 3>& curves, const std::vector<std::uint8_t>& is_moving,
                const std::vector<Vec3>& next) const {
    bool sound = true;
    for_each_cell({is_moving[curves[0]], is_moving[curves[1]], is_moving[curves[2]]},
                  [&](CellKind, const auto& corners) {
                    std::array<Vec3, std::tuple_size_v<std::decay_t<decltype(corners)>>> x;
                    for (std::size_t i = 0; i < x.size(); ++i) {
                      const std::uint32_t c = curves[corners[i].corner];
                      x[i] = corners[i].level > 0 ? next[c] : front_[c];
                    }
                    sound = sound && layers::is_sound(x, kSoundPrism);
                  });
    return sound;
  }

  const Mesh& mesh_;
  std::span<const FaceSides> face_to_sides_;
  const Walls& walls_;
  const SideFaces& sides_;
  const TaskRunner& runner_;
  std::vector<double> wanted_, step_;
  std::vector<Vec3> direction_, front_, normals_;
  std::vector<double> visibility_;
  std::vector<std::array<float, 3>> weights_;  // per wall triangle and corner
  std::vector<SidePlace> places_, tried_;  // per curve on side faces: at the front, and where the next one was tried
  GrowthPaths paths_;
};

}  // namespace

Vec3 GrowthPaths::point_at(std::uint32_t curve, double length) const {
  double before = 0;
  for (std::size_t k = 1; k < fronts.size(); ++k) {
    const Vec3 &from = fronts[k - 1][curve], &to = fronts[k][curve];
    const double step = distance(from, to);
    if (step == 0) continue;
    if (before + step >= length || k + 1 == fronts.size()) return from + (length - before) / step * (to - from);
    before += step;
  }
  return fronts.back()[curve];
}

GrowthPaths make_paths(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls,
                       const SideFaces& sides, const TaskRunner& runner) {
  return Marching(mesh, face_to_sides, walls, sides, runner).run();
}

}  // namespace tetloom::layers
