// The nearest places on models of which several parts lie near each other.
#include <catch2/catch.hpp>
#include <random>

#include "core/geometry/model_projector.hpp"
#include "tests/support/families/family.hpp"
#include "tests/support/temporary_folder.hpp"

using namespace tetloom;

TEST_CASE("the nearest place on a thread does not depend on what was asked before") {
  const test::TemporaryFolder folder;
  for (std::uint64_t seed = 0; seed < 12; ++seed) {
    const test::FamilyModel thread = test::family_named("threads").make(seed, test::FamilyScale::Full, folder.path());
    INFO("seed " << seed << ": " << thread.what);
    const ModelDocument document = read_model(thread.file);
    const GeometricModel& model = *document.model;
    const double near = 1e-5 * model.bounding_box().diagonal();
    const SurfaceProjector project = make_projector(model);
    std::mt19937 random(static_cast<unsigned>(seed));
    std::uniform_real_distribution<double> share(0.02, 0.98);
    for (std::size_t f = 0; f < model.topology().face_count(); ++f) {
      const auto face = model.face_geometry(ModelFaceId(f));
      const ParameterBox box = face->parameter_box();
      for (int i = 0; i < 80; ++i) {
        const double u = share(random), v = share(random);
        const Vec3 x = face->evaluate({box.lo.u + u * (box.hi.u - box.lo.u), box.lo.v + v * (box.hi.v - box.lo.v)});
        const auto spot = project(ModelFaceId(f), x);
        REQUIRE(spot.has_value());
        CHECK(distance(spot->point, x) < near);
      }
    }
    for (std::size_t e = 0; e < model.topology().edge_count(); ++e) {
      if (model.topology().edges[e].degenerate) continue;
      const auto edge = model.edge_geometry(ModelEdgeId(e));
      const ParameterRange range = edge->range();
      for (int i = 0; i < 80; ++i) {
        const Vec3 x = edge->evaluate(range.lo + share(random) * (range.hi - range.lo));
        const auto spot = project(ModelEdgeId(e), x);
        REQUIRE(spot.has_value());
        CHECK(distance(spot->point, x) < near);
      }
    }
  }
}
