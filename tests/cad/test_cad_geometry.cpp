// Questions to faces and edges of every kind of surface: derivatives, normals, curvatures, projection, facets.
#include <catch2/catch.hpp>
#include <cstdio>
#include <ctime>
#include <map>
#include <random>
#include <thread>

#include "tests/cad/cad_samples.hpp"
#include "tests/cad/model_checks.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using test::Sample;

namespace {

constexpr double kPi = 3.14159265358979323846;

struct NamedSample {
  Sample sample;
  const char* name;
};

constexpr NamedSample kSamples[] = {
    {Sample::Box, "box"},
    {Sample::Cylinder, "cylinder"},
    {Sample::Sphere, "sphere"},
    {Sample::HalvedSphere, "halved sphere"},
    {Sample::Torus, "torus"},
    {Sample::Cone, "cone"},
    {Sample::TurnedSpline, "turned spline"},
    {Sample::PushedSpline, "pushed spline"},
    {Sample::SplineSolid, "spline solid"},
    {Sample::LoftedSolid, "lofted solid"},
    {Sample::OffsetSheet, "offset sheet"},
    {Sample::BezierSheet, "Bézier sheet"},
    {Sample::DrilledBox, "drilled box"},
    {Sample::HollowBox, "hollow box"},
};

std::unique_ptr<GeometricModel> model_of(Sample sample, const char* extension = "brep") {
  const test::TemporaryFolder folder;
  const std::filesystem::path path = folder / (std::string("sample.") + extension);
  test::write_sample(sample, path);
  return std::move(read_model(path).model);
}

Vec2 random_uv(const ParameterBox& box, std::mt19937& random) {
  std::uniform_real_distribution<double> share(0.02, 0.98);
  return {box.lo.u + share(random) * (box.hi.u - box.lo.u), box.lo.v + share(random) * (box.hi.v - box.lo.v)};
}

/// Calls visit(face, random generator) for every face of every sample.
template <class Visit>
void for_each_face(const Visit& visit) {
  std::mt19937 random(11);
  for (const NamedSample& sample : kSamples) {
    const auto model = model_of(sample.sample);
    for (std::size_t i = 0; i < model->topology().face_count(); ++i) {
      INFO(sample.name << ", face " << i + 1);
      visit(*model, ModelFaceId(i), random);
    }
  }
}

}  // namespace

TEST_CASE("loops close and parameter curves lie on their edges, for every kind of surface") {
  for (const NamedSample& sample : kSamples) {
    for (const char* extension : {"brep", "step"}) {
      INFO(sample.name << " " << extension);
      const test::LoopReport report = test::check_loops(*model_of(sample.sample, extension));
      CHECK(report.uses > 0);
      CHECK(report.disconnected == 0);
      CHECK(report.off_curve == 0);
    }
  }
}

TEST_CASE("a STEP file without parameter curves gives the same faces as one with them") {
  const test::TemporaryFolder scratch;
  for (const NamedSample& sample : kSamples) {
    INFO(sample.name);
    test::write_step_without_parameter_curves(sample.sample, scratch / "plain.step");
    const ModelDocument plain = read_model(scratch / "plain.step");
    const auto with_curves = model_of(sample.sample, "step");
    const test::LoopReport report = test::check_loops(*plain.model);
    CHECK(report.uses > 0);
    CHECK(report.disconnected == 0);
    CHECK(report.off_curve == 0);
    for (const Diagnostic& warning : plain.warnings) CHECK(warning.code == ErrorCode::OpenShell);
    CHECK(plain.model->topology().edge_count() == with_curves->topology().edge_count());
    REQUIRE(plain.model->topology().face_count() == with_curves->topology().face_count());
    for (std::size_t i = 0; i < plain.model->topology().face_count(); ++i)
      CHECK(plain.model->area(ModelFaceId(i)) == Approx(with_curves->area(ModelFaceId(i))).epsilon(1e-5));
  }
}

