#include "core/geometry/model_projector.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>

#include "tetloom/error.hpp"

namespace tetloom {

namespace {

std::optional<SurfaceSpot> checked(const SurfaceSpot& spot) {
  if (!is_finite(spot.point) || !is_finite(spot.direction) || spot.direction == Vec3{}) return std::nullopt;
  return spot;
}

// Tells whether a place that was found from a guess may be taken for the nearest one. What lies a good part of the way
// to the guess away may be on another turn of a thread, or on the other side of a wall; so may what lies farther away
// than all that whole searches have found.
class Trust {
 public:
  bool in(double distance, double from_guess) const {
    constexpr double kPart = 0.1, kOn = 1e-6;  // of the way to the guess
    return distance <= kOn * from_guess || (distance <= kPart * from_guess && distance <= 2 * farthest_);
  }
  void note(double distance) { farthest_ = std::max(farthest_, distance); }

 private:
  double farthest_ = 0;
};

// What was asked last is likely to be near, so that it serves as the guess.
class FaceProjector {
 public:
  explicit FaceProjector(std::unique_ptr<FaceGeometry> face) : face_(std::move(face)) {}

  std::optional<SurfaceSpot> project(const Vec3& x) {
    const SurfacePoint found = find(x);
    known_[next_] = {found.point, found.uv};
    next_ = (next_ + 1) % known_.size();
    return checked({found.point, face_->normal(found.uv)});
  }

 private:
  struct Known {
    Vec3 point{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    Vec2 uv;
  };

  // Of facets, those that face away from a guess would be left out, however near they are.
  SurfacePoint find(const Vec3& x) {
    if (face_->parametrization() == Parametrization::Piecewise) return face_->closest_point(x, std::nullopt);
    const Known* nearest = &known_[0];
    for (const Known& known : known_) {
      if (norm2(known.point - x) < norm2(nearest->point - x)) nearest = &known;
    }
    const double away = distance(nearest->point, x);
    if (is_finite(nearest->point)) {
      const SurfacePoint found = face_->closest_point(x, nearest->uv);
      if (trust_.in(found.distance, away)) return found;
    }
    const SurfacePoint found = face_->closest_point(x, std::nullopt);
    trust_.note(found.distance);
    return found;
  }

  std::unique_ptr<FaceGeometry> face_;
  Trust trust_;
  std::array<Known, 8> known_;
  std::size_t next_ = 0;
};

// Starts from the nearest place found lately, and searches all of the edge where that does not lead there.
class EdgeProjector {
 public:
  explicit EdgeProjector(std::unique_ptr<EdgeGeometry> edge) : edge_(std::move(edge)), range_(edge_->range()) {}

  std::optional<SurfaceSpot> project(const Vec3& x) {
    const double t = find(x);
    const Vec3 point = edge_->evaluate(t);
    known_[next_] = {point, t};
    next_ = (next_ + 1) % known_.size();
    return checked({point, normalized(edge_->derivative(t))});
  }

 private:
  struct Known {
    Vec3 point{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    double t = 0;
  };

  double find(const Vec3& x) {
    const Known* nearest = &known_[0];
    for (const Known& known : known_) {
      if (norm2(known.point - x) < norm2(nearest->point - x)) nearest = &known;
    }
    if (is_finite(nearest->point)) {
      if (const std::optional<double> t = descend(x, *nearest)) return *t;
    }
    const CurvePoint found = edge_->closest_point(x);
    trust_.note(found.distance);
    return found.t;
  }

  // Gauss-Newton: converges fast near the edge.
  std::optional<double> descend(const Vec3& x, const Known& start) {
    constexpr int kIterations = 6;
    constexpr double kPrecision = 1e-9;  // of the way from the start
    const double away = distance(x, start.point);
    double t = start.t;
    for (int i = 0; i < kIterations; ++i) {
      const Vec3 tangent = edge_->derivative(t), offset = x - edge_->evaluate(t);
      const double step = dot(offset, tangent) / norm2(tangent);
      t += step;
      if (!(t >= range_.lo && t <= range_.hi)) return std::nullopt;
      if (std::abs(step) * norm(tangent) > kPrecision * away) continue;
      return trust_.in(norm(offset), away) ? std::optional(t) : std::nullopt;
    }
    return std::nullopt;
  }

  std::unique_ptr<EdgeGeometry> edge_;
  ParameterRange range_;
  Trust trust_;
  std::array<Known, 8> known_;
  std::size_t next_ = 0;
};

class ModelProjector {
 public:
  explicit ModelProjector(const GeometricModel& model) : model_(model) {}

  std::optional<SurfaceSpot> project(ModelEntity entity, const Vec3& x) {
    try {
      return entity.dim == 2 ? face(entity.index).project(x) : edge(entity.index).project(x);
    } catch (const Error& error) {
      if (error.code() == ErrorCode::Cancelled || error.code() == ErrorCode::OutOfMemory) throw;
      return std::nullopt;
    }
  }

 private:
  FaceProjector& face(std::uint32_t index) {
    const auto found = faces_.find(index);
    if (found != faces_.end()) return found->second;
    return faces_.emplace(index, model_.face_geometry(ModelFaceId(index))).first->second;
  }
  EdgeProjector& edge(std::uint32_t index) {
    const auto found = edges_.find(index);
    if (found != edges_.end()) return found->second;
    return edges_.emplace(index, model_.edge_geometry(ModelEdgeId(index))).first->second;
  }

  const GeometricModel& model_;
  std::map<std::uint32_t, FaceProjector> faces_;
  std::map<std::uint32_t, EdgeProjector> edges_;
};

}  // namespace

SurfaceProjector make_projector(const GeometricModel& model) {
  const auto projector = std::make_shared<ModelProjector>(model);
  return [projector](ModelEntity entity, const Vec3& x) { return projector->project(entity, x); };
}

}  // namespace tetloom
