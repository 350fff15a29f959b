#include "tests/support/analytic_model.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "tests/support/analytic_shapes.hpp"
#include "tests/support/analytic_tessellation.hpp"
#include "tetloom/assert.hpp"

namespace tetloom::test_models {
namespace {

class AnalyticEdgeGeometry final : public EdgeGeometry {
 public:
  explicit AnalyticEdgeGeometry(const Curve& curve) : curve_(curve) {}
  ParameterRange range() override { return curve_.range; }
  double period() override { return curve_.period(); }
  Vec3 evaluate(double t) override { return curve_.evaluate(t); }
  Vec3 derivative(double t) override { return curve_.derivative(t); }
  double curvature(double) override { return curve_.curvature(); }
  CurvePoint closest_point(const Vec3& x) override {
    const double t = curve_.closest(x);
    const Vec3 point = curve_.evaluate(t);
    return {t, point, distance(point, x)};
  }

 private:
  Curve curve_;
};

class AnalyticFaceGeometry final : public FaceGeometry {
 public:
  AnalyticFaceGeometry(const Parts& parts, ModelFaceId id) : parts_(parts), id_(id), face_(parts.faces[id.value]) {}

  Parametrization parametrization() override { return Parametrization::Smooth; }
  ParameterBox parameter_box() override { return face_.box; }
  Vec2 period() override {
    return std::visit([](const auto& surface) { return surface.period(); }, face_.surface);
  }
  Vec3 evaluate(const Vec2& uv) override {
    return std::visit([&](const auto& surface) { return surface.evaluate(uv); }, face_.surface);
  }
  SurfaceDerivatives derivatives(const Vec2& uv) override {
    return std::visit([&](const auto& surface) { return surface.derivatives(uv); }, face_.surface);
  }
  Vec3 normal(const Vec2& uv) override {
    return std::visit([&](const auto& surface) { return surface.normal(uv); }, face_.surface);
  }
  PrincipalCurvatures curvature(const Vec2& uv) override {
    return std::visit([&](const auto& surface) { return surface.curvature(uv); }, face_.surface);
  }
  SurfacePoint closest_point(const Vec3& x, const std::optional<Vec2>& guess) override {
    const Vec2 uv = std::visit([&](const auto& surface) { return surface.closest(x, guess); }, face_.surface);
    const Vec3 point = evaluate(uv);
    return {uv, point, distance(point, x)};
  }
  Vec2 edge_parameters(const EdgeUse& use, double t) override {
    if (const ParameterLine* line = find_line(use)) return line->origin + t * line->direction;
    return std::get<Plane>(face_.surface).closest(parts_.curves[use.edge.value].evaluate(t), std::nullopt);
  }
  ParameterRange edge_range(const EdgeUse& use) override {
    const ParameterLine* line = find_line(use);
    return line != nullptr ? line->range : parts_.curves[use.edge.value].range;
  }
  Tessellation tessellate(double chord, double angle) override { return tessellate_face(parts_, id_, chord, angle); }

 private:
  const ParameterLine* find_line(const EdgeUse& use) const {
    for (const ParameterLine& line : face_.parameter_lines)
      if (line.edge == use.edge && line.second_side == use.second_side) return &line;
    return nullptr;
  }

  const Parts& parts_;
  ModelFaceId id_;
  const AnalyticFace& face_;
};

class AnalyticModel final : public GeometricModel {
 public:
  explicit AnalyticModel(Parts parts) : parts_(std::move(parts)) {
    topology_.vertex_count = parts_.points.size();
    topology_.edges = parts_.edges;
    topology_.region_to_faces = parts_.region_to_faces;
    for (const AnalyticFace& face : parts_.faces) {
      topology_.face_to_loops.push_back(face.loops);
      topology_.face_to_sides.push_back(face.sides);
    }
    for (int dim = 0; dim < 4; ++dim) attributes_[static_cast<std::size_t>(dim)].resize(topology_.count(dim));
    bounding_box_ = parts_.box;
  }
  Vec3 vertex_point(ModelVertexId id) const override { return parts_.points.at(id.value); }
  std::unique_ptr<EdgeGeometry> edge_geometry(ModelEdgeId id) const override {
    TETLOOM_ASSERT(!parts_.edges.at(id.value).degenerate);
    return std::make_unique<AnalyticEdgeGeometry>(parts_.curves[id.value]);
  }
  std::unique_ptr<FaceGeometry> face_geometry(ModelFaceId id) const override {
    TETLOOM_ASSERT(id.value < parts_.faces.size());
    return std::make_unique<AnalyticFaceGeometry>(parts_, id);
  }
  double area(ModelFaceId id) const override { return parts_.faces.at(id.value).area; }
  double volume(ModelRegionId id) const override { return parts_.volumes.at(id.value); }
  const Parts& parts() const { return parts_; }

