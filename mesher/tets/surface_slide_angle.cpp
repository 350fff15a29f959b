// The pattern search of surface_slide.hpp.
#include <algorithm>
#include <numbers>

#include "mesher/tets/angle_search.hpp"
#include "mesher/tets/surface_slide.hpp"

namespace tetloom::tets {

namespace {

constexpr int kDirections = 12;           // in a model face
constexpr double kAngleSlideFloor = 0.6;  // mean ratio that triangles may fall to
constexpr int kAngleSlideTries = 3;

}  // namespace

double SurfaceSlider::squared_edges(const Vec3& x) const {
  double sum = 0;
  for (const FanTriangle& t : fan_) sum += norm2(x - mesh_.point(t.a));
  return sum;
}

// The step of the pattern after which the smallest angle is largest; zero where none is worth it.
Vec3 SurfaceSlider::widest_step(const Vec3& direction, double goal, double growth) {
  const Vec3 x = mesh_.point(star_.vertex);
  std::vector<Vec3> directions{direction, -direction};
  if (entity_.dim == 2) {
    const Vec3 axis = std::abs(direction.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
    const Vec3 e = normalized(cross(direction, axis)), f = cross(direction, e);
    directions.clear();
    for (int i = 0; i < kDirections; ++i) {
      const double turn = 2 * std::numbers::pi * i / kDirections;
      directions.push_back(std::cos(turn) * e + std::sin(turn) * f);
    }
  }
  const double most = growth * squared_edges(x);
  return find_widest_step(mesh_, star_, directions, reach_, goal, [&](const Vec3& step) {
    return squared_edges(x + step) <= most &&
           std::ranges::all_of(std::span(tets_).first(star_.count),
                               [&](const StarTet& tet) { return tet.is_surely_positive_at(step); });
  });
}

SlideVerdict SurfaceSlider::slide_for_angle(std::uint32_t tet, std::uint32_t corner, double least, double growth) {
  if (const SlideVerdict verdict = collect(tet, corner); verdict != SlideVerdict::Moved) return verdict;
  const Vec3 x = mesh_.point(star_.vertex);
  const double goal = cosine_to_beat(mesh_, star_);
  least = std::max(least, kAngleQualityShare * worth_at({}).least);
  Vec3 step = widest_step(direction(), goal, growth);
  if (step == Vec3{}) return SlideVerdict::NoGain;
  SlideVerdict verdict = SlideVerdict::NoGain;
  for (int i = 0; i < kAngleSlideTries; ++i, step *= 0.5) {
    const std::optional<SurfaceSpot> spot = surface_.project(entity_, x + step);
    const bool found = spot && distance(spot->point, x + step) <= kFarthest * norm(step);
    if (found && (worth_at(spot->point - x).least < least || largest_cosine(mesh_, star_, spot->point, goal) >= goal))
      continue;
    if (found && keeps_shape(x, spot->point, kAngleSlideFloor) && is_clear_at(spot->point)) {
      apply(spot->point);
      return SlideVerdict::Moved;
    }
    verdict = std::max(verdict, found ? SlideVerdict::Folds : SlideVerdict::OffModel);
  }
  return verdict;
}

}  // namespace tetloom::tets
