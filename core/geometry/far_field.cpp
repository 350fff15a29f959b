#include "tetloom/far_field.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/disjoint_sets.hpp"

namespace tetloom {
namespace {

constexpr double kLeastSide = 0.1;  // of the longest side of the box around the model
constexpr double kChord = 0.005;    // of the diagonal: of the facets by which shells are told apart
constexpr double kTurn = 0.2;       // radians between those facets
constexpr int kCorners = 8, kSides = 6;

Vec3 corner_of(const Box3& box, int corner) {
  return {(corner & 1) ? box.hi.x : box.lo.x, (corner & 2) ? box.hi.y : box.lo.y, (corner & 4) ? box.hi.z : box.lo.z};
}

class SegmentGeometry : public EdgeGeometry {
 public:
  SegmentGeometry(const Vec3& from, const Vec3& to) : from_(from), length_(distance(from, to)) {
    along_ = (to - from) / length_;
  }
  ParameterRange range() override { return {0, length_}; }
  double period() override { return 0; }
  Vec3 evaluate(double t) override { return from_ + t * along_; }
  Vec3 derivative(double) override { return along_; }
  double curvature(double) override { return 0; }
  CurvePoint closest_point(const Vec3& x) override {
    const double t = std::clamp(dot(x - from_, along_), 0.0, length_);
    return {t, evaluate(t), distance(x, evaluate(t))};
  }

 private:
  Vec3 from_, along_;
  double length_;
};

// The edges of a box: along each axis four.
struct BoxEdge {
  int from, to;
};
BoxEdge edge_of_box(int edge) {
  const int axis = edge / 4, first = (axis + 1) % 3, second = (axis + 2) % 3;
  const int from = ((edge & 1) << first) | (((edge >> 1) & 1) << second);
  return {from, from | (1 << axis)};
}

// Side 2 · axis + (0 below, 1 above), with its normal out of the box and (u,v) as lengths along two axes.
struct BoxSide {
  int axis, u, v;
  bool above;

  explicit BoxSide(int side) : axis(side / 2), u((axis + 1) % 3), v((axis + 2) % 3), above(side % 2 == 1) {
    if (!above) std::swap(u, v);
  }
  // Counter-clockwise seen from outside.
  std::array<int, 4> corners() const {
    const int base = above ? 1 << axis : 0;
    return {base, base | (1 << u), base | (1 << u) | (1 << v), base | (1 << v)};
  }
};

class RectangleGeometry : public FaceGeometry {
 public:
  RectangleGeometry(const Box3& box, int side, std::uint32_t face, std::uint32_t first_edge, std::uint32_t first_vertex)
      : box_(box), side_(side), face_(face), first_edge_(first_edge), first_vertex_(first_vertex) {}

  Parametrization parametrization() override { return Parametrization::Smooth; }
  ParameterBox parameter_box() override {
    return {{0, 0}, {box_.hi[side_.u] - box_.lo[side_.u], box_.hi[side_.v] - box_.lo[side_.v]}};
  }
  Vec2 period() override { return {}; }
  Vec3 evaluate(const Vec2& uv) override {
    Vec3 x;
    x[side_.axis] = side_.above ? box_.hi[side_.axis] : box_.lo[side_.axis];
    x[side_.u] = box_.lo[side_.u] + uv.u;
    x[side_.v] = box_.lo[side_.v] + uv.v;
    return x;
  }
  SurfaceDerivatives derivatives(const Vec2& uv) override {
    SurfaceDerivatives result{evaluate(uv), {}, {}};
    result.du[side_.u] = result.dv[side_.v] = 1;
    return result;
  }
  Vec3 normal(const Vec2&) override {
    Vec3 n;
    n[side_.axis] = side_.above ? 1 : -1;
    return n;
  }
  PrincipalCurvatures curvature(const Vec2&) override { return {}; }
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>&) override {
    const ParameterBox range = parameter_box();
    const Vec2 uv{std::clamp(x[side_.u] - box_.lo[side_.u], 0.0, range.hi.u),
                  std::clamp(x[side_.v] - box_.lo[side_.v], 0.0, range.hi.v)};
    return {uv, evaluate(uv), distance(x, evaluate(uv))};
  }
  Vec2 edge_parameters(const EdgeUse& use, double t) override {
    const auto [from, to] = edge_of_box(static_cast<int>(use.edge.value - first_edge_));
    const Vec3 start = corner_of(box_, from), end = corner_of(box_, to);
    const Vec3 x = start + t / distance(start, end) * (end - start);
    return {x[side_.u] - box_.lo[side_.u], x[side_.v] - box_.lo[side_.v]};
  }
  ParameterRange edge_range(const EdgeUse& use) override {
    const auto [from, to] = edge_of_box(static_cast<int>(use.edge.value - first_edge_));
    return {0, distance(corner_of(box_, from), corner_of(box_, to))};
  }
  Tessellation tessellate(double, double) override {
    Tessellation result;
    for (const int corner : side_.corners()) {
      const Vec3 x = corner_of(box_, corner);
      result.points.push_back(x);
      result.uv.push_back({x[side_.u] - box_.lo[side_.u], x[side_.v] - box_.lo[side_.v]});
      result.classification.emplace_back(0, first_vertex_ + static_cast<std::uint32_t>(corner));
      result.edge_parameter.push_back(0);
    }
    result.tri_to_vert = {{0, 1, 2}, {0, 2, 3}};
    return result;
  }