TEST_CASE("derivatives are the limits of differences, and the normal is du x dv") {
  for_each_face([](const GeometricModel& model, ModelFaceId id, std::mt19937& random) {
    const auto face = model.face_geometry(id);
    const ParameterBox box = face->parameter_box();
    for (int i = 0; i < 20; ++i) {
      const Vec2 uv = random_uv(box, random);
      const SurfaceDerivatives d = face->derivatives(uv);
      CHECK(distance(d.point, face->evaluate(uv)) < 1e-12);
      const double hu = 1e-5 * (box.hi.u - box.lo.u), hv = 1e-5 * (box.hi.v - box.lo.v);
      const Vec3 du = (face->evaluate(uv + Vec2{hu, 0}) - face->evaluate(uv - Vec2{hu, 0})) / (2 * hu);
      const Vec3 dv = (face->evaluate(uv + Vec2{0, hv}) - face->evaluate(uv - Vec2{0, hv})) / (2 * hv);
      CHECK(distance(du, d.du) < 1e-5 * (1 + norm(du)));
      CHECK(distance(dv, d.dv) < 1e-5 * (1 + norm(dv)));
      CHECK(distance(face->normal(uv), normalized(cross(d.du, d.dv))) < 1e-9);
    }
  });
}

TEST_CASE("the projection of a point near the surface is the point below it, with a guess and without") {
  for_each_face([](const GeometricModel& model, ModelFaceId id, std::mt19937& random) {
    const auto face = model.face_geometry(id);
    const ParameterBox box = face->parameter_box();
    for (int i = 0; i < 20; ++i) {
      const Vec2 uv = random_uv(box, random);
      const Vec3 foot = face->evaluate(uv), x = foot + 0.05 * face->normal(uv);
      const Vec2 guess = uv + 0.01 * (random_uv(box, random) - uv);
      for (const SurfacePoint& found : {face->closest_point(x, guess), face->closest_point(x, std::nullopt)}) {
        CHECK(distance(found.point, foot) < 1e-6);
        CHECK(found.distance == Approx(0.05).epsilon(1e-6));
        CHECK(distance(face->evaluate(found.uv), found.point) < 1e-12);
      }
      const SurfacePoint near = face->closest_point(foot, guess);
      CHECK(norm(near.uv - uv) < 1e-6 * (norm(box.hi - box.lo) + 1));  // the branch of the guess
    }
  });
}

TEST_CASE("projection finds the way out of a pole") {
  const auto model = model_of(Sample::LoftedSolid);
  const auto sphere_model = model_of(Sample::Sphere);
  const auto sphere = sphere_model->face_geometry(ModelFaceId(0));
  const SurfacePoint found = sphere->closest_point({0, 0, 7}, std::nullopt);
  CHECK(distance(found.point, {0, 0, 5}) < 1e-12);
  CHECK(found.distance == Approx(2));
}

TEST_CASE("curvatures of cylinder, sphere, torus and cone are the known ones") {
  const auto curvatures = [](Sample sample, const Vec3& at) {
    const auto model = model_of(sample);
    SurfacePoint best{{}, {}, HUGE_VAL};
    PrincipalCurvatures result;
    for (std::size_t i = 0; i < model->topology().face_count(); ++i) {
      const auto face = model->face_geometry(ModelFaceId(i));
      const SurfacePoint found = face->closest_point(at, std::nullopt);
      if (found.distance >= best.distance) continue;
      best = found;
      result = face->curvature(found.uv);
    }
    return result;
  };
  const PrincipalCurvatures cylinder = curvatures(Sample::Cylinder, {5, 0, 5});
  CHECK(std::abs(cylinder.largest) == Approx(0.2));
  CHECK(cylinder.smallest == Approx(0).margin(1e-12));
  const PrincipalCurvatures sphere = curvatures(Sample::Sphere, {3, 0, 4});
  CHECK(std::abs(sphere.largest) == Approx(0.2));
  CHECK(std::abs(sphere.smallest) == Approx(0.2));
  const PrincipalCurvatures torus = curvatures(Sample::Torus, {7, 0, 0});
  CHECK(std::abs(torus.largest) == Approx(1.0 / 3));
  CHECK(torus.smallest / torus.largest < 0);
  CHECK(std::abs(torus.smallest) == Approx(1.0 / 7));
  const PrincipalCurvatures splines = curvatures(Sample::SplineSolid, {5, 0, 5});
  CHECK(std::abs(splines.largest) == Approx(0.2));
}

