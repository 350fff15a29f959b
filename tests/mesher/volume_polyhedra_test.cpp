// Thousands of random polyhedra filled by our own means, judged by their triangles, volumes and orientations.
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/random_polyhedra.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

constexpr std::uint64_t kSeeds = test::kSanitized ? 8 : 207;

struct Tally {
  int tried = 0, refused = 0;
};

// What cannot be filled has to be told with triangles and a place.
void check_refusal(const RandomPolyhedra::Made& made, const VolumeMesh& mesh) {
  CHECK(mesh.tet_to_vert.empty());
  for (const Diagnostic& error : mesh.errors) {
    CHECK(error.code == ErrorCode::VolumeFailed);
    CHECK(error.point);
    CHECK(!error.elements.empty());
    for (const std::uint64_t triangle : error.elements) CHECK(triangle < made.surface.tri_to_vert.size());
  }
}

void try_one(const RandomPolyhedra::Made& made, Tally& tally) {
  const TaskRunner runner(1);
  if (!find_self_intersections({made.surface.points, made.surface.tri_to_vert, {}, 1}, runner).empty()) return;
  ++tally.tried;
  const SizeField sizes = SizeField::uniform(made.size);
  const VolumeMesh mesh = fill_volume(made.surface.input(sizes), {}, runner);
  CHECK(mesh.figures.worker_complexes == 0);
  if (!mesh.errors.empty()) {
    ++tally.refused;
    return check_refusal(made, mesh);
  }
  auto volumes = check_filling(made.surface, mesh);
  for (const auto& [region, volume] : enclosed_volumes(made.surface))
    CHECK(volumes[region] == Approx(volume).epsilon(1e-9));
}

}  // namespace

TEST_CASE("random polyhedra of all kinds are filled with each triangle a face of the mesh") {
  int tried = 0;
  for (int kind = 0; kind < RandomPolyhedra::kKinds; ++kind) {
    Tally tally;
    std::string name, refused;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      const RandomPolyhedra::Made made = RandomPolyhedra(seed * 16 + static_cast<std::uint64_t>(kind)).make(kind);
      INFO(made.kind << ", seed " << seed);
      const int before = tally.refused;
      try_one(made, tally);
      if (tally.refused > before) refused += " " + std::to_string(seed);
      name = made.kind;
    }
    INFO(name << ", seeds refused:" << refused);
    // Triangles of 1e-12 of their length in height leave no room that doubles can name.
    CHECK(tally.refused * 100 <= (kind == RandomPolyhedra::kNeedles ? tally.tried : 0));
    tried += tally.tried;
  }
  CHECK(tried >= (test::kSanitized ? 70 : 2000));
}

TEST_CASE("polyhedra that could not be filled before are") {
  struct Found {
    int kind;
    std::uint64_t seed;
  };
  // Caps of twisted prisms, triangles of a ten-thousandth of others, needles.
  for (const Found& found : {Found{5, 214},
                             {5, 223},
                             {5, 266},
                             {5, 295},
                             {5, 372},
                             {5, 456},
                             {5, 459},
                             {5, 979},
                             {9, 4},
                             {9, 618},
                             {9, 658},
                             {6, 13},
                             {6, 36},
                             {6, 78},
                             {6, 111},
                             {6, 196},
                             {6, 434}}) {
    INFO("kind " << found.kind << ", seed " << found.seed);
    RandomPolyhedra::Made made =
        RandomPolyhedra(found.seed * 16 + static_cast<std::uint64_t>(found.kind)).make(found.kind);
    if (made.kind == "twisted prism") made.size = 0.8;
    Tally tally;
    try_one(made, tally);
    CHECK(tally.tried == 1);
    CHECK(tally.refused == 0);
  }
}