 private:
  Box3 box_;
  BoxSide side_;
  std::uint32_t face_, first_edge_, first_vertex_;
};

// Which faces of a model the space around it has, and what they enclose.
class Outside {
 public:
  explicit Outside(const GeometricModel& model) : model_(model), topology_(model.topology()) {
    find_shells();
    measure();
    for (Shell& shell : shells_) judge(shell);
  }

  bool has(std::uint32_t face) const { return shell_of_[face] != kNone && shells_[shell_of_[face]].is_outside; }

  // Of the solids, and of voids in them.
  double enclosed_volume() const {
    double volume = 0;
    std::vector<bool> is_counted(topology_.region_count(), false);
    DisjointSets bodies(topology_.region_count());
    for (const FaceSides& sides : topology_.face_to_sides)
      if (sides.front.valid() && sides.back.valid()) bodies.join(sides.front.value, sides.back.value);
    std::vector<bool> body_is_outside(topology_.region_count(), false);
    for (std::uint32_t f = 0; f < shell_of_.size(); ++f)
      if (has(f) && region_of(f).valid()) body_is_outside[bodies.find(region_of(f).value)] = true;
    for (std::uint32_t r = 0; r < topology_.region_count(); ++r)
      if (body_is_outside[bodies.find(r)]) volume += model_.volume(ModelRegionId(r));
    for (const Shell& shell : shells_)
      if (shell.volume < 0 && shell.region != kNone && body_is_outside[bodies.find(shell.region)])
        volume -= shell.volume;
    return volume;
  }

 private:
  struct Shell {
    std::vector<std::array<Vec3, 3>> facets;  // normals out of the solid
    double volume = 0;                        // negative for voids
    Box3 box;
    std::uint32_t region = kNone;  // of one of its faces
    bool is_closed = true, is_outside = true;
  };

  // The one region of a face, or none.
  ModelRegionId region_of(std::uint32_t face) const {
    const FaceSides& sides = topology_.face_to_sides[face];
    return sides.front.valid() ? sides.front : sides.back;
  }

  // Faces with the outside on one side at least, hanging together through edges.
  void find_shells() {
    DisjointSets sets(topology_.face_count());
    std::vector<std::uint32_t> edge_to_face(topology_.edge_count(), kNone);
    const auto is_outer = [&](std::uint32_t f) {
      return !topology_.face_to_sides[f].front.valid() || !topology_.face_to_sides[f].back.valid();
    };
    for (std::uint32_t f = 0; f < topology_.face_count(); ++f)
      for (const ModelLoop& loop : topology_.face_to_loops[f])
        for (const EdgeUse& use : loop) {
          if (!is_outer(f) || topology_.edges[use.edge.value].degenerate) continue;
          std::uint32_t& other = edge_to_face[use.edge.value];
          if (other == kNone) other = f;
          sets.join(f, other);
        }
    shell_of_.assign(topology_.face_count(), kNone);
    std::vector<std::uint32_t> set_to_shell(topology_.face_count(), kNone);
    for (std::uint32_t f = 0; f < topology_.face_count(); ++f) {
      if (!is_outer(f)) continue;
      std::uint32_t& shell = set_to_shell[sets.find(f)];
      if (shell == kNone) {
        shell = static_cast<std::uint32_t>(shells_.size());
        shells_.emplace_back();
      }
      shell_of_[f] = shell;
    }
  }

