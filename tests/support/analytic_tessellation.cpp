#include "tests/support/analytic_tessellation.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace tetloom::test_models {
namespace {

/// Facets of a face, point by point.
class Tessellator {
 public:
  Tessellator(const Parts& parts, ModelFaceId id) : parts_(parts), id_(id), face_(parts.faces[id.value]) {}

  Tessellation run(double chord, double angle) {
    switch (face_.facets) {
      case Facets::Grid: add_grid(chord, angle); break;
      case Facets::Fan: add_fan(); break;
      case Facets::Disc: add_disc(chord, angle); break;
      case Facets::Ring: add_ring(chord, angle); break;
    }
    return std::move(out_);
  }

 private:
  static std::size_t steps(double radius, double length, double chord, double angle) {
    if (radius <= 0) return 1;
    const double by_chord = 2 * std::acos(std::clamp(1 - chord / radius, -1.0, 1.0));
    const double step = std::max(std::min({by_chord, angle, kPi / 2}), 1e-3);
    return static_cast<std::size_t>(std::max(1.0, std::ceil(length / step - 1e-9)));
  }

  std::uint32_t add_point(const Vec2& uv, const Vec3& point, ModelEntity entity, double t = 0) {
    out_.points.push_back(point);
    out_.uv.push_back(uv);
    out_.classification.push_back(entity);
    out_.edge_parameter.push_back(entity.dim == 1 ? t : 0);
    return static_cast<std::uint32_t>(out_.points.size() - 1);
  }

  /// The point `t` of an edge, classified on a vertex at the ends of the edge.
  std::uint32_t add_edge_point(ModelEdgeId edge, double t, const Vec2& uv) {
    const ModelEdgeTopology& ends = parts_.edges[edge.value];
    const Curve& curve = parts_.curves[edge.value];
    ModelEntity entity = edge;
    if (t == curve.range.lo) entity = ends.vertices[0];
    if (t == curve.range.hi) entity = ends.vertices[1];
    if (entity.dim == 0) return add_point(uv, parts_.points[entity.index], entity);
    return add_point(uv, curve.evaluate(t), entity, t);
  }

  std::uint32_t add_projected_edge_point(ModelEdgeId edge, double t) {
    const Vec3 point = parts_.curves[edge.value].evaluate(t);
    return add_edge_point(edge, t, std::get<Plane>(face_.surface).closest(point, std::nullopt));
  }

  /// A point of the grid: on the edge whose parameter line holds (u,v), or inside the face.
  std::uint32_t add_grid_point(const Vec2& uv) {
    for (const ParameterLine& line : face_.parameter_lines) {
      const Vec2 offset = uv - line.origin;
      if (std::abs(cross(offset, line.direction)) > 1e-12) continue;
      const double t = dot(offset, line.direction) / dot(line.direction, line.direction);
      if (!parts_.edges[line.edge.value].degenerate) return add_edge_point(line.edge, t, uv);
      const ModelVertexId pole = parts_.edges[line.edge.value].vertices[0];
      return add_point(uv, parts_.points[pole.value], pole);
    }
    return add_point(uv, std::get<Revolution>(face_.surface).evaluate(uv), id_);
  }

  void add_grid(double chord, double angle) {
    const Revolution& surface = std::get<Revolution>(face_.surface);
    const Vec2 extent = face_.box.hi - face_.box.lo;
    const double widest = std::max({surface.rho(face_.box.lo.v), surface.rho(face_.box.hi.v), surface.rho(0)});
    const std::size_t columns = steps(widest, extent.u, chord, angle);
    const std::size_t rows = steps(surface.r, extent.v, chord, angle);
    const auto at = [](double lo, double hi, std::size_t i, std::size_t count) {
      return i == count ? hi : lo + (hi - lo) * static_cast<double>(i) / static_cast<double>(count);
    };
    for (std::size_t j = 0; j <= rows; ++j)
      for (std::size_t i = 0; i <= columns; ++i)
        add_grid_point({at(face_.box.lo.u, face_.box.hi.u, i, columns), at(face_.box.lo.v, face_.box.hi.v, j, rows)});
    const auto index = [&](std::size_t i, std::size_t j) { return static_cast<std::uint32_t>(j * (columns + 1) + i); };
    for (std::size_t j = 0; j < rows; ++j)
      for (std::size_t i = 0; i < columns; ++i) {
        add_facet(index(i, j), index(i + 1, j), index(i + 1, j + 1));
        add_facet(index(i, j), index(i + 1, j + 1), index(i, j + 1));
      }
  }

  /// Leaves out the facets that a pole flattens.
  void add_facet(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
    const Vec3 &pa = out_.points[a], &pb = out_.points[b], &pc = out_.points[c];
    if (pa == pb || pb == pc || pc == pa) return;
    out_.tri_to_vert.push_back({a, b, c});
  }

  void add_fan() {
    for (const EdgeUse& use : face_.loops[0]) {
      const ParameterRange range = parts_.curves[use.edge.value].range;
      add_projected_edge_point(use.edge, use.forward ? range.lo : range.hi);
    }
    for (std::uint32_t i = 2; i < out_.points.size(); ++i) out_.tri_to_vert.push_back({0, i - 1, i});
  }

  /// The points of a loop that is one closed circle, in the order of the loop.
  std::vector<std::uint32_t> add_circle(const EdgeUse& use, std::size_t count) {
    std::vector<std::uint32_t> ring;
    for (std::size_t i = 0; i < count; ++i) {
      const double t = kTurn * static_cast<double>(i) / static_cast<double>(count);
      ring.push_back(add_projected_edge_point(use.edge, use.forward || i == 0 ? t : kTurn - t));
    }
    return ring;
  }

  void add_disc(double chord, double angle) {
    const EdgeUse& use = face_.loops[0][0];
    const Curve& circle = parts_.curves[use.edge.value];
    const std::vector<std::uint32_t> ring =
        add_circle(use, std::max<std::size_t>(3, steps(circle.radius, kTurn, chord, angle)));
    const std::uint32_t center =
        add_point(std::get<Plane>(face_.surface).closest(circle.origin, std::nullopt), circle.origin, id_);
    for (std::size_t i = 0; i < ring.size(); ++i) add_facet(center, ring[i], ring[(i + 1) % ring.size()]);
  }

  void add_ring(double chord, double angle) {
    const EdgeUse &outer_use = face_.loops[0][0], &inner_use = face_.loops[1][0];
    const std::size_t count =
        std::max<std::size_t>(3, steps(parts_.curves[outer_use.edge.value].radius, kTurn, chord, angle));
    const std::vector<std::uint32_t> outer = add_circle(outer_use, count), inner = add_circle(inner_use, count);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t next = (i + 1) % count, inner_i = (count - i) % count, inner_next = (count - next) % count;
      add_facet(outer[i], outer[next], inner[inner_next]);
      add_facet(outer[i], inner[inner_next], inner[inner_i]);
    }
  }

  const Parts& parts_;
  ModelFaceId id_;
  const AnalyticFace& face_;
  Tessellation out_;
};

}  // namespace

Tessellation tessellate_face(const Parts& parts, ModelFaceId id, double chord, double angle) {
  return Tessellator(parts, id).run(chord, angle);
}

}  // namespace tetloom::test_models