 private:
  Parts parts_;
};

Curve make_line(const Vec3& a, const Vec3& b) {
  return {.origin = a, .direction = normalized(b - a), .range = {0, distance(a, b)}};
}

Curve make_circle(const Vec3& center, double radius) {
  return {.origin = center, .direction = {}, .radius = radius, .range = {0, kTurn}};
}

ModelEdgeTopology ends(std::size_t first, std::size_t second, bool degenerate = false) {
  return {{ModelVertexId(first), ModelVertexId(second)}, degenerate};
}

EdgeUse use(std::size_t edge, bool forward, bool second_side = false) {
  return {ModelEdgeId(edge), forward, second_side};
}

/// Bounds one region by all faces, whose normals point outwards.
std::unique_ptr<GeometricModel> finish_solid(Parts parts, double volume) {
  parts.region_to_faces.resize(1);
  for (std::size_t i = 0; i < parts.faces.size(); ++i) {
    parts.region_to_faces[0].push_back(ModelFaceId(i));
    parts.faces[i].sides.back = ModelRegionId(std::size_t{0});
  }
  parts.volumes = {volume};
  return std::make_unique<AnalyticModel>(std::move(parts));
}

/// A flat face inside one full circle (edge `edge`); `up` when the normal is +z.
AnalyticFace make_disc(const Vec3& center, double radius, std::size_t edge, bool up) {
  AnalyticFace face;
  face.surface = Plane{center, {1, 0, 0}, {0, up ? 1.0 : -1.0, 0}};
  face.box = {{-radius, -radius}, {radius, radius}};
  face.facets = Facets::Disc;
  face.loops = {{use(edge, up)}};
  face.area = kPi * radius * radius;
  return face;
}

std::size_t find_or_add_edge(Parts& parts, std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t>& known,
                             std::uint32_t a, std::uint32_t b) {
  const auto [it, added] = known.try_emplace(std::minmax(a, b), parts.edges.size());
  if (added) {
    parts.edges.push_back(ends(a, b));
    parts.curves.push_back(make_line(parts.points[a], parts.points[b]));
  }
  return it->second;
}

}  // namespace

std::unique_ptr<GeometricModel> make_polyhedron(std::span<const Vec3> points,
                                                std::span<const std::vector<std::uint32_t>> face_to_vert, bool solid) {
  Parts parts;
  parts.points.assign(points.begin(), points.end());
  for (const Vec3& point : points) parts.box.add(point);
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::size_t> known;
  double volume = 0;
  for (const std::vector<std::uint32_t>& ring : face_to_vert) {
    AnalyticFace face;
    face.facets = Facets::Fan;
    Vec3 twice_area;
    face.loops.emplace_back();
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const std::uint32_t a = ring[i], b = ring[(i + 1) % ring.size()];
      twice_area += cross(points[a], points[b]);
      const std::size_t edge = find_or_add_edge(parts, known, a, b);
      face.loops[0].push_back(use(edge, parts.edges[edge].vertices[0].value == a));
    }
    const Vec3 axis_x = normalized(points[ring[1]] - points[ring[0]]);
    const Plane plane{points[ring[0]], axis_x, cross(normalized(twice_area), axis_x)};
    Box3 flat;
    for (const std::uint32_t v : ring) {
      const Vec2 uv = plane.closest(points[v], std::nullopt);
      flat.add(Vec3{uv.u, uv.v, 0});
    }
    face.surface = plane;
    face.box = {{flat.lo.x, flat.lo.y}, {flat.hi.x, flat.hi.y}};
    face.area = 0.5 * norm(twice_area);
    volume += dot(points[ring[0]], twice_area) / 6;
    parts.faces.push_back(std::move(face));
  }
  if (solid) return finish_solid(std::move(parts), volume);
  return std::make_unique<AnalyticModel>(std::move(parts));
}

std::unique_ptr<GeometricModel> make_chamfered_cube(double width) {
  const double c = 1 - width / std::sqrt(2);
  const std::vector<Vec3> points{{0, 0, 0}, {1, 0, 0}, {1, 0, c}, {c, 0, 1}, {0, 0, 1},
                                 {0, 1, 0}, {1, 1, 0}, {1, 1, c}, {c, 1, 1}, {0, 1, 1}};
  const std::vector<std::vector<std::uint32_t>> faces{{0, 1, 2, 3, 4}, {9, 8, 7, 6, 5}, {0, 5, 6, 1}, {1, 6, 7, 2},
                                                      {2, 7, 8, 3},    {3, 8, 9, 4},    {4, 9, 5, 0}};
  return make_polyhedron(points, faces);
}