  void measure() {
    const Box3& box = model_.bounding_box();
    for (std::uint32_t f = 0; f < topology_.face_count(); ++f) {
      if (shell_of_[f] == kNone) continue;
      Shell& shell = shells_[shell_of_[f]];
      const FaceSides& sides = topology_.face_to_sides[f];
      if (region_of(f).valid()) shell.region = region_of(f).value;
      if (!region_of(f).valid()) shell.is_closed = false;
      const Tessellation facets = model_.face_geometry(ModelFaceId(f))->tessellate(kChord * box.diagonal(), kTurn);
      for (const auto& [a, b, c] : facets.tri_to_vert) {
        std::array<Vec3, 3> x{facets.points[a], facets.points[b], facets.points[c]};
        if (sides.front.valid()) std::swap(x[1], x[2]);
        shell.volume += dot(x[0] - box.lo, cross(x[1] - box.lo, x[2] - box.lo)) / 6;
        for (const Vec3& p : x) shell.box.add(p);
        shell.facets.push_back(x);
      }
    }
  }

  // Voids, and what lies in another shell, are not outside.
  void judge(Shell& shell) {
    if (shell.facets.empty()) return;
    shell.is_outside = !(shell.is_closed && shell.volume < 0);
    const Vec3& point = shell.facets[0][0];
    for (const Shell& other : shells_) {
      if (&other == &shell || !other.is_closed || other.volume <= 0 || !other.box.contains(point)) continue;
      constexpr double kInside = 0.5;
      if (winding_number(other, point) > kInside) shell.is_outside = false;
    }
  }

  // By the solid angles of the facets (van Oosterom & Strackee 1983).
  static double winding_number(const Shell& shell, const Vec3& point) {
    double angle = 0;
    for (const auto& facet : shell.facets) {
      const Vec3 a = facet[0] - point, b = facet[1] - point, c = facet[2] - point;
      const double la = norm(a), lb = norm(b), lc = norm(c);
      angle += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
    }
    return angle / (4 * std::numbers::pi);
  }

  const GeometricModel& model_;
  const ModelTopology& topology_;
  std::vector<Shell> shells_;
  std::vector<std::uint32_t> shell_of_;  // per face
};

class FarFieldModel : public GeometricModel {
 public:
  FarFieldModel(std::shared_ptr<const GeometricModel> model, const Box3& box) : model_(std::move(model)) {
    const Outside outside(*model_);
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
    const auto [from, to] = edge_of_box(static_cast<int>(id.value - edges_.size()));
    return std::make_unique<SegmentGeometry>(corner_of(bounding_box_, from), corner_of(bounding_box_, to));
  }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override;
  double area(ModelFaceId id) const override {
    if (id.value < faces_.size()) return model_->area(ModelFaceId(faces_[id.value]));
    const BoxSide side(static_cast<int>(id.value - faces_.size()));
    const Vec3 extent = bounding_box_.hi - bounding_box_.lo;
    return extent[side.u] * extent[side.v];
  }
  double volume(ModelRegionId) const override { return volume_; }

 private:
  friend class RenumberedFace;

  // What is kept, in the order of the given model.
  void number(const Outside& outside) {
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
    for (int edge = 0; edge < 12; ++edge) {
      const auto [from, to] = edge_of_box(edge);
      ModelEdgeTopology topology;
      topology.vertices = {ModelVertexId(vertices_.size() + static_cast<std::size_t>(from)),
                           ModelVertexId(vertices_.size() + static_cast<std::size_t>(to))};
      topology_.edges.push_back(topology);
      attributes_[1].emplace_back();
    }
    topology_.vertex_count += kCorners;
    attributes_[0].resize(topology_.vertex_count);
    for (int side = 0; side < kSides; ++side) {
      ModelLoop loop;
      const std::array<int, 4> corners = BoxSide(side).corners();
      for (std::size_t i = 0; i < 4; ++i) loop.push_back(use_between(corners[i], corners[(i + 1) % 4]));
      topology_.face_to_loops.push_back({std::move(loop)});
      topology_.face_to_sides.push_back({ModelRegionId(), ModelRegionId(0u)});
      attributes_[2].emplace_back().name = "far_field_" + std::to_string(side + 1);
    }
  }

  EdgeUse use_between(int from, int to) const {
    for (int edge = 0; edge < 12; ++edge) {
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
  return std::make_unique<RectangleGeometry>(bounding_box_, static_cast<int>(id.value - faces_.size()), id.value,
                                             static_cast<std::uint32_t>(edges_.size()),
                                             static_cast<std::uint32_t>(vertices_.size()));
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
