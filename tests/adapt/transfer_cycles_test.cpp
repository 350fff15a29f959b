// Fields on meshes that are adapted again and again.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <map>

#include "adapt/transfer/clip_tet.hpp"
#include "tests/adapt/meshed.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/support/analytic_model.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/support/sanitized.hpp"
#include "tetloom/adapt.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

constexpr int kCycles = 10;
using Metric = std::function<Tensor(const Vec3&)>;
using Field = std::function<double(const Vec3&)>;

double volume_at(const Mesh& mesh, std::uint32_t tet) { return volume_of(corners_of(tets_of(mesh), tet)); }

void add_cell_field(Mesh& mesh, const std::string& name, const Field& field) {
  MeshField values{name, 1, {}};
  for (std::uint32_t tet = 0; tet < mesh.tet_to_vert.size(); ++tet)
    values.values.push_back(field(center_of(corners_of(tets_of(mesh), tet))));
  mesh.cell_fields.push_back(std::move(values));
}

void add_point_field(Mesh& mesh, const std::string& name, const Field& field) {
  MeshField values{name, 1, {}};
  for (const Vec3& x : mesh.points) values.values.push_back(field(x));
  mesh.point_fields.push_back(std::move(values));
}

/// The integral of every field on tets, by region, and that of its magnitude.
struct Integral {
  double value = 0, magnitude = 0;
};

std::map<std::pair<std::string, std::uint32_t>, Integral> integrals(const Mesh& mesh) {
  std::map<std::pair<std::string, std::uint32_t>, Integral> sums;
  for (const MeshField& field : mesh.cell_fields)
    for (std::uint32_t tet = 0; tet < mesh.tet_to_vert.size(); ++tet) {
      const double value = volume_at(mesh, tet) * field.values[tet];
      Integral& sum = sums[{field.name, mesh.tet_to_entity[tet]}];
      sum.value += value, sum.magnitude += std::abs(value);
    }
  return sums;
}

void check_kept(const Mesh& before, const Mesh& after) {
  const auto old = integrals(before), now = integrals(after);
  REQUIRE(now.size() == old.size());
  for (const auto& [key, integral] : old) {
    CAPTURE(key.first, key.second, integral.value, integral.magnitude);
    CHECK(std::abs(now.at(key).value - integral.value) <= 1e-12 * integral.magnitude);
  }
}

/// Adapts to metric_of(0), metric_of(1) … with all fields.
Mesh cycled(Mesh mesh, const std::function<Metric(int)>& metric_of, AdaptOptions options, int cycles = kCycles) {
  for (const auto* fields : {&mesh.point_fields, &mesh.cell_fields})
    for (const MeshField& field : *fields) options.transfer.push_back(field.name);
  for (int cycle = 0; cycle < cycles; ++cycle) {
    AdaptResult result = adapt_mesh(mesh, metric_of(cycle), options);
    for (const Diagnostic& error : result.errors) FAIL_CHECK(error.message);
    REQUIRE(result.status == AdaptStatus::Ok);
    REQUIRE(result.report.transfers.size() == options.transfer.size());
    mesh = std::move(result.mesh);
  }
  return mesh;
}

/// Fine to and fro.
Metric size_of_cycle(int cycle, double h) {
  return [=](const Vec3& x) { return isotropic(h * (1.2 + 0.4 * std::sin(5 * x.x + 3 * x.y + 2.0 * cycle))); };
}

/// A layer of a fiftieth of its length that turns around.
Metric layer_of_cycle(int cycle) {
  const double angle = 0.5 * cycle;
  const Vec3 normal{std::cos(angle), 0, std::sin(angle)};
  return [=](const Vec3& x) {
    const double h = 0.005 + 0.3 * std::abs(dot(normal, x - Vec3{0.5, 0.5, 0.5}));
    return isotropic(0.25) + outer(normal, std::max(0.0, 1 / (h * h) - 16));
  };
}

}  // namespace

TEST_CASE("integrals are kept over ten adaptations of a cube, and bounds", "[transfer]") {
  const bool anisotropic = GENERATE(false, true);
  AdaptOptions options;
  options.cell_reconstruction = GENERATE(adapt::CellReconstruction::Constant, adapt::CellReconstruction::Linear);
  CAPTURE(anisotropic, static_cast<int>(options.cell_reconstruction));
  Mesh cube = test::make_unit_cube(6, true);
  add_cell_field(cube, "constant", [](const Vec3&) { return 0.3; });
  add_cell_field(cube, "smooth", [](const Vec3& x) { return std::sin(4 * x.x) - x.y * x.z; });
  add_cell_field(cube, "jump", [](const Vec3& x) { return x.x + x.y > 0.7 ? 7.0 : 2.0; });
  const Mesh result = cycled(
      cube, [&](int cycle) { return anisotropic ? layer_of_cycle(cycle) : size_of_cycle(cycle, 0.12); }, options);
  check_kept(cube, result);
  for (const double value : result.cell_fields[0].values) CHECK(value == Approx(0.3).epsilon(1e-12));
  for (const double value : result.cell_fields[2].values) CHECK((value > 2 - 1e-11 && value < 7 + 1e-11));
}

