// Models with random parameters are meshed, or refused with a place; what is meshed is right. Each section is a family:
// `families_test [short] -c fillets` runs one, and `TETLOOM_SEEDS=13:1 families_test [short] -c fillets` one model,
// from seed 13 on. make_family_models writes models to files.
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <string>
#include <string_view>

#include "core/base/disjoint_sets.hpp"
#include "mesher/sizing/build_size_field.hpp"
#include "tests/support/families/family.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using test::Family;
using test::FamilyModel;
using test::FamilyScale;

namespace {

constexpr double kSharpAngle = 5;  // degrees; what is below must have a cause
constexpr double kSurfaceTets = 20'000;
constexpr std::uint64_t kThreadsEvery = 8;  // of so many models, one is meshed by two threads as well

MeshOptions options_for(const FamilyModel& model, int threads) {
  MeshOptions options;
  options.sizes.relative_size = model.relative_size;
  options.sizes.curvature = model.curvature;
  options.threads = threads;
  options.volume_worker = TETLOOM_WORKER;
  return options;
}

/// What a user is told when nothing is made of a model must say where.
void check_refusal(const Diagnostic& error, const FamilyModel& model) {
  INFO("refused: " << error.message);
  CHECK_FALSE(model.sound);
  CHECK_FALSE(error.message.empty());
  CHECK((!error.entities.empty() || error.point.has_value()));
}

/// A mesh with a small angle says what of the model forces it.
void check_angles(const MeshResult& result, const QualityReport& quality) {
  if (quality.tets.min_dihedral_deg >= kSharpAngle) return;
  const auto& worst = result.filling.optimizer.acute_tets;
  CHECK_FALSE(worst.empty());
  if (worst.empty()) return;
  INFO("angle " << worst[0].angle << " at (" << worst[0].point.x << ", " << worst[0].point.y << ", " << worst[0].point.z
                << ")");
  CHECK(quality.tets.min_dihedral_deg > 0);
  CHECK(worst[0].cause != AngleCause::NotForced);
}

/// No more tets than twice what the sizes ask for in the whole box, and some that any surface takes.
void check_count(std::size_t tets, const GeometricModel& geometry, const FamilyModel& model) {
  const SizeField asked = build_size_field(geometry, options_for(model, 1).sizes, {}, TaskRunner(1));
  CHECK(static_cast<double>(tets) <= 2 * asked.estimate_tets(geometry.bounding_box()) + kSurfaceTets);
  if (model.most_tets > 0) CHECK(static_cast<double>(tets) <= model.most_tets);
}

void check_mesh(const MeshResult& result, const GeometricModel& geometry, const FamilyModel& model) {
  const ValidationReport validation = validate_mesh(result.mesh);
  if (!validation.valid()) UNSCOPED_INFO(validation.problems[0].message);
  CHECK(validation.valid());
  const QualityReport quality = compute_quality(result.mesh);
  std::printf(" %zu tets, %.3f degrees, %d rounds", quality.tets.count, quality.tets.min_dihedral_deg,
              result.refinement.rounds);
  CHECK(quality.cells.inverted == 0);
  CHECK(quality.cells.regions.size() == geometry.topology().region_count());
  if (!model.sound) return;
  CHECK(quality.cells.regions.size() == model.solids);
  CHECK(quality.tets.volume == Approx(model.volume).epsilon(model.volume_tolerance));
  check_angles(result, quality);
  check_count(quality.tets.count, geometry, model);
}

/// Into how many pieces the triangles of a face fall that share edges.
std::size_t pieces_of_face(const Mesh& mesh, std::uint32_t face) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edge_to_triangle;
  DisjointSets sets(mesh.tri_to_vert.size());
  std::vector<std::uint32_t> triangles;
  for (std::uint32_t t = 0; t < mesh.tri_to_vert.size(); ++t) {
    if (mesh.tri_to_entity[t] != face) continue;
    triangles.push_back(t);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto [low, high] = std::minmax(mesh.tri_to_vert[t][i], mesh.tri_to_vert[t][(i + 1) % 3]);
      sets.join(t, edge_to_triangle.try_emplace({low, high}, t).first->second);
    }
  }
  return static_cast<std::size_t>(std::ranges::count_if(triangles, [&](auto t) { return sets.find(t) == t; }));
}

