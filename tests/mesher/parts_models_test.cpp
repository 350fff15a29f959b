// Real CAD models filled in parts of a few thousand tets: nothing is given up, and threads do not matter. Skipped with
// a message where the models are not there.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <tuple>

#include "tests/mesher/real_models.hpp"
#include "tetloom/check.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
namespace fs = std::filesystem;

namespace {

MeshResult make(const GeometricModel& model, double relative_size, double tets_per_part, int threads) {
  MeshOptions options;
  options.sizes.relative_size = relative_size;
  options.tets_per_part = tets_per_part;
  options.threads = threads;
  return make_mesh(model, options);
}

void check_valid(const MeshResult& result) {
  for (const Diagnostic& error : result.errors) UNSCOPED_INFO(error.message);
  REQUIRE(result.status == MeshStatus::Ok);
  CHECK(validate_mesh(result.mesh).problems.empty());
  CHECK(result.filling.worker_complexes == 0);
  INFO(result.filling.parts.given_up_why);
  CHECK(result.filling.parts.given_up == 0);
}

}  // namespace

TEST_CASE("all real models are filled in parts", "[all]") {
  const std::vector<fs::path> models = test::list_real_models();
  if (models.empty()) {
    WARN("skipped: no models in " << test::kRealModels);
    return;
  }
  for (const fs::path& file : models) {
    INFO(file);
    const ModelDocument document = read_model(file);
    const MeshResult result = make(*document.model, 0.02, 3e3, 2);
    check_valid(result);
    CHECK(result.filling.parts.parts > 1);
  }
}

// Among them those where tets reach over several parts, where many triangles are missing, and where surfaces change.
TEST_CASE("a real model filled in parts is the same for any number of threads", "[threads]") {
  bool any = false;
  for (const char* name : {"OCCT__step_linkrods.step", "elmerfem__step_fusee.stp", "OCCT__occ_CrankArm.brep",
                           "build123d__docs_M6-1x12-countersunk-screw.step"}) {
    const fs::path file = test::kRealModels / name;
    if (!fs::exists(file)) continue;
    any = true;
    INFO(file);
    const ModelDocument document = read_model(file);
    const MeshResult one = make(*document.model, 0.025, 2e3, 1);
    check_valid(one);
    CHECK(one.filling.parts.parts > 2);
    for (const int threads : {2, 4}) {
      const MeshResult other = make(*document.model, 0.025, 2e3, threads);
      CHECK(mesh_digest(other.mesh) == mesh_digest(one.mesh));
      CHECK((other.mesh.tet_to_vert == one.mesh.tet_to_vert));
    }
  }
  if (!any) WARN("skipped: no models in " << test::kRealModels);
}

// Of the first two, triangles are missing all over the model; of the third, the surface has to change between parts.
TEST_CASE("the worst tet of a real model is as good in parts as in one", "[worst]") {
  bool any = false;
  for (const auto& [name, size, tets_per_part] : {std::tuple{"elmerfem__step_pump_carter_sup.stp", 0.015, 2e4},
                                                  {"netgen__tutorials_frame.step", 0.015, 2e4},
                                                  {"tigl__TestData_simplewing.brep", 0.008, 1e5}}) {
    const fs::path file = test::kRealModels / name;
    if (!fs::exists(file)) continue;
    any = true;
    INFO(file);
    const ModelDocument document = read_model(file);
    const MeshResult one = make(*document.model, size, HUGE_VAL, 2),
                     parts = make(*document.model, size, tets_per_part, 2);
    check_valid(parts);
    CHECK(parts.filling.parts.parts > 1);
    CHECK(parts.filling.optimizer.least > 0.9 * one.filling.optimizer.least);
  }
  if (!any) WARN("skipped: no models in " << test::kRealModels);
}

// The tets of a patch of recovered triangles belong to many parts.
TEST_CASE("poor tets at a patch that reaches far into other parts move, too", "[strips]") {
  const fs::path file = test::kRealModels / "Voron-0__Electronics_Mounts_SKR_3_EZ_Din_Mount.step";
  if (!fs::exists(file)) {
    WARN("skipped: no models in " << test::kRealModels << " with " << file.filename());
    return;
  }
  const ModelDocument document = read_model(file);
  MeshOptions options;
  options.sizes.relative_size = 0.0125;
  options.tets_per_part = 5e3;
  options.threads = 2;
  options.most_refinement = HUGE_VAL;
  options.keep_small_features = true;  // they leave the poor tets
  const MeshResult result = make_mesh(*document.model, options);
  check_valid(result);
  const auto& strips = result.filling.parts.strips;
  CHECK(strips[0].waiting > 500);
  CHECK(strips[0].moved > 1000);
  CHECK(strips[1].waiting < strips[0].waiting / 10);
}
