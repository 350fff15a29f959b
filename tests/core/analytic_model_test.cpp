// The analytic test models obey the conventions of tetloom/model.hpp.
#include <catch2/catch.hpp>

#include <map>
#include <numbers>
#include <string>

#include "tests/support/analytic_model.hpp"

namespace tetloom {
namespace {

using ModelPtr = std::shared_ptr<const GeometricModel>;

std::map<std::string, ModelPtr> all_models() {
  const ModelPtr box = test_models::make_box({0, 0, 0}, {1, 2, 3});
  const ModelPtr ball = test_models::make_sphere({5, 1, 2}, 1.5);
  const ModelPtr torus = test_models::make_torus(3, 1);
  const std::array<ModelPtr, 3> bodies{box, ball, torus};
  return {{"box", box},
          {"sphere", ball},
          {"torus", torus},
          {"plate", test_models::make_plate(2, 1)},
          {"annulus", test_models::make_annulus(1, 2)},
          {"cylinder", test_models::make_cylinder(1, 3)},
          {"cone", test_models::make_cone(1, 2)},
          {"combined", test_models::combine(bodies)}};
}

/// Points along a use in the direction of its loop.
std::vector<Vec2> sample(FaceGeometry& face, const EdgeUse& use, int count) {
  const ParameterRange range = face.edge_range(use);
  std::vector<Vec2> uvs;
  for (int i = 0; i <= count; ++i) {
    const double f = static_cast<double>(i) / count;
    const double t = range.lo + (range.hi - range.lo) * (use.forward ? f : 1 - f);
    uvs.push_back(face.edge_parameters(use, t));
  }
  return uvs;
}

double facet_area(const Tessellation& facets) {
  double area = 0;
  for (const auto& [a, b, c] : facets.tri_to_vert)
    area += 0.5 * norm(cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a]));
  return area;
}

double facet_volume(const Tessellation& facets) {
  double volume = 0;
  for (const auto& [a, b, c] : facets.tri_to_vert)
    volume += dot(facets.points[a], cross(facets.points[b], facets.points[c])) / 6;
  return volume;
}

}  // namespace

TEST_CASE("loops of analytic models are closed chains with the face on their left") {
  for (const auto& [name, model] : all_models()) {
    for (std::size_t f = 0; f < model->topology().face_count(); ++f) {
      INFO(name << " face " << f);
      const auto face = model->face_geometry(ModelFaceId(f));
      double area = 0;
      for (const ModelLoop& loop : model->topology().face_to_loops[f]) {
        std::vector<Vec2> ring;
        for (const EdgeUse& use : loop) {
          const std::vector<Vec2> uvs = sample(*face, use, 64);
          if (!ring.empty()) CHECK(norm(ring.back() - uvs.front()) < 1e-9);
          ring.insert(ring.end(), uvs.begin(), uvs.end());
        }
        CHECK(norm(ring.front() - ring.back()) < 1e-9);
        double loop_area = 0;
        for (std::size_t i = 1; i < ring.size(); ++i) loop_area += 0.5 * cross(ring[i - 1], ring[i]);
        area += loop_area;
        CHECK((loop_area > 0) == (&loop == &model->topology().face_to_loops[f].front()));
      }
      CHECK(area > 0);
    }
  }
}

TEST_CASE("parameter curves of analytic models lie on their edges and end at their vertices") {
  for (const auto& [name, model] : all_models()) {
    for (std::size_t f = 0; f < model->topology().face_count(); ++f) {
      const auto face = model->face_geometry(ModelFaceId(f));
      for (const ModelLoop& loop : model->topology().face_to_loops[f]) {
        for (const EdgeUse& use : loop) {
          INFO(name << " face " << f << " edge " << use.edge.value);
          const ModelEdgeTopology& ends = model->topology().edges[use.edge.value];
          const ParameterRange range = face->edge_range(use);
          for (int i = 0; i <= 8; ++i) {
            const double t = range.lo + (range.hi - range.lo) * i / 8;
            const Vec3 on_face = face->evaluate(face->edge_parameters(use, t));
            const Vec3 on_edge =
                ends.degenerate ? model->vertex_point(ends.vertices[0]) : model->edge_geometry(use.edge)->evaluate(t);
            CHECK(distance(on_face, on_edge) < 1e-9);
            if (i == 0) CHECK(distance(on_edge, model->vertex_point(ends.vertices[0])) < 1e-9);
            if (i == 8) CHECK(distance(on_edge, model->vertex_point(ends.vertices[1])) < 1e-9);
          }
        }
      }
    }
  }
}