/// What is read is what was made.
void check_reading(const GeometricModel& geometry, const FamilyModel& model) {
  if (!model.sound) return;
  double volume = 0;
  for (std::size_t r = 0; r < geometry.topology().region_count(); ++r) volume += geometry.volume(ModelRegionId(r));
  CHECK(geometry.topology().region_count() == model.solids);
  CHECK(volume == Approx(model.volume).epsilon(model.volume_tolerance));
}

/// Reading may refuse a model that is not sound; so may meshing.
void check_model(const FamilyModel& model, bool with_threads) {
  try {
    const ModelDocument document = read_model(model.file);
    check_reading(*document.model, model);
    const MeshResult result = make_mesh(*document.model, options_for(model, 1));
    if (result.status != MeshStatus::Ok) {
      CHECK_FALSE(result.errors.empty());
      for (const Diagnostic& error : result.errors) check_refusal(error, model);
      return;
    }
    check_mesh(result, *document.model, model);
    if (!with_threads) return;
    const MeshResult again = make_mesh(*document.model, options_for(model, 2));
    CHECK(mesh_digest(again.mesh) == mesh_digest(result.mesh));
  } catch (const Error& error) {
    check_refusal(error.diagnostic(), model);
  }
}

struct Seeds {
  std::uint64_t first = 1, count = 0;
};

/// Those of the environment's TETLOOM_SEEDS=FIRST:COUNT, or as many as `count` says.
Seeds seeds_to_try(std::uint64_t count) {
  const char* text = std::getenv("TETLOOM_SEEDS");
  unsigned long long first = 1, wanted = count;
  if (text != nullptr) REQUIRE(std::sscanf(text, "%llu:%llu", &first, &wanted) == 2);
  return {first, wanted};
}

void check_family(const Family& family, const Seeds& seeds, FamilyScale scale) {
  for (std::uint64_t seed = seeds.first; seed < seeds.first + seeds.count; ++seed) {
    // Told before, so that a run that does not end says where it is.
    std::printf("%s %llu:", family.name, static_cast<unsigned long long>(seed));
    std::fflush(stdout);
    const test::TemporaryFolder folder;
    const FamilyModel model = family.make(seed, scale, folder.path());
    INFO(family.name << ", seed " << seed << ": " << model.what);
    check_model(model, seed % kThreadsEvery == 0);
    std::printf("\n");
  }
}

}  // namespace

TEST_CASE("small models of all families are meshed, or refused with a place", "[short]") {
  for (const Family& family : test::all_families()) DYNAMIC_SECTION(family.name) {
      check_family(family, seeds_to_try(test::kSanitized ? 3 : 24), FamilyScale::Small);
    }
}

TEST_CASE("the faces of tubes thinner than the sizes stay in one piece", "[coarse]") {
  for (const std::uint64_t seed : {6, 11}) {
    const test::TemporaryFolder folder;
    const FamilyModel model = test::family_named("tubes").make(seed, FamilyScale::Small, folder.path());
    const ModelDocument document = read_model(model.file);
    MeshOptions options;
    options.sizes.size = 0.15 * norm(document.model->bounding_box().hi - document.model->bounding_box().lo);
    options.surface_only = true;
    options.refine_surface = false;
    const MeshResult result = make_mesh(*document.model, options);
    REQUIRE(result.status == MeshStatus::Ok);
    for (std::uint32_t f = 0; f < document.model->topology().face_count(); ++f) {
      INFO("seed " << seed << ", face " << f);
      CHECK(pieces_of_face(result.mesh, f) == 1);
    }
  }
}

TEST_CASE("models of all families are meshed, or refused with a place, thousands of them", "[long]") {
  for (const Family& family : test::all_families()) DYNAMIC_SECTION(family.name) {
      check_family(family, seeds_to_try(200), FamilyScale::Full);
    }
}