TEST_CASE("normal and curvature are finite at poles and apexes, and the normal is the limit") {
  const auto sphere_model = model_of(Sample::Sphere);
  const auto sphere = sphere_model->face_geometry(ModelFaceId(0));
  for (const double v : {-kPi / 2, kPi / 2}) {
    for (const double u : {0.0, 1.0, 5.0}) {
      CHECK(distance(sphere->normal({u, v}), Vec3{0, 0, v > 0 ? 1.0 : -1.0}) < 1e-6);
      CHECK(std::abs(sphere->curvature({u, v}).largest) == Approx(0.2).epsilon(1e-3));
    }
  }
  const auto cone_model = model_of(Sample::Cone);
  for (std::size_t i = 0; i < cone_model->topology().face_count(); ++i) {
    const auto face = cone_model->face_geometry(ModelFaceId(i));
    for (const Vec2& corner : {face->parameter_box().lo, face->parameter_box().hi}) {
      CHECK(norm(face->normal(corner)) == Approx(1));
      CHECK(std::isfinite(face->curvature(corner).largest));
    }
  }
}

TEST_CASE("poles are degenerate edges with parameter curves and without a curve in space") {
  const auto model = model_of(Sample::Sphere);
  const ModelTopology& topology = model->topology();
  std::size_t degenerate = 0;
  const auto face = model->face_geometry(ModelFaceId(0));
  REQUIRE(topology.face_to_loops.at(0).size() == 1);
  for (const EdgeUse& use : topology.face_to_loops[0][0]) {
    if (!topology.edges[use.edge.value].degenerate) continue;
    ++degenerate;
    const ParameterRange range = face->edge_range(use);
    const Vec2 a = face->edge_parameters(use, range.lo), b = face->edge_parameters(use, range.hi);
    CHECK(norm(b - a) == Approx(2 * kPi));
    CHECK(distance(face->evaluate(a), face->evaluate(b)) < 1e-12);
    CHECK(topology.edges[use.edge.value].vertices[0] == topology.edges[use.edge.value].vertices[1]);
    try {
      model->edge_geometry(use.edge);
      FAIL("a degenerate edge has no geometry");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::EdgeFailed);
      REQUIRE(error.diagnostic().entities.size() == 1);
      CHECK(error.diagnostic().entities[0].entity == ModelEntity(use.edge));
    }
  }
  CHECK(degenerate == 2);
}

TEST_CASE("the two sides of a seam lie a period apart") {
  const auto model = model_of(Sample::Cylinder);
  std::size_t seams = 0;
  for (std::size_t i = 0; i < model->topology().face_count(); ++i) {
    const auto face = model->face_geometry(ModelFaceId(i));
    for (const ModelLoop& loop : model->topology().face_to_loops[i]) {
      for (const EdgeUse& use : loop) {
        if (!use.second_side) continue;
        ++seams;
        EdgeUse other = use;
        other.second_side = false;
        const double t = face->edge_range(use).lo;
        const Vec2 gap = face->edge_parameters(use, t) - face->edge_parameters(other, t);
        CHECK(std::abs(gap.u) == Approx(2 * kPi));
        CHECK(std::abs(gap.u) == Approx(face->period().u));
        CHECK(gap.v == Approx(0).margin(1e-12));
      }
    }
  }
  CHECK(seams == 1);
}

