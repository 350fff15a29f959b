// Boundaries that follow models of OpenCASCADE.
#include "tests/adapt/cad_snapping.hpp"
#include "tests/cad/cad_samples.hpp"
#include "tests/mesher/real_models.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;

namespace {

std::unique_ptr<GeometricModel> sample_model(test::Sample sample) {
  const test::TemporaryFolder folder;
  test::write_sample(sample, folder / "x.brep");
  return std::move(read_model(folder / "x.brep").model);
}

// Runs on a model that lies beside the sources, where it does.
void check_real_model(const char* name, double h) {
  const auto file = test::kRealModels / name;
  if (!std::filesystem::exists(file)) {
    WARN("'" << file.string() << "' is not there: skipped");
    return;
  }
  test::check_halvings(name, *read_model(file).model, h, 4);
}

}  // namespace

TEST_CASE("a refined cylinder of B-splines stays one", "[short]") {
  test::check_halvings("cylinder of B-splines", *sample_model(test::Sample::SplineSolid), 4, 2);
}

TEST_CASE("sizes of a cylinder halve four times", "[long]") {
  test::check_halvings("cylinder", *sample_model(test::Sample::Cylinder), 4, 4);
}

TEST_CASE("sizes of a sphere halve four times", "[long]") {
  test::check_halvings("sphere", *sample_model(test::Sample::Sphere), 4, 4);
}

TEST_CASE("sizes of a cylinder of B-splines halve four times", "[long]") {
  test::check_halvings("cylinder of B-splines", *sample_model(test::Sample::SplineSolid), 4, 4);
}

TEST_CASE("sizes of a quarter of a pipe halve four times", "[long]") {
  check_real_model("refine__uniform_annulus.brep", 0.12);
}

TEST_CASE("sizes of a wing of B-splines halve four times", "[long]") {
  check_real_model("tigl__TestData_simplewing.brep", 0.2);
}
