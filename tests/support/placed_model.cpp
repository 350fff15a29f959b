#include "tests/support/placed_model.hpp"

#include <cmath>
#include <utility>

namespace tetloom::test_models {
namespace {

class MovedEdge final : public EdgeGeometry {
 public:
  MovedEdge(std::unique_ptr<EdgeGeometry> edge, const RigidMotion& motion) : edge_(std::move(edge)), motion_(motion) {}
  ParameterRange range() override { return edge_->range(); }
  double period() override { return edge_->period(); }
  Vec3 evaluate(double t) override { return motion_(edge_->evaluate(t)); }
  Vec3 derivative(double t) override { return motion_.turned(edge_->derivative(t)); }
  double curvature(double t) override { return edge_->curvature(t); }
  CurvePoint closest_point(const Vec3& x) override {
    CurvePoint found = edge_->closest_point(motion_.inverse()(x));
    found.point = motion_(found.point);
    return found;
  }

 private:
  std::unique_ptr<EdgeGeometry> edge_;
  RigidMotion motion_;
};

class MovedFace final : public FaceGeometry {
 public:
  struct Numbers {
    std::size_t vertices, edges, faces;  // those before the place
  };
  MovedFace(std::unique_ptr<FaceGeometry> face, const RigidMotion& motion, Numbers before)
      : face_(std::move(face)), motion_(motion), before_(before) {}
  Parametrization parametrization() override { return face_->parametrization(); }
  ParameterBox parameter_box() override { return face_->parameter_box(); }
  Vec2 period() override { return face_->period(); }
  Vec3 evaluate(const Vec2& uv) override { return motion_(face_->evaluate(uv)); }
  SurfaceDerivatives derivatives(const Vec2& uv) override {
    const SurfaceDerivatives found = face_->derivatives(uv);
    return {motion_(found.point), motion_.turned(found.du), motion_.turned(found.dv)};
  }
  Vec3 normal(const Vec2& uv) override { return motion_.turned(face_->normal(uv)); }
  PrincipalCurvatures curvature(const Vec2& uv) override { return face_->curvature(uv); }
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) override {
    SurfacePoint found = face_->closest_point(motion_.inverse()(x), guess);
    found.point = motion_(found.point);
    return found;
  }
  Vec2 edge_parameters(const EdgeUse& use, double t) override { return face_->edge_parameters(own(use), t); }
  ParameterRange edge_range(const EdgeUse& use) override { return face_->edge_range(own(use)); }
  Tessellation tessellate(double chord, double angle) override {
    Tessellation facets = face_->tessellate(chord, angle);
    for (Vec3& p : facets.points) p = motion_(p);
    for (ModelEntity& entity : facets.classification)
      entity.index += static_cast<std::uint32_t>(entity.dim == 0   ? before_.vertices
                                                 : entity.dim == 1 ? before_.edges
                                                                   : before_.faces);
    return facets;
  }

 private:
  EdgeUse own(EdgeUse use) const {
    use.edge = ModelEdgeId(use.edge.value - before_.edges);
    return use;
  }
  std::unique_ptr<FaceGeometry> face_;
  RigidMotion motion_;
  Numbers before_;
};

class PlacedModel final : public GeometricModel {
 public:
  PlacedModel(std::shared_ptr<const GeometricModel> body, std::vector<RigidMotion> places)
      : body_(std::move(body)), places_(std::move(places)) {
    for (std::size_t i = 0; i < places_.size(); ++i) add_place(i);
    for (int dim = 0; dim < 4; ++dim) attributes_[static_cast<std::size_t>(dim)].resize(topology_.count(dim));
  }

  Vec3 vertex_point(ModelVertexId id) const override {
    return motion(id, given().vertex_count)(body_->vertex_point(own(id, given().vertex_count)));
  }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override {
    return std::make_unique<MovedEdge>(body_->edge_geometry(own(id, given().edge_count())),
                                       motion(id, given().edge_count()));
  }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override {
    const std::size_t place = id.value / given().face_count();
    return std::make_unique<MovedFace>(
        body_->face_geometry(own(id, given().face_count())), places_[place],
        MovedFace::Numbers{place * given().vertex_count, place * given().edge_count(), place * given().face_count()});
  }
  double area(ModelFaceId id) const override { return body_->area(own(id, given().face_count())); }
  FacePlace place(ModelFaceId id) const override {
    return {own(id, given().face_count()).value, motion(id, given().face_count())};
  }
  double volume(ModelRegionId id) const override { return body_->volume(own(id, given().region_count())); }

 private:
  const ModelTopology& given() const { return body_->topology(); }

  template <class Kind>
  static Id<Kind> own(Id<Kind> id, std::size_t count) {
    return Id<Kind>(id.value % count);
  }
  template <class Kind>
  const RigidMotion& motion(Id<Kind> id, std::size_t count) const {
    return places_[id.value / count];
  }

  void add_place(std::size_t i) {
    const std::size_t vertices = i * given().vertex_count, edges = i * given().edge_count(),
                      faces = i * given().face_count(), regions = i * given().region_count();
    topology_.vertex_count += given().vertex_count;
    for (ModelEdgeTopology edge : given().edges) {
      for (ModelVertexId& v : edge.vertices) v = ModelVertexId(v.value + vertices);
      topology_.edges.push_back(edge);
    }
    for (std::vector<ModelLoop> loops : given().face_to_loops) {
      for (ModelLoop& loop : loops)
        for (EdgeUse& use : loop) use.edge = ModelEdgeId(use.edge.value + edges);
      topology_.face_to_loops.push_back(std::move(loops));
    }
    for (FaceSides sides : given().face_to_sides) {
      for (ModelRegionId* region : {&sides.front, &sides.back})
        if (region->valid()) *region = ModelRegionId(region->value + regions);
      topology_.face_to_sides.push_back(sides);
    }
    for (std::vector<ModelFaceId> boundary : given().region_to_faces) {
      for (ModelFaceId& face : boundary) face = ModelFaceId(face.value + faces);
      topology_.region_to_faces.push_back(std::move(boundary));
    }
    const Box3& box = body_->bounding_box();
    for (int corner = 0; corner < 8; ++corner)
      bounding_box_.add(places_[i](
          {corner & 1 ? box.hi.x : box.lo.x, corner & 2 ? box.hi.y : box.lo.y, corner & 4 ? box.hi.z : box.lo.z}));
  }

  std::shared_ptr<const GeometricModel> body_;
  std::vector<RigidMotion> places_;
};

}  // namespace

std::unique_ptr<GeometricModel> place_body(std::shared_ptr<const GeometricModel> body,
                                           std::vector<RigidMotion> places) {
  return std::make_unique<PlacedModel>(std::move(body), std::move(places));
}

// Rodrigues' formula.
RigidMotion turn_about(const Vec3& axis, double angle, const Vec3& shift) {
  const Vec3 k = normalized(axis);
  const auto turned = [&](const Vec3& a) {
    return std::cos(angle) * a + std::sin(angle) * cross(k, a) + (1 - std::cos(angle)) * dot(k, a) * k;
  };
  return {{turned({1, 0, 0}), turned({0, 1, 0}), turned({0, 0, 1})}, shift};
}

}  // namespace tetloom::test_models