std::unique_ptr<GeometricModel> make_box(const Vec3& lo, const Vec3& hi) {
  std::vector<Vec3> points;
  for (int i = 0; i < 8; ++i) points.push_back({i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z});
  const std::vector<std::vector<std::uint32_t>> rings = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                                         {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  return make_polyhedron(points, rings);
}

std::unique_ptr<GeometricModel> make_plate(double width, double depth) {
  const std::vector<Vec3> points = {{0, 0, 0}, {width, 0, 0}, {width, depth, 0}, {0, depth, 0}};
  const std::vector<std::vector<std::uint32_t>> rings = {{0, 1, 2, 3}};
  return make_polyhedron(points, rings, false);
}

std::unique_ptr<GeometricModel> make_annulus(double inner_radius, double outer_radius) {
  Parts parts;
  parts.points = {{outer_radius, 0, 0}, {inner_radius, 0, 0}};
  parts.curves = {make_circle({}, outer_radius), make_circle({}, inner_radius)};
  parts.edges = {ends(0, 0), ends(1, 1)};
  AnalyticFace face = make_disc({}, outer_radius, 0, true);
  face.facets = Facets::Ring;
  face.loops.push_back({use(1, false)});
  face.area -= kPi * inner_radius * inner_radius;
  parts.faces = {face};
  parts.box = {{-outer_radius, -outer_radius, 0}, {outer_radius, outer_radius, 0}};
  return std::make_unique<AnalyticModel>(std::move(parts));
}

std::unique_ptr<GeometricModel> make_cylinder(double radius, double height) {
  Parts parts;
  parts.points = {{radius, 0, 0}, {radius, 0, height}};
  parts.curves = {make_circle({}, radius), make_circle({0, 0, height}, radius),
                  make_line(parts.points[0], parts.points[1])};
  parts.edges = {ends(0, 0), ends(1, 1), ends(0, 1)};
  AnalyticFace side;
  side.surface = Revolution{.center = {}, .rho_0 = radius, .z_1 = 1};
  side.box = {{0, 0}, {kTurn, height}};
  side.parameter_lines = {{ModelEdgeId(std::size_t{0}), false, {0, 0}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{1}), false, {0, height}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{2}), false, {kTurn, 0}, {0, 1}, {0, height}},
                          {ModelEdgeId(std::size_t{2}), true, {0, 0}, {0, 1}, {0, height}}};
  side.loops = {{use(0, true), use(2, true), use(1, false), use(2, false, true)}};
  side.area = kTurn * radius * height;
  parts.faces = {side, make_disc({}, radius, 0, false), make_disc({0, 0, height}, radius, 1, true)};
  parts.box = {{-radius, -radius, 0}, {radius, radius, height}};
  return finish_solid(std::move(parts), kPi * radius * radius * height);
}

std::unique_ptr<GeometricModel> make_cone(double radius, double height) {
  Parts parts;
  parts.points = {{radius, 0, 0}, {0, 0, height}};
  const Vec3 rise = parts.points[1] - parts.points[0];
  parts.curves = {make_circle({}, radius),
                  Curve{.origin = parts.points[0], .direction = rise / height, .range = {0, height}}, Curve{}};
  parts.edges = {ends(0, 0), ends(0, 1), ends(1, 1, true)};
  AnalyticFace side;
  side.surface = Revolution{.center = {}, .rho_0 = radius, .rho_1 = -radius / height, .z_1 = 1};
  side.box = {{0, 0}, {kTurn, height}};
  side.parameter_lines = {{ModelEdgeId(std::size_t{0}), false, {0, 0}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{2}), false, {0, height}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{1}), false, {kTurn, 0}, {0, 1}, {0, height}},
                          {ModelEdgeId(std::size_t{1}), true, {0, 0}, {0, 1}, {0, height}}};
  side.loops = {{use(0, true), use(1, true), use(2, false), use(1, false, true)}};
  side.area = kPi * radius * norm(rise);
  parts.faces = {side, make_disc({}, radius, 0, false)};
  parts.box = {{-radius, -radius, 0}, {radius, radius, height}};
  return finish_solid(std::move(parts), kPi * radius * radius * height / 3);
}