TEST_CASE("facets of analytic models enclose their volume and are classified where they lie") {
  for (const auto& [name, model] : all_models()) {
    for (std::size_t r = 0; r < model->topology().region_count(); ++r) {
      double volume = 0;
      for (const ModelFaceId f : model->topology().region_to_faces[r]) {
        INFO(name << " face " << f.value);
        CHECK(model->topology().face_to_sides[f.value].back == ModelRegionId(r));
        const auto face = model->face_geometry(f);
        const Tessellation facets = face->tessellate(1e-3, 0.05);
        volume += facet_volume(facets);
        CHECK(facet_area(facets) == Approx(model->area(f)).epsilon(0.01));
        for (std::size_t i = 0; i < facets.points.size(); ++i) {
          CHECK(distance(face->evaluate(facets.uv[i]), facets.points[i]) < 1e-9);
          const ModelEntity entity = facets.classification[i];
          if (entity.dim == 1)
            CHECK(distance(model->edge_geometry(ModelEdgeId(entity.index))->evaluate(facets.edge_parameter[i]),
                           facets.points[i]) < 1e-9);
          if (entity.dim == 0)
            CHECK(distance(model->vertex_point(ModelVertexId(entity.index)), facets.points[i]) < 1e-9);
        }
      }
      CHECK(volume == Approx(model->volume(ModelRegionId(r))).epsilon(0.01));
    }
  }
}

TEST_CASE("facets of analytic sheets have the area and the normal of their face") {
  for (const char* name : {"plate", "annulus"}) {
    INFO(name);
    const ModelPtr model = all_models().at(name);
    const Tessellation facets = model->face_geometry(ModelFaceId(std::size_t{0}))->tessellate(1e-3, 0.05);
    CHECK(facet_area(facets) == Approx(model->area(ModelFaceId(std::size_t{0}))).epsilon(0.01));
    for (const auto& [a, b, c] : facets.tri_to_vert)
      CHECK(cross(facets.points[b] - facets.points[a], facets.points[c] - facets.points[a]).z > 0);
  }
}

TEST_CASE("derivatives, normals, curvatures and nearest points of analytic surfaces agree with differences") {
  for (const auto& [name, model] : all_models()) {
    for (std::size_t f = 0; f < model->topology().face_count(); ++f) {
      INFO(name << " face " << f);
      const auto face = model->face_geometry(ModelFaceId(f));
      const ParameterBox box = face->parameter_box();
      const Vec2 uv = box.lo + Vec2{0.3 * (box.hi.u - box.lo.u), 0.6 * (box.hi.v - box.lo.v)};
      const double step = 1e-5;
      const SurfaceDerivatives at = face->derivatives(uv);
      const Vec3 du = (face->evaluate({uv.u + step, uv.v}) - face->evaluate({uv.u - step, uv.v})) / (2 * step);
      const Vec3 dv = (face->evaluate({uv.u, uv.v + step}) - face->evaluate({uv.u, uv.v - step})) / (2 * step);
      CHECK(distance(du, at.du) < 1e-6);
      CHECK(distance(dv, at.dv) < 1e-6);
      CHECK(distance(face->normal(uv), normalized(cross(at.du, at.dv))) < 1e-9);
      // The surfaces are orthogonal nets of curvature lines: dn/du = -k du.
      const Vec3 dn_du = (face->normal({uv.u + step, uv.v}) - face->normal({uv.u - step, uv.v})) / (2 * step);
      const Vec3 dn_dv = (face->normal({uv.u, uv.v + step}) - face->normal({uv.u, uv.v - step})) / (2 * step);
      const double k_u = -dot(dn_du, at.du) / norm2(at.du), k_v = -dot(dn_dv, at.dv) / norm2(at.dv);
      const PrincipalCurvatures k = face->curvature(uv);
      CHECK(k.largest + k.smallest == Approx(k_u + k_v).margin(1e-6));
      CHECK(k.largest * k.smallest == Approx(k_u * k_v).margin(1e-6));
      CHECK(std::abs(k.largest) >= std::abs(k.smallest));
      const SurfacePoint nearest = face->closest_point(at.point + 0.1 * face->normal(uv), uv);
      CHECK(norm(nearest.uv - uv) < 1e-9);
      CHECK(nearest.distance == Approx(0.1));
    }
  }
}

}  // namespace tetloom