TEST_CASE("edges answer for their points, derivatives, curvatures and projections") {
  std::mt19937 random(5);
  for (const NamedSample& sample : kSamples) {
    const auto model = model_of(sample.sample);
    for (std::size_t i = 0; i < model->topology().edge_count(); ++i) {
      if (model->topology().edges[i].degenerate) continue;
      INFO(sample.name << ", edge " << i + 1);
      const auto edge = model->edge_geometry(ModelEdgeId(i));
      const ParameterRange range = edge->range();
      const auto& ends = model->topology().edges[i].vertices;
      CHECK(distance(edge->evaluate(range.lo), model->vertex_point(ends[0])) < 1e-6);
      CHECK(distance(edge->evaluate(range.hi), model->vertex_point(ends[1])) < 1e-6);
      for (int k = 0; k < 10; ++k) {
        const double t = std::uniform_real_distribution<double>(range.lo, range.hi)(random);
        const double h = 1e-5 * (range.hi - range.lo);
        const Vec3 d = (edge->evaluate(t + h) - edge->evaluate(t - h)) / (2 * h);
        CHECK(distance(d, edge->derivative(t)) < 1e-4 * (1 + norm(d)));
        CHECK(edge->closest_point(edge->evaluate(t)).distance < 1e-8);
        CHECK(std::isfinite(edge->curvature(t)));
      }
      const CurvePoint beyond = edge->closest_point({1000, 2000, -500});
      CHECK(beyond.t >= range.lo);
      CHECK(beyond.t <= range.hi);
    }
  }
  const auto cylinder = model_of(Sample::Cylinder);
  std::size_t circles = 0;
  for (std::size_t i = 0; i < cylinder->topology().edge_count(); ++i) {
    const auto edge = cylinder->edge_geometry(ModelEdgeId(i));
    if (edge->period() == 0) continue;
    ++circles;
    CHECK(edge->curvature(1) == Approx(0.2));
    CHECK(edge->period() == Approx(2 * kPi));
  }
  CHECK(circles == 2);
}

TEST_CASE("facets cover the face, turn with it, and know what they lie on") {
  for_each_face([](const GeometricModel& model, ModelFaceId id, std::mt19937&) {
    const auto face = model.face_geometry(id);
    const Tessellation facets = face->tessellate(0.01, 0.2);
    REQUIRE(facets.points.size() == facets.uv.size());
    REQUIRE(facets.points.size() == facets.classification.size());
    REQUIRE(facets.points.size() == facets.edge_parameter.size());
    double area = 0;
    std::size_t flipped = 0;
    for (const auto& tri : facets.tri_to_vert) {
      const Vec3 n =
          cross(facets.points[tri[1]] - facets.points[tri[0]], facets.points[tri[2]] - facets.points[tri[0]]);
      area += 0.5 * norm(n);
      const Vec2 middle = (1.0 / 3) * (facets.uv[tri[0]] + facets.uv[tri[1]] + facets.uv[tri[2]]);
      if (dot(n, face->normal(middle)) < 0) ++flipped;
    }
    CHECK(flipped == 0);
    CHECK(area == Approx(model.area(id)).epsilon(0.01));
    std::map<ModelEntity, std::size_t> found;
    for (std::size_t i = 0; i < facets.points.size(); ++i) {
      CHECK(distance(facets.points[i], face->evaluate(facets.uv[i])) < 1e-5);
      const ModelEntity on = facets.classification[i];
      ++found[on];
      if (on.dim == 0) CHECK(distance(model.vertex_point(ModelVertexId(on.index)), facets.points[i]) < 1e-5);
      if (on.dim == 1) {
        const auto edge = model.edge_geometry(ModelEdgeId(on.index));
        CHECK(distance(edge->evaluate(facets.edge_parameter[i]), facets.points[i]) < 1e-5);
      }
      if (on.dim == 2) CHECK(on == ModelEntity(id));
    }
    for (const ModelLoop& loop : model.topology().face_to_loops[id.value])
      for (const EdgeUse& use : loop)
        for (const ModelVertexId vertex : model.topology().edges[use.edge.value].vertices)
          CHECK(found.count(vertex) == 1);
  });
}

TEST_CASE("senseless facet sizes are invalid arguments with the face") {
  const auto model = model_of(Sample::Sphere);
  const auto face = model->face_geometry(ModelFaceId(0));
  for (const double chord : {0.0, -1.0, std::nan("")}) {
    try {
      face->tessellate(chord, 0.2);
      FAIL("no error");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::InvalidArgument);
      REQUIRE(error.diagnostic().entities.size() == 1);
      CHECK(error.diagnostic().entities[0].entity == ModelEntity(2, 0));
    }
  }
}

