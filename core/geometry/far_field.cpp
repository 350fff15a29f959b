#include "tetloom/model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "core/geometry/box_geometry.hpp"
#include "core/geometry/outside_shells.hpp"

namespace tetloom {
namespace {

constexpr double kLeastSide = 0.1;  // of the longest side of the box around the model

class FarFieldModel : public GeometricModel {
 public:
  FarFieldModel(std::shared_ptr<const GeometricModel> model, const Box3& box) : model_(std::move(model)) {
    const OutsideShells outside(*model_);
    bounding_box_ = box;
    metres_per_unit_ = model_->metres_per_unit();
    const Vec3 extent = box.hi - box.lo;
    volume_ = extent.x * extent.y * extent.z - outside.enclosed_volume();
    number(outside);
    add_given();
    add_box();
    topology_.region_to_faces.resize(1);
    for (std::size_t f = 0; f < topology_.face_count(); ++f) topology_.region_to_faces[0].push_back(ModelFaceId(f));
    attributes_[3].emplace_back().name = "far_field";
  }

  Vec3 vertex_point(ModelVertexId id) const override {
    return id.value < vertices_.size() ? model_->vertex_point(ModelVertexId(vertices_[id.value]))
                                       : corner_of(bounding_box_, static_cast<int>(id.value - vertices_.size()));
  }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override {
    if (id.value < edges_.size()) return model_->edge_geometry(ModelEdgeId(edges_[id.value]));
    return edge_geometry_of(bounding_box_, static_cast<int>(id.value - edges_.size()));
  }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override;
  double area(ModelFaceId id) const override {
    if (id.value < faces_.size()) return model_->area(ModelFaceId(faces_[id.value]));
    const BoxSide side(static_cast<int>(id.value - faces_.size()));
    const Vec3 extent = bounding_box_.hi - bounding_box_.lo;
    return extent[side.u] * extent[side.v];
  }
  double volume(ModelRegionId) const override { return volume_; }
  std::optional<ShapeMemory> shape_memory() const override { return model_->shape_memory(); }
  std::uint64_t shape_bytes(ModelEntity entity) const override {
    if (entity.dim != 1 && entity.dim != 2) return 0;
    const auto& given = entity.dim == 1 ? edges_ : faces_;
    return entity.index < given.size() ? model_->shape_bytes(ModelEntity(entity.dim, given[entity.index])) : 0;
  }

 private:
  friend class RenumberedFace;

  // What is kept, in the order of the given model.
  void number(const OutsideShells& outside) {
    const ModelTopology& given = model_->topology();
    vertex_to_new_.assign(given.vertex_count, kNone);
    edge_to_new_.assign(given.edge_count(), kNone);
    face_to_new_.assign(given.face_count(), kNone);
    for (std::uint32_t f = 0; f < given.face_count(); ++f) {
      if (!outside.has(f)) continue;
      face_to_new_[f] = static_cast<std::uint32_t>(faces_.size());
      faces_.push_back(f);
      for (const ModelLoop& loop : given.face_to_loops[f])
        for (const EdgeUse& use : loop) {
          edge_to_new_[use.edge.value] = 0;
          for (const ModelVertexId v : given.edges[use.edge.value].vertices)
            if (v.valid()) vertex_to_new_[v.value] = 0;
        }
    }
    const auto list = [](std::vector<std::uint32_t>& to_new, std::vector<std::uint32_t>& kept) {
      for (std::uint32_t i = 0; i < to_new.size(); ++i) {
        if (to_new[i] == kNone) continue;
        to_new[i] = static_cast<std::uint32_t>(kept.size());
        kept.push_back(i);
      }
    };
    list(edge_to_new_, edges_);
    list(vertex_to_new_, vertices_);
  }

  void add_given() {
    const ModelTopology& given = model_->topology();
    const ModelRegionId around(0u);
    topology_.vertex_count = vertices_.size();
    for (const std::uint32_t v : vertices_) attributes_[0].push_back(model_->attributes(ModelVertexId(v)));
    for (const std::uint32_t e : edges_) {
      ModelEdgeTopology edge = given.edges[e];
      for (ModelVertexId& v : edge.vertices)
        if (v.valid()) v = ModelVertexId(vertex_to_new_[v.value]);
      topology_.edges.push_back(edge);
      attributes_[1].push_back(model_->attributes(ModelEdgeId(e)));
    }
    for (const std::uint32_t f : faces_) {
      auto loops = given.face_to_loops[f];
      for (ModelLoop& loop : loops)
        for (EdgeUse& use : loop) use.edge = ModelEdgeId(edge_to_new_[use.edge.value]);
      topology_.face_to_loops.push_back(std::move(loops));
      const FaceSides& sides = given.face_to_sides[f];
      topology_.face_to_sides.push_back(
          {sides.front.valid() ? ModelRegionId() : around, sides.back.valid() ? ModelRegionId() : around});
      attributes_[2].push_back(model_->attributes(ModelFaceId(f)));
    }
  }