TEST_CASE("each region keeps what it has over ten adaptations", "[transfer]") {
  Mesh cube = test::make_unit_cube(6, true);
  MeshField field{"one or the other", 1, {}};
  for (const std::uint32_t region : cube.tet_to_entity) field.values.push_back(region == 0 ? -3 : 40);
  cube.cell_fields = {field};
  const Mesh result = cycled(cube, [](int cycle) { return size_of_cycle(cycle, 0.15); }, {});
  for (std::size_t tet = 0; tet < result.tet_to_vert.size(); ++tet)
    CHECK(result.cell_fields[0].values[tet] == Approx(result.tet_to_entity[tet] == 0 ? -3 : 40).epsilon(1e-12));
}

TEST_CASE("integrals are kept over ten adaptations of a curved part", "[transfer]") {
  const auto model = test_models::make_cylinder(1, 2);
  Mesh part = test::meshed(*model, 0.5);
  add_cell_field(part, "smooth", [](const Vec3& x) { return std::sin(4 * x.x) - x.y * x.z; });
  add_cell_field(part, "mass", [](const Vec3& x) { return x.x > 0 ? 5 + x.z : 0.0; });
  AdaptOptions options;
  options.model = model.get();
  const auto metric = [](int cycle) { return [=](const Vec3&) { return isotropic(cycle % 2 ? 0.5 : 0.25); }; };
  const Mesh result = cycled(part, metric, options);
  check_kept(part, result);
  const auto& mass = result.cell_fields[1].values;
  for (const double value : mass) CHECK((value >= 0 && value < 7.5));
}

TEST_CASE("fields are carried over under any metric", "[transfer]") {
  const auto [aspect, h] = GENERATE(std::pair(1e2, 2.0), std::pair(1e4, 90.0));
  CAPTURE(aspect);
  Mesh cube = test::make_unit_cube(6, true);
  add_cell_field(cube, "constant", [](const Vec3&) { return 0.3; });
  add_cell_field(cube, "jump", [](const Vec3& x) { return x.x + x.y > 0.7 ? 7.0 : 2.0; });
  RandomTensors random(4);
  Mesh mesh = cube;
  for (int cycle = 0; cycle < 4; ++cycle) {
    std::vector<Tensor> tensors;
    for (std::size_t v = 0; v < mesh.points.size(); ++v)
      tensors.push_back(compose(random.metric(h / aspect * random.uniform(0.5, 2), aspect)));
    AdaptOptions options;
    options.transfer = {"constant", "jump"};
    AdaptResult result = adapt_mesh(mesh, metric_from_tensors(tensors, mesh.points), options);
    REQUIRE(result.status == AdaptStatus::Ok);
    mesh = std::move(result.mesh);
  }
  check_kept(cube, mesh);
  for (const double value : mesh.cell_fields[0].values) CHECK(value == Approx(0.3).epsilon(1e-12));
  for (const double value : mesh.cell_fields[1].values) CHECK((value > 2 - 1e-11 && value < 7 + 1e-11));
}

TEST_CASE("smooth fields stay at second order over ten adaptations", "[transfer]") {
  const Field wave = [](const Vec3& x) { return std::sin(2 * x.x + 0.5) * std::cos(x.y) + 0.5 * x.z * x.z; };
  struct Errors {
    double on_points = 0, on_cells = 0;  // root mean square, mean
    double h = 0;                        // cube root of a tet's mean volume
  };
  const auto errors = [&](int n) {
    Mesh cube = test::make_unit_cube(n);
    add_point_field(cube, "wave", wave), add_cell_field(cube, "mass", wave);
    const Mesh result = cycled(cube, [&](int cycle) { return size_of_cycle(cycle, 1.0 / n); }, {});
    Errors sums;
    for (std::size_t v = 0; v < result.points.size(); ++v)
      sums.on_points += std::pow(result.point_fields[0].values[v] - wave(result.points[v]), 2);
    sums.on_points = std::sqrt(sums.on_points / static_cast<double>(result.points.size()));
    for (std::uint32_t tet = 0; tet < result.tet_to_vert.size(); ++tet) {
      const double exact = wave(center_of(corners_of(tets_of(result), tet)));
      sums.on_cells += volume_at(result, tet) * std::abs(result.cell_fields[0].values[tet] - exact);
    }
    sums.h = std::cbrt(1 / static_cast<double>(result.tet_to_vert.size()));
    return sums;
  };
  // Sizes asked for halve; those delivered nearly do.
  const int n = test::kSanitized ? 6 : 8;
  const Errors coarse = errors(n), fine = errors(2 * n);
  CAPTURE(coarse.on_points, fine.on_points, coarse.on_cells, fine.on_cells, coarse.h, fine.h);
  const double halvings = std::log2(coarse.h / fine.h);
  CHECK(halvings > 0.9);
  CHECK(std::log2(coarse.on_points / fine.on_points) > std::log2(3.4) * halvings);
  CHECK(std::log2(coarse.on_cells / fine.on_cells) > std::log2(3.0) * halvings);
}

