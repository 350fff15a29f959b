// Volumes filled from either lattice.
#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

VolumeMesh fill(const Surface& surface, double size, LatticeKind lattice, int threads = 2) {
  const SizeField sizes = SizeField::uniform(size);
  VolumeOptions options{TETLOOM_WORKER};
  options.lattice = lattice;
  return fill_volume(surface.input(sizes), options, TaskRunner(threads));
}

}  // namespace

TEST_CASE("an A15 lattice fills a ball with fewer and better tets, whatever the number of threads") {
  const Surface ball = ball_surface(5, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
  const VolumeMesh bcc = fill(ball, 0.06, LatticeKind::Bcc), a15 = fill(ball, 0.06, LatticeKind::A15);
  REQUIRE(a15.errors.empty());
  CHECK(check_filling(ball, a15).at(0) == Approx(check_filling(ball, bcc).at(0)).epsilon(1e-9));
  const double ratio = double(a15.tet_to_vert.size()) / double(bcc.tet_to_vert.size());
  CHECK(ratio < 0.97);
  CHECK(ratio > 0.90);
  CHECK(a15.figures.optimizer.mean > bcc.figures.optimizer.mean + 0.01);
  CHECK(double(a15.figures.core_tets) > 0.6 * double(a15.tet_to_vert.size()));
  CHECK(a15.tet_to_vert == fill(ball, 0.06, LatticeKind::A15, 1).tet_to_vert);
}

TEST_CASE("random star-shaped bodies are filled from an A15 lattice") {
  const unsigned seed = 815;
  CAPTURE(seed);
  std::mt19937_64 engine(seed);
  for (int body = 0; body < (test::kSanitized ? 12 : 30); ++body) {
    CAPTURE(body);
    std::uniform_real_distribution<double> radius(body % 2 == 0 ? 0.8 : 0.3, 1);
    const Surface surface = ball_surface(2 + body % 3, {0, 0, 0}, 0, [&](const Vec3&) { return radius(engine); });
    const VolumeMesh mesh = fill(surface, 0.3, LatticeKind::A15);
    REQUIRE(mesh.errors.empty());
    CHECK(mesh.figures.worker_complexes == 0);
    double expected = 0;
    for (const auto& [a, b, c] : surface.tri_to_vert)
      expected += dot(surface.points[a], cross(surface.points[b], surface.points[c])) / 6;
    CHECK(check_filling(surface, mesh).at(0) == Approx(expected).epsilon(1e-9));
  }
}