TEST_CASE("areas and volumes are the known ones") {
  CHECK(model_of(Sample::Sphere)->volume(ModelRegionId(0)) == Approx(4.0 / 3 * kPi * 125).epsilon(1e-4));
  CHECK(model_of(Sample::Torus)->volume(ModelRegionId(0)) == Approx(2 * kPi * kPi * 10 * 9).epsilon(1e-4));
  CHECK(model_of(Sample::Cone)->volume(ModelRegionId(0)) == Approx(kPi * 25 * 10 / 3).epsilon(1e-4));
  CHECK(model_of(Sample::SplineSolid)->volume(ModelRegionId(0)) == Approx(kPi * 250).epsilon(1e-4));
  CHECK(model_of(Sample::Sphere)->area(ModelFaceId(0)) == Approx(4 * kPi * 25).epsilon(1e-4));
}

TEST_CASE("the bounding box is tight") {
  const Box3 torus = model_of(Sample::Torus)->bounding_box();
  CHECK(distance(torus.lo, {-13, -13, -3}) < 1e-4);
  CHECK(distance(torus.hi, {13, 13, 3}) < 1e-4);
  const auto model = model_of(Sample::LoftedSolid);
  Box3 points;
  for (std::size_t i = 0; i < model->topology().face_count(); ++i)
    for (const Vec3& p : model->face_geometry(ModelFaceId(i))->tessellate(0.01, 0.1).points) points.add(p);
  CHECK(distance(points.lo, model->bounding_box().lo) < 0.05);
  CHECK(distance(points.hi, model->bounding_box().hi) < 0.05);
}

TEST_CASE("threads with objects of their own get the same answers") {
  for (const NamedSample& sample : kSamples) {
    INFO(sample.name);
    const auto model = model_of(sample.sample);
    const auto answers = [&] {
      std::vector<Vec3> points;
      for (std::size_t i = 0; i < model->topology().face_count(); ++i) {
        const auto face = model->face_geometry(ModelFaceId(i));
        std::mt19937 random(3);
        for (int k = 0; k < 50; ++k) {
          const Vec2 uv = random_uv(face->parameter_box(), random);
          points.push_back(face->derivatives(uv).du);
          points.push_back(face->closest_point(face->evaluate(uv), std::nullopt).point);
        }
        for (const Vec3& p : face->tessellate(0.1, 0.3).points) points.push_back(p);
        points.push_back({model->area(ModelFaceId(i)), 0, 0});
      }
      for (std::size_t i = 0; i < model->topology().edge_count(); ++i)
        if (!model->topology().edges[i].degenerate)
          points.push_back(model->edge_geometry(ModelEdgeId(i))->closest_point({1, 2, 3}).point);
      for (std::size_t i = 0; i < model->topology().region_count(); ++i)
        points.push_back({model->volume(ModelRegionId(i)), 0, 0});
      return points;
    };
    std::array<std::vector<Vec3>, 3> results;
    std::vector<std::thread> threads;
    for (std::vector<Vec3>& result : results) threads.emplace_back([&] { result = answers(); });
    for (std::thread& thread : threads) thread.join();
    const std::vector<Vec3> alone = answers();
    for (const std::vector<Vec3>& result : results) CHECK((result == alone));
  }
}

TEST_CASE("evaluation is fast enough for the inner loop of a mesher") {
  for (const Sample sample : {Sample::Torus, Sample::LoftedSolid}) {
    const auto model = model_of(sample);
    const auto face = model->face_geometry(ModelFaceId(0));
    const ParameterBox box = face->parameter_box();
    constexpr int count = 200000;
    Vec3 sum;
    const std::clock_t start = std::clock();
    for (int i = 0; i < count; ++i) {
      const double a = (i % 997) / 997.0, b = (i % 991) / 991.0;
      sum += face->derivatives({box.lo.u + a * (box.hi.u - box.lo.u), box.lo.v + b * (box.hi.v - box.lo.v)}).du;
    }
    const double seconds = static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
    std::printf("derivatives of %s: %.0f ns\n", sample == Sample::Torus ? "a torus" : "a B-spline",
                1e9 * seconds / count);
    CHECK(is_finite(sum));
    CHECK(seconds / count < 20e-6);  // of the processor; generous for sanitizers
  }
}