TEST_CASE("linear fields on points are exact over ten adaptations", "[transfer]") {
  Mesh cube = test::make_unit_cube(5);
  const Field linear = [](const Vec3& x) { return 1 + x.x - 2 * x.y + 3 * x.z; };
  add_point_field(cube, "linear", linear);
  const Mesh result = cycled(cube, [](int cycle) { return layer_of_cycle(cycle); }, {});
  for (std::size_t v = 0; v < result.points.size(); ++v)
    CHECK(result.point_fields[0].values[v] == Approx(linear(result.points[v])).margin(1e-11));
}

TEST_CASE("a name on points and on tets stands for both, and the report tells of each", "[transfer]") {
  Mesh cube = test::make_unit_cube(4);
  add_point_field(cube, "u", [](const Vec3& x) { return x.x; });
  add_cell_field(cube, "u", [](const Vec3& x) { return x.x > 0.5 ? -1.0 : 1.0; });
  add_cell_field(cube, "other", [](const Vec3&) { return 1.0; });
  AdaptOptions options;
  options.transfer = {"u"};
  const AdaptResult result = adapt_mesh(cube, size_of_cycle(0, 0.15), options);
  REQUIRE(result.status == AdaptStatus::Ok);
  REQUIRE((result.mesh.point_fields.size() == 1 && result.mesh.cell_fields.size() == 1));
  CHECK(result.mesh.cell_fields[0].values.size() == result.mesh.tet_to_vert.size());
  REQUIRE(result.report.transfers.size() == 2);
  const FieldTransfer &points = result.report.transfers[0], &cells = result.report.transfers[1];
  CHECK_FALSE(points.on_cells);
  CHECK(points.components.at(0).before.integral == Approx(0.5).epsilon(1e-12));
  CHECK(points.components[0].after.integral == Approx(0.5).epsilon(1e-12));
  CHECK((points.components[0].after.least == 0 && points.components[0].after.greatest == 1));
  CHECK(cells.on_cells);
  CHECK(cells.components.at(0).before.magnitude == Approx(1).epsilon(1e-12));
  CHECK((cells.components[0].before.least == -1 && cells.components[0].before.greatest == 1));
  CHECK(std::abs(cells.components[0].change()) < 1e-13);
}

TEST_CASE("fields do not depend on threads", "[transfer]") {
  Mesh cube = test::make_unit_cube(5, true);
  add_point_field(cube, "p", [](const Vec3& x) { return std::exp(x.x); });
  add_cell_field(cube, "c", [](const Vec3& x) { return std::exp(x.y) - x.z; });
  std::vector<std::vector<double>> values;
  for (const int threads : {1, 4}) {
    AdaptOptions options;
    options.threads = threads, options.tets_per_part = 2000;
    const Mesh result = cycled(
        cube, [](int cycle) { return size_of_cycle(cycle, 0.08); }, options, 2);
    values.push_back(result.point_fields[0].values);
    values.push_back(result.cell_fields[0].values);
  }
  CHECK(values[0] == values[2]);
  CHECK(values[1] == values[3]);
}

TEST_CASE("fields that cannot be carried over are refused", "[transfer]") {
  Mesh cube = test::make_unit_cube(2);
  add_point_field(cube, "heat", [](const Vec3& x) { return x.x; });
  add_cell_field(cube, "mass", [](const Vec3& x) { return x.x; });
  AdaptOptions options;
  options.transfer = {"mass"};
  const auto refusal = [&] {
    const AdaptResult result = adapt_mesh(cube, size_of_cycle(0, 0.3), options);
    CHECK(result.status == AdaptStatus::Failed);
    CHECK((result.mesh.points.empty() && result.mesh.cell_fields.empty()));
    REQUIRE(result.errors.size() == 1);
    return result.errors[0];
  };
  SECTION("a name that no field has") {
    options.transfer = {"mass", "density"};
    const Diagnostic error = refusal();
    CHECK(error.code == ErrorCode::InvalidArgument);
    CHECK_THAT(error.message,
               Catch::Contains("\"density\"") && Catch::Contains("\"heat\"") && Catch::Contains("\"mass\""));
  }
  SECTION("a name that is there twice") {
    options.transfer = {"mass", "heat", "mass"};
    CHECK(refusal().code == ErrorCode::InvalidArgument);
  }
  SECTION("values that are not finite") {
    cube.cell_fields[0].values[17] = GENERATE(std::numeric_limits<double>::quiet_NaN(), HUGE_VAL);
    const Diagnostic error = refusal();
    CHECK(error.code == ErrorCode::InputUnsuitable);
    CHECK(error.elements == std::vector<std::uint64_t>{17});
    CHECK(error.point == center_of(corners_of(tets_of(cube), 17)));
  }
  SECTION("too few values, or too many") {
    cube.cell_fields[0].values.resize(GENERATE(47, 49, 0));
    CHECK(refusal().code == ErrorCode::InvalidArgument);
  }
  SECTION("no components") {
    cube.cell_fields[0].components = 0;
    CHECK(refusal().code == ErrorCode::InvalidArgument);
  }
}
