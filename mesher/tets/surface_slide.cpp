#include "mesher/tets/surface_slide.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/spatial/triangle_shape.hpp"

namespace tetloom::tets {

namespace {

constexpr double kSlideFloor = 0.85;  // mean ratio that triangles may fall to
constexpr double kLongestStep = 0.5;  // in lengths of the edges beside the vertex
constexpr int kSlideTries = 4;

// A right-handed frame with `normal` as its third axis.
std::array<Vec3, 2> tangents(const Vec3& normal) {
  const Vec3 axis = std::abs(normal.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 first = normalized(cross(normal, axis));
  return {first, cross(normal, first)};
}

}  // namespace

StarVerdict find_surface_star(const WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, VertexStar& star) {
  const TetMesh& m = mesh.mesh();
  star.vertex = mesh.verts(tet)[corner];
  star.count = 1;
  star.codes[0] = {tet, corner};
  for (std::size_t i = 0; i < star.count; ++i) {
    const std::uint32_t here = star.codes[i].tet();
    for (std::uint32_t face = 0; face < 4; ++face) {
      const FaceCode behind = m.behind({here, face});
      if (face == star.codes[i].side() || !behind.valid()) continue;
      const auto found = star.tets();
      if (std::ranges::any_of(found, [&](FaceCode code) { return code.tet() == behind.tet(); })) continue;
      if (star.count == WorkingMesh::kMostTets) return StarVerdict::TooLarge;
      star.codes[star.count++] = {behind.tet(), mesh.corner_of(behind.tet(), star.vertex)};
    }
  }
  return StarVerdict::Found;
}

// The triangles at the vertex; false when they do not belong to its model face.
bool SurfaceSlider::collect_fan(std::uint32_t vertex) {
  fan_.clear(), fan_ids_.clear(), fan_verts_.clear();
  bool belong = true;
  double sum = 0;
  triangles_.for_each_at(vertex, [&](std::uint32_t triangle) {
    const TriangleVerts& v = triangles_.verts(triangle);
    const std::size_t own = v[0] == vertex ? 0 : v[1] == vertex ? 1 : 2;
    fan_.push_back({v[(own + 1) % 3], v[(own + 2) % 3], surface_.tri_to_face[triangle]});
    fan_ids_.push_back(triangle), fan_verts_.push_back(v);
    belong = belong && (entity_.dim == 1 || fan_.back().face == entity_.index);
    sum += distance(mesh_.point(fan_.back().a), mesh_.point(vertex));
  });
  reach_ = sum / static_cast<double>(fan_.size());
  return belong && fan_.size() >= 3;
}

// The two neighbours along the model edge; false when there are more or fewer.
bool SurfaceSlider::collect_kept(std::uint32_t vertex) {
  kept_.clear();
  if (entity_.dim == 2) return true;
  reach_ = std::numeric_limits<double>::infinity();
  for (const FanTriangle& triangle : fan_) {
    for (const std::uint32_t v : {triangle.a, triangle.b}) {
      if (std::ranges::find(kept_, v) != kept_.end() || !surface_.is_kept || !surface_.is_kept(vertex, v)) continue;
      kept_.push_back(v);
      reach_ = std::min(reach_, distance(mesh_.point(v), mesh_.point(vertex)));
    }
  }
  return kept_.size() == 2;
}

void SurfaceSlider::measure() {
  const Vec3 x = mesh_.point(star_.vertex);
  for (std::size_t i = 0; i < star_.count; ++i) {
    const auto verts = mesh_.verts(star_.codes[i].tet());
    const auto& [a, c, b] = kFaceVerts[star_.codes[i].side()];
    tets_[i] = star_tet(mesh_.point(verts[a]) - x, mesh_.point(verts[b]) - x, mesh_.point(verts[c]) - x);
  }
}

bool SurfaceSlider::Worth::beats(const Worth& other) const {
  if (poor > other.poor) return false;
  return least > other.least * kGain || (least >= other.least && sum < other.sum / kGain);
}

SurfaceSlider::Worth SurfaceSlider::worth_at(const Vec3& d) const {
  Worth worth{0, 1};
  for (const StarTet& tet : std::span(tets_).first(star_.count)) {
    if (!tet.is_surely_positive_at(d)) return {std::numeric_limits<double>::infinity(), 0, WorkingMesh::kMostTets};
    const double quality = cubed_quality(tet.volume_at(d), tet.squares_at(d));
    worth.sum += 1 / quality;
    worth.least = std::min(worth.least, quality);
    worth.poor += quality < limit_;
  }
  return worth;
}

// Minus the gradient over the Hessian of the sum of s^3 / v^2, where ds = -2 middle, d2s = 6 and dv = normal.
Vec3 SurfaceSlider::step_along(const Vec3& tangent) const {
  double g = 0, h = 0;
  for (const StarTet& tet : std::span(tets_).first(star_.count)) {
    const double i = 1 / tet.volume, r = tet.squares * i, r2 = r * r, r3 = r2 * r;
    const double m = dot(tet.middle, tangent), n = dot(tet.normal, tangent);
    g += -6 * r2 * m - 2 * r3 * n;
    h += 18 * r2 + 24 * r * i * m * m + 24 * r2 * i * m * n + 6 * r3 * i * n * n;
  }
  return -g / h * tangent;
}

// The same along two tangents.
Vec3 SurfaceSlider::step_across(const Vec3& normal) const {
  const auto [e, f] = tangents(normal);
  double g1 = 0, g2 = 0, h11 = 0, h12 = 0, h22 = 0;
  for (const StarTet& tet : std::span(tets_).first(star_.count)) {
    const double i = 1 / tet.volume, r = tet.squares * i, r2 = r * r, r3 = r2 * r;
    const Vec2 m{dot(tet.middle, e), dot(tet.middle, f)}, n{dot(tet.normal, e), dot(tet.normal, f)};
    g1 += -6 * r2 * m.u - 2 * r3 * n.u;
    g2 += -6 * r2 * m.v - 2 * r3 * n.v;
    const double mm = 24 * r * i, mn = 12 * r2 * i, nn = 6 * r3 * i;
    h11 += 18 * r2 + mm * m.u * m.u + 2 * mn * m.u * n.u + nn * n.u * n.u;
    h22 += 18 * r2 + mm * m.v * m.v + 2 * mn * m.v * n.v + nn * n.v * n.v;
    h12 += mm * m.u * m.v + mn * (m.u * n.v + m.v * n.u) + nn * n.u * n.v;
  }
  const double determinant = h11 * h22 - h12 * h12;
  return (h12 * g2 - h22 * g1) / determinant * e + (h12 * g1 - h11 * g2) / determinant * f;
}

// The normal of the triangles, or the direction from one neighbour along the model edge to the other.
Vec3 SurfaceSlider::direction() const {
  if (entity_.dim == 1) return normalized(mesh_.point(kept_[1]) - mesh_.point(kept_[0]));
  const Vec3& x = mesh_.point(star_.vertex);
  Vec3 sum;
  for (const FanTriangle& t : fan_) sum += cross(mesh_.point(t.a) - x, mesh_.point(t.b) - x);
  return normalized(sum);
}

Vec3 SurfaceSlider::newton_step(const Vec3& direction) const {
  const Vec3 step = entity_.dim == 2 ? step_across(direction) : step_along(direction);
  const double length = norm(step), longest = kLongestStep * reach_;
  if (!is_finite(step) || length == 0) return {};
  return std::min(1.0, longest / length) * step;
}

double SurfaceSlider::poorest_triangle(const Vec3& x) const {
  double least = 1;
  for (const FanTriangle& t : fan_) least = std::min(least, triangle_mean_ratio(x, mesh_.point(t.a), mesh_.point(t.b)));
  return least;
}

// Between the triangles and the model's normals where the vertex is; -1 where the model gives no answer.
double SurfaceSlider::least_cosine(const Vec3& x) const {
  double least = 1;
  std::uint32_t face = kNone;
  std::optional<SurfaceSpot> spot;
  for (const auto& [a, b, own_face] : fan_) {
    if (own_face != face) face = own_face, spot = surface_.project(ModelFaceId(face), x);
    if (!spot) return -1;
    least = std::min(least, dot(triangle_normal(x, mesh_.point(a), mesh_.point(b)), spot->direction));
  }
  return least;
}

// Of the longer piece of the model edge, in its lengths.
double SurfaceSlider::sag(const Vec3& x) const {
  const Vec3 &p = mesh_.point(kept_[0]), &q = mesh_.point(kept_[1]);
  const Vec3& end = distance(p, x) > distance(q, x) ? p : q;
  const Vec3 middle = 0.5 * (x + end);
  const std::optional<SurfaceSpot> spot = surface_.project(entity_, middle);
  return spot ? distance(spot->point, middle) / distance(x, end) : 1;
}

// What is as true to the model as any is true enough; what is not may not get worse.
bool SurfaceSlider::keeps_shape(const Vec3& from, const Vec3& to, double triangle_floor) const {
  if (poorest_triangle(to) < std::min(triangle_floor, poorest_triangle(from))) return false;
  const double cosine = least_cosine(to);
  if (!(cosine > 0) || (cosine < kLeastCosine && cosine < least_cosine(from))) return false;
  if (kept_.empty()) return true;
  const double after = sag(to);
  return after <= kLargestSag || after <= sag(from);
}

bool SurfaceSlider::is_clear_at(const Vec3& to) {
  if (!surface_.is_clear) return true;
  Vec3& x = mesh_.mesh().points[star_.vertex];
  const Vec3 from = std::exchange(x, to);
  const bool clear =
      surface_.is_clear({mesh_.mesh().points.span().first(surface_.point_to_entity.size()), fan_ids_, fan_verts_});
  x = from;
  return clear;
}

// The model is asked only where a step on the mesh alone promises something.
SlideVerdict SurfaceSlider::search() {
  const Vec3 x = mesh_.point(star_.vertex);
  const Worth before = worth_at({});
  Vec3 step = newton_step(direction());
  if (step == Vec3{}) return SlideVerdict::NoGain;
  SlideVerdict verdict = SlideVerdict::NoGain;
  for (int i = 0; i < kSlideTries; ++i, step *= 0.5) {
    if (!worth_at(step).beats(before)) continue;
    const std::optional<SurfaceSpot> spot = surface_.project(entity_, x + step);
    const bool found = spot && distance(spot->point, x + step) <= kFarthest * norm(step);
    if (found && !worth_at(spot->point - x).beats(before)) continue;
    if (found && keeps_shape(x, spot->point, kSlideFloor) && is_clear_at(spot->point)) {
      apply(spot->point);
      return SlideVerdict::Moved;
    }
    verdict = std::max(verdict, found ? SlideVerdict::Folds : SlideVerdict::OffModel);
  }
  return verdict;
}

void SurfaceSlider::apply(const Vec3& to) {
  Vec3& x = mesh_.mesh().points[star_.vertex];
  const Vec3 step = to - x;
  x = to;
  for (std::size_t i = 0; i < star_.count; ++i)
    mesh_.set_quality(star_.codes[i].tet(), cubed_quality(tets_[i].volume_at(step), tets_[i].squares_at(step)));
}

SlideVerdict SurfaceSlider::collect(std::uint32_t tet, std::uint32_t corner) {
  const std::uint32_t vertex = mesh_.verts(tet)[corner];
  if (vertex >= surface_.point_to_entity.size() || !surface_.project) return SlideVerdict::Stays;
  entity_ = surface_.point_to_entity[vertex];
  if (!entity_.valid() || entity_.dim < 1 || entity_.dim > 2) return SlideVerdict::Stays;
  if (!collect_fan(vertex) || !collect_kept(vertex)) return SlideVerdict::Stays;
  if (find_surface_star(mesh_, tet, corner, star_) != StarVerdict::Found) return SlideVerdict::TooLarge;
  measure();
  return SlideVerdict::Moved;
}

SlideVerdict SurfaceSlider::slide(std::uint32_t tet, std::uint32_t corner) {
  const SlideVerdict verdict = collect(tet, corner);
  return verdict == SlideVerdict::Moved ? search() : verdict;
}

}  // namespace tetloom::tets