std::unique_ptr<GeometricModel> make_sphere(const Vec3& center, double radius) {
  Parts parts;
  parts.points = {center - Vec3{0, 0, radius}, center + Vec3{0, 0, radius}};
  Curve seam{.origin = center, .direction = {}, .radius = radius, .axis_y = {0, 0, 1}, .range = {-kPi / 2, kPi / 2}};
  parts.curves = {seam, Curve{}, Curve{}};
  parts.edges = {ends(0, 1), ends(0, 0, true), ends(1, 1, true)};
  AnalyticFace face;
  face.surface = Revolution{.center = center, .r = radius};
  face.box = {{0, -kPi / 2}, {kTurn, kPi / 2}};
  face.parameter_lines = {{ModelEdgeId(std::size_t{1}), false, {0, -kPi / 2}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{2}), false, {0, kPi / 2}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{0}), false, {kTurn, 0}, {0, 1}, {-kPi / 2, kPi / 2}},
                          {ModelEdgeId(std::size_t{0}), true, {0, 0}, {0, 1}, {-kPi / 2, kPi / 2}}};
  face.loops = {{use(1, true), use(0, true), use(2, false), use(0, false, true)}};
  face.area = 4 * kPi * radius * radius;
  parts.faces = {face};
  parts.box = {center - Vec3{radius, radius, radius}, center + Vec3{radius, radius, radius}};
  return finish_solid(std::move(parts), 4 * kPi * radius * radius * radius / 3);
}

std::unique_ptr<GeometricModel> make_torus(double major_radius, double minor_radius) {
  const double outer = major_radius + minor_radius;
  Parts parts;
  parts.points = {{outer, 0, 0}};
  Curve tube = make_circle({major_radius, 0, 0}, minor_radius);
  tube.axis_y = {0, 0, 1};
  parts.curves = {make_circle({}, outer), tube};
  parts.edges = {ends(0, 0), ends(0, 0)};
  AnalyticFace face;
  face.surface = Revolution{.center = {}, .rho_0 = major_radius, .r = minor_radius};
  face.box = {{0, 0}, {kTurn, kTurn}};
  face.parameter_lines = {{ModelEdgeId(std::size_t{0}), false, {0, 0}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{0}), true, {0, kTurn}, {1, 0}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{1}), false, {kTurn, 0}, {0, 1}, {0, kTurn}},
                          {ModelEdgeId(std::size_t{1}), true, {0, 0}, {0, 1}, {0, kTurn}}};
  face.loops = {{use(0, true), use(1, true), use(0, false, true), use(1, false, true)}};
  face.area = kTurn * major_radius * kTurn * minor_radius;
  parts.faces = {face};
  parts.box = {{-outer, -outer, -minor_radius}, {outer, outer, minor_radius}};
  return finish_solid(std::move(parts), kTurn * major_radius * kPi * minor_radius * minor_radius);
}

std::unique_ptr<GeometricModel> combine(std::span<const std::shared_ptr<const GeometricModel>> bodies) {
  Parts all;
  for (const std::shared_ptr<const GeometricModel>& body : bodies) {
    const auto* model = dynamic_cast<const AnalyticModel*>(body.get());
    TETLOOM_ASSERT(model != nullptr);
    const Parts& parts = model->parts();
    const std::size_t points = all.points.size(), edges = all.edges.size(), faces = all.faces.size(),
                      regions = all.region_to_faces.size();
    all.points.insert(all.points.end(), parts.points.begin(), parts.points.end());
    all.curves.insert(all.curves.end(), parts.curves.begin(), parts.curves.end());
    all.volumes.insert(all.volumes.end(), parts.volumes.begin(), parts.volumes.end());
    all.box.add(parts.box);
    for (ModelEdgeTopology edge : parts.edges) {
      for (ModelVertexId& v : edge.vertices) v = ModelVertexId(v.value + points);
      all.edges.push_back(edge);
    }
    for (AnalyticFace face : parts.faces) {
      for (ParameterLine& line : face.parameter_lines) line.edge = ModelEdgeId(line.edge.value + edges);
      for (ModelLoop& loop : face.loops)
        for (EdgeUse& edge_use : loop) edge_use.edge = ModelEdgeId(edge_use.edge.value + edges);
      if (face.sides.back.valid()) face.sides.back = ModelRegionId(face.sides.back.value + regions);
      all.faces.push_back(std::move(face));
    }
    for (std::vector<ModelFaceId> boundary : parts.region_to_faces) {
      for (ModelFaceId& face : boundary) face = ModelFaceId(face.value + faces);
      all.region_to_faces.push_back(std::move(boundary));
    }
  }
  return std::make_unique<AnalyticModel>(std::move(all));
}

}  // namespace tetloom::test_models