  void add_box() {
    for (int edge = 0; edge < kBoxEdges; ++edge) {
      const auto [from, to] = edge_of_box(edge);
      ModelEdgeTopology topology;
      topology.vertices = {ModelVertexId(vertices_.size() + static_cast<std::size_t>(from)),
                           ModelVertexId(vertices_.size() + static_cast<std::size_t>(to))};
      topology_.edges.push_back(topology);
      attributes_[1].emplace_back();
    }
    topology_.vertex_count += kBoxCorners;
    attributes_[0].resize(topology_.vertex_count);
    for (int side = 0; side < kBoxSides; ++side) {
      ModelLoop loop;
      const std::array<int, 4> corners = BoxSide(side).corners();
      for (std::size_t i = 0; i < 4; ++i) loop.push_back(use_between(corners[i], corners[(i + 1) % 4]));
      topology_.face_to_loops.push_back({std::move(loop)});
      topology_.face_to_sides.push_back({ModelRegionId(), ModelRegionId(0u)});
      attributes_[2].emplace_back().name = "far_field_" + std::to_string(side + 1);
    }
  }

  EdgeUse use_between(int from, int to) const {
    for (int edge = 0; edge < kBoxEdges; ++edge) {
      const BoxEdge ends = edge_of_box(edge);
      if (ends.from == from && ends.to == to)
        return {ModelEdgeId(edges_.size() + static_cast<std::size_t>(edge)), true};
      if (ends.from == to && ends.to == from)
        return {ModelEdgeId(edges_.size() + static_cast<std::size_t>(edge)), false};
    }
    return {};
  }

  std::shared_ptr<const GeometricModel> model_;
  double volume_ = 0;
  std::vector<std::uint32_t> vertices_, edges_, faces_;  // of the given model
  std::vector<std::uint32_t> vertex_to_new_, edge_to_new_, face_to_new_;
};

// A face of the given model that is asked, and answers, in the numbers of the one around it.
class RenumberedFace : public FaceGeometry {
 public:
  RenumberedFace(const FarFieldModel& model, std::unique_ptr<FaceGeometry> face)
      : model_(model), face_(std::move(face)) {}

  Parametrization parametrization() override { return face_->parametrization(); }
  ParameterBox parameter_box() override { return face_->parameter_box(); }
  Vec2 period() override { return face_->period(); }
  Vec3 evaluate(const Vec2& uv) override { return face_->evaluate(uv); }
  SurfaceDerivatives derivatives(const Vec2& uv) override { return face_->derivatives(uv); }
  Vec3 normal(const Vec2& uv) override { return face_->normal(uv); }
  PrincipalCurvatures curvature(const Vec2& uv) override { return face_->curvature(uv); }
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) override {
    return face_->closest_point(x, guess);
  }
  Vec2 edge_parameters(const EdgeUse& use, double t) override { return face_->edge_parameters(given(use), t); }
  ParameterRange edge_range(const EdgeUse& use) override { return face_->edge_range(given(use)); }
  Tessellation tessellate(double chord, double angle) override {
    Tessellation facets = face_->tessellate(chord, angle);
    for (ModelEntity& entity : facets.classification) {
      if (entity.dim > 2) continue;
      const auto& to_new = entity.dim == 0   ? model_.vertex_to_new_
                           : entity.dim == 1 ? model_.edge_to_new_
                                             : model_.face_to_new_;
      entity.index = to_new[entity.index];
    }
    return facets;
  }

 private:
  EdgeUse given(EdgeUse use) const {
    use.edge = ModelEdgeId(model_.edges_[use.edge.value]);
    return use;
  }

  const FarFieldModel& model_;
  std::unique_ptr<FaceGeometry> face_;
};

std::unique_ptr<FaceGeometry> FarFieldModel::face_geometry(ModelFaceId id) const {
  if (id.value < faces_.size())
    return std::make_unique<RenumberedFace>(*this, model_->face_geometry(ModelFaceId(faces_[id.value])));
  return face_geometry_of(bounding_box_, static_cast<int>(id.value - faces_.size()),
                          static_cast<std::uint32_t>(edges_.size()), static_cast<std::uint32_t>(vertices_.size()));
}

}  // namespace

std::unique_ptr<GeometricModel> put_into_box(std::shared_ptr<const GeometricModel> model, double factor) {
  if (!model) throw Error(ErrorCode::InvalidArgument, "there is no model to put into a box");
  if (!(factor > 1 && std::isfinite(factor)))
    throw Error(ErrorCode::InvalidArgument, "the box around a model must be larger than the model");
  if (model->topology().face_count() == 0)
    throw Error(ErrorCode::InputUnsuitable, "the model has no faces to put into a box");
  const Box3& given = model->bounding_box();
  const Vec3 extent = given.hi - given.lo, center = given.center();
  const double least = kLeastSide * std::max({extent.x, extent.y, extent.z});
  Box3 box;
  for (int axis = 0; axis < 3; ++axis) {
    const double half = 0.5 * factor * std::max(extent[axis], least);
    box.lo[axis] = center[axis] - half;
    box.hi[axis] = center[axis] + half;
  }
  return std::make_unique<FarFieldModel>(std::move(model), box);
}

}  // namespace tetloom
