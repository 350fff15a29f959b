#include "mesher/intersection/model_crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <optional>
#include <utility>

#include "tetloom/error.hpp"

namespace tetloom {
namespace {

constexpr std::size_t kMostTries = 4;  // for each two faces

/// A face, to be asked where points of its surface lie.
class FaceExtent {
 public:
  FaceExtent(const GeometricModel& model, ModelFaceId id)
      : model_(model), loops_(model.topology().face_to_loops[id.value]), geometry_(model.face_geometry(id)) {}

  bool has_plane() const { return geometry_->parametrization() == Parametrization::Smooth; }
  FaceGeometry& geometry() { return *geometry_; }

  /// Whether a point of the surface lies inside the face, farther from all its edges than `margin` and than these can
  /// be told apart from their chords.
  bool holds(const SurfacePoint& place, double margin) {
    if (rim_.empty()) trace();
    bool is_inside = false;
    for (const RimPiece& piece : rim_) {
      const auto& [a, b] = piece.uv;
      if ((a.v > place.uv.v) != (b.v > place.uv.v) && place.uv.u < a.u + (place.uv.v - a.v) / (b.v - a.v) * (b.u - a.u))
        is_inside = !is_inside;
    }
    return is_inside && is_clear(place.point, margin);
  }

 private:
  struct RimPiece {
    std::array<Vec2, 2> uv;
  };
  struct Edge {
    std::unique_ptr<EdgeGeometry> geometry;
    double margin;
  };

  void trace() {
    for (const ModelLoop& loop : loops_)
      for (const EdgeUse& use : loop) add(use);
  }

  void add(const EdgeUse& use) {
    constexpr int kPieces = 64;
    const bool is_pole = model_.topology().edges[use.edge.value].degenerate;
    Edge edge{is_pole ? nullptr : model_.edge_geometry(use.edge), 0};
    const ParameterRange range = geometry_->edge_range(use);
    const auto at = [&](double i) { return range.lo + (range.hi - range.lo) * i / kPieces; };
    for (int i = 0; i < kPieces; ++i) {
      rim_.push_back({{geometry_->edge_parameters(use, at(i)), geometry_->edge_parameters(use, at(i + 1))}});
      if (is_pole) continue;
      const Vec3 chord = 0.5 * (edge.geometry->evaluate(at(i)) + edge.geometry->evaluate(at(i + 1)));
      edge.margin = std::max(edge.margin, distance(chord, edge.geometry->evaluate(at(i + 0.5))));
    }
    constexpr double kSags = 4;  // of the longest piece, which may be uneven
    edge.margin = std::max(kSags * edge.margin, model_.attributes(use.edge).tolerance);
    if (!is_pole) edges_.push_back(std::move(edge));
  }

  bool is_clear(const Vec3& x, double margin) const {
    return std::ranges::all_of(edges_, [&](const Edge& edge) {
      return edge.geometry->closest_point(x).distance > std::max(margin, edge.margin);
    });
  }

  const GeometricModel& model_;
  const std::vector<ModelLoop>& loops_;
  std::unique_ptr<FaceGeometry> geometry_;
  std::vector<RimPiece> rim_;
  std::vector<Edge> edges_;
};

/// A point of two surfaces, and where it lies on each.
struct CommonPoint {
  SurfacePoint first, second;
};

/// The common point of the tangent planes at the nearest points, again and again: Newton's method, where the surfaces
/// make an angle. None where it leaves the ball around `start`.
std::optional<CommonPoint> find_common_point(FaceGeometry& first, FaceGeometry& second, const Vec3& start,
                                             double radius) {
  constexpr int kMostSteps = 12;
  constexpr double kNear = 1e-6, kLeastSine = 0.05;
  Vec3 x = start;
  std::optional<Vec2> guess_a, guess_b;
  for (int step = 0; step < kMostSteps && distance(x, start) <= radius; ++step) {
    const SurfacePoint a = first.closest_point(x, guess_a), b = second.closest_point(x, guess_b);
    guess_a = a.uv, guess_b = b.uv;
    const Vec3 m = first.normal(a.uv), n = second.normal(b.uv), along = cross(m, n);
    const double sine2 = norm2(along);
    if (sine2 < kLeastSine * kLeastSine) return {};
    if (std::max(a.distance, b.distance) <= kNear * radius) return CommonPoint{a, b};
    const double to_a = dot(m, a.point - x), to_b = dot(n, b.point - x);
    x = x + (to_a * cross(n, along) + to_b * cross(along, m)) / sine2;
  }
  return {};
}

bool share_region(const FaceSides& a, const FaceSides& b) {
  return (a.front.valid() && (a.front == b.front || a.front == b.back)) ||
         (a.back.valid() && (a.back == b.front || a.back == b.back));
}

/// The crossings of two faces.
struct FacePair {
  ModelFaceId first, second;
  std::vector<TriangleIntersection> crossings;
};

/// The facets of faces that reach into a ball's box; points in one place are one.
class NearFacets {
 public:
  NearFacets(const Vec3& center, double radius) {
    const Vec3 reach{radius, radius, radius};
    box_.add(center - reach), box_.add(center + reach);
  }
  void add(const Tessellation& facets) {
    for (const auto& verts : facets.tri_to_vert) {
      Box3 around;
      for (const std::uint32_t v : verts) around.add(facets.points[v]);
      if (!around.overlaps(box_)) continue;
      auto& added = tris_.emplace_back();
      for (std::size_t i = 0; i < 3; ++i) added[i] = number_of(facets.points[verts[i]]);
    }
  }
  std::optional<Vec3> find_crossing() const {
    IntersectionSearch search{points_, tris_};
    for (const TriangleIntersection& found : find_self_intersections(search, TaskRunner(1)))
      if (found.kind == IntersectionKind::Crossing) return found.point;
    return {};
  }

 private:
  std::uint32_t number_of(const Vec3& p) {
    const auto [at, is_new] = known_.try_emplace({p.x, p.y, p.z}, static_cast<std::uint32_t>(points_.size()));
    if (is_new) points_.push_back(p);
    return at->second;
  }

  Box3 box_;
  std::map<std::array<double, 3>, std::uint32_t> known_;
  std::vector<Vec3> points_;
  std::vector<std::array<std::uint32_t, 3>> tris_;
};

// Facets are the surface itself: where they cross beside crossing triangles, the model does. A face may cross itself.
std::optional<TriangleIntersection> find_crossing_of_facets(const FacePair& pair, FaceExtent& first, FaceExtent& second,
                                                            const Mesh& surface) {
  std::vector<Tessellation> faces{first.geometry().tessellate(0, 0)};
  if (pair.first != pair.second) faces.push_back(second.geometry().tessellate(0, 0));
  for (TriangleIntersection crossing : pair.crossings) {
    NearFacets facets(crossing.point, longest_edge(surface, crossing));
    for (const Tessellation& face : faces) facets.add(face);
    if (const std::optional<Vec3> point = facets.find_crossing()) {
      crossing.point = *point;
      return crossing;
    }
  }
  return {};
}

std::optional<TriangleIntersection> find_crossing(const FacePair& pair, const Mesh& surface,
                                                  const GeometricModel& model) {
  constexpr double kLeastDepth = 1e-3;  // of the triangles' edges
  FaceExtent first(model, pair.first), second(model, pair.second);
  if (!first.has_plane() && !second.has_plane()) return find_crossing_of_facets(pair, first, second, surface);
  if (!first.has_plane() || !second.has_plane() || pair.first == pair.second) return {};
  for (TriangleIntersection crossing : pair.crossings) {
    const double length = longest_edge(surface, crossing);
    const auto common = find_common_point(first.geometry(), second.geometry(), crossing.point, length);
    if (!common || !first.holds(common->first, kLeastDepth * length) ||
        !second.holds(common->second, kLeastDepth * length))
      continue;
    crossing.point = common->first.point;
    return crossing;
  }
  return {};
}

std::vector<FacePair> group_by_faces(std::span<const TriangleIntersection> crossings, const Mesh& surface,
                                     const GeometricModel& model) {
  const std::vector<FaceSides>& sides = model.topology().face_to_sides;
  std::vector<FacePair> pairs;
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known;
  for (const TriangleIntersection& crossing : crossings) {
    const std::uint32_t a = surface.tri_to_entity[crossing.first], b = surface.tri_to_entity[crossing.second];
    if (crossing.kind != IntersectionKind::Crossing || !share_region(sides[a], sides[b])) continue;
    const auto [at, is_new] = known.try_emplace(std::minmax(a, b), pairs.size());
    if (is_new) pairs.push_back({ModelFaceId(a), ModelFaceId(b), {}});
    if (pairs[at->second].crossings.size() < kMostTries) pairs[at->second].crossings.push_back(crossing);
  }
  return pairs;
}

}  // namespace

std::vector<TriangleIntersection> find_model_crossings(std::span<const TriangleIntersection> crossings,
                                                       const Mesh& surface, const GeometricModel& model,
                                                       const TaskRunner& runner) {
  const std::vector<FacePair> pairs = group_by_faces(crossings, surface, model);
  std::vector<std::optional<TriangleIntersection>> found(pairs.size());
  runner.for_each(pairs.size(), [&](std::size_t i) {
    try {
      found[i] = find_crossing(pairs[i], surface, model);
    } catch (const Error& error) {  // a face that refuses to answer is judged by its triangles alone
      if (error.code() == ErrorCode::Cancelled || error.code() == ErrorCode::OutOfMemory) throw;
    }
  });
  std::vector<TriangleIntersection> result;
  for (const auto& crossing : found)
    if (crossing) result.push_back(*crossing);
  return result;
}

}  // namespace tetloom
