// Models whose shapes lie in a file answer as those that were stored, to the last bit.
#include <algorithm>
#include <bit>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/cad/cad_samples.hpp"
#include "tests/cad/model_checks.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
namespace fs = std::filesystem;

namespace {

constexpr std::uint64_t kNoLimit = ~std::uint64_t{0};

/// A folder that is gone after the test.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("tetloom-stored-" + std::to_string(std::random_device()()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  fs::path operator/(const char* name) const { return path_ / name; }
  bool is_empty() const { return fs::is_empty(path_); }

 private:
  fs::path path_;
};

/// All bits of some numbers, for comparisons that tell which one differs.
using Bits = std::vector<std::uint64_t>;

void add(Bits& bits, double x) { bits.push_back(std::bit_cast<std::uint64_t>(x)); }
void add(Bits& bits, const Vec2& p) { add(bits, p.u), add(bits, p.v); }
void add(Bits& bits, const Vec3& p) { add(bits, p.x), add(bits, p.y), add(bits, p.z); }

template <class Ask>
void add_answer(Bits& bits, const Ask& ask) {
  try {
    ask();
  } catch (const Error& error) {
    bits.push_back(static_cast<std::uint64_t>(error.code()));
  }
}

/// The first answer that differs: small numbers are the general ones, large ones those of facets. -1: none.
std::ptrdiff_t first_difference(const Bits& a, const Bits& b) {
  const auto [at, other] = std::ranges::mismatch(a, b);
  return at == a.end() && other == b.end() ? -1 : at - a.begin();
}

Bits answers_of_edge(EdgeGeometry& edge, const Vec3& beside) {
  Bits bits;
  const ParameterRange range = edge.range();
  add(bits, range.lo), add(bits, range.hi), add(bits, edge.period());
  for (const double share : {0.0, 0.3, 0.5, 0.9, 1.0}) {
    const double t = range.lo + share * (range.hi - range.lo);
    add(bits, edge.evaluate(t)), add(bits, edge.derivative(t)), add(bits, edge.curvature(t));
  }
  const CurvePoint found = edge.closest_point(beside);
  add(bits, found.t), add(bits, found.point);
  return bits;
}

Bits answers_of_face(FaceGeometry& face, const std::vector<ModelLoop>& loops, double size) {
  Bits bits;
  const ParameterBox box = face.parameter_box();
  add(bits, box.lo), add(bits, box.hi), add(bits, face.period());
  for (const double s : {0.0, 0.4, 0.7, 1.0}) {
    const Vec2 uv = box.lo + Vec2{s * (box.hi.u - box.lo.u), (1 - 0.8 * s) * (box.hi.v - box.lo.v)};
    const SurfaceDerivatives d = face.derivatives(uv);
    add(bits, face.evaluate(uv)), add(bits, d.du), add(bits, d.dv), add(bits, face.normal(uv));
    const PrincipalCurvatures curvature = face.curvature(uv);
    add(bits, curvature.largest), add(bits, curvature.smallest);
    const SurfacePoint found = face.closest_point(face.evaluate(uv) + 0.01 * size * face.normal(uv), {});
    add(bits, found.uv), add(bits, found.point);
  }
  const bool has_curves = face.parametrization() != Parametrization::Piecewise;
  for (const ModelLoop& loop : loops)
    for (const EdgeUse& use : loop) {
      const ParameterRange range = face.edge_range(use);
      add(bits, range.lo), add(bits, range.hi);
      if (!has_curves) continue;
      for (const double share : {0.0, 0.6, 1.0})
        add(bits, face.edge_parameters(use, range.lo + share * (range.hi - range.lo)));
    }
  add_answer(bits, [&] {
    const Tessellation facets = face.tessellate(0.01 * size, 0.5);
    for (std::size_t i = 0; i < facets.points.size(); ++i) {
      add(bits, facets.points[i]), add(bits, facets.uv[i]), add(bits, facets.edge_parameter[i]);
      bits.push_back(facets.classification[i].dim), bits.push_back(facets.classification[i].index);
    }
    for (const auto& tri : facets.tri_to_vert) bits.insert(bits.end(), tri.begin(), tri.end());
  });
  return bits;
}

void check_same(const GeometricModel& a, const GeometricModel& b) {
  const ModelTopology& topology = a.topology();
  REQUIRE(b.topology().vertex_count == topology.vertex_count);
  REQUIRE(b.topology().edge_count() == topology.edge_count());
  REQUIRE(b.topology().face_count() == topology.face_count());
  REQUIRE(b.topology().region_count() == topology.region_count());
  CHECK(a.bounding_box().lo == b.bounding_box().lo);
  CHECK(a.bounding_box().hi == b.bounding_box().hi);
  CHECK(a.metres_per_unit() == b.metres_per_unit());
  const double size = a.bounding_box().diagonal();
  for (std::size_t v = 0; v < topology.vertex_count; ++v)
    CHECK(a.vertex_point(ModelVertexId(v)) == b.vertex_point(ModelVertexId(v)));
  for (std::size_t e = 0; e < topology.edge_count(); ++e) {
    if (topology.edges[e].degenerate) continue;
    INFO("edge " << e);
    const ModelEdgeId id(e);
    const Vec3 beside = a.bounding_box().center();
    const Bits of_a = answers_of_edge(*a.edge_geometry(id), beside);
    CHECK(first_difference(of_a, answers_of_edge(*b.edge_geometry(id), beside)) == -1);
  }
  for (std::size_t f = 0; f < topology.face_count(); ++f) {
    INFO("face " << f);
    const ModelFaceId id(f);
    const auto& loops = topology.face_to_loops[f];
    const Bits of_a = answers_of_face(*a.face_geometry(id), loops, size);
    CHECK(first_difference(of_a, answers_of_face(*b.face_geometry(id), loops, size)) == -1);
    CHECK(a.area(id) == b.area(id));
    CHECK(a.place(id).shape == b.place(id).shape);
    CHECK(a.attributes(id).name == b.attributes(id).name);
    CHECK(a.attributes(id).color == b.attributes(id).color);
    CHECK(a.attributes(id).tolerance == b.attributes(id).tolerance);
  }
  for (std::size_t r = 0; r < topology.region_count(); ++r)
    CHECK(a.volume(ModelRegionId(r)) == b.volume(ModelRegionId(r)));
}

void check_stored(const fs::path& input, const ReadOptions& options = {}) {
  INFO(input.string());
  const Folder folder;
  const ModelDocument document = read_model(input, options);
  REQUIRE(store_model(document, folder / "shapes"));
  const ModelDocument stored = open_stored_model(folder / "shapes", kNoLimit);
  fs::remove(folder / "shapes");  // it is open
  CHECK(stored.format == document.format);
  CHECK(stored.warnings.size() == document.warnings.size());
  CHECK(stored.healing.size() == document.healing.size());
  check_same(*document.model, *stored.model);
}

}  // namespace

TEST_CASE("stored models of every kind of surface answer as those that were stored, to the last bit") {
  using enum test::Sample;
  const Folder folder;
  for (const test::Sample sample : {Box, Cylinder, Sphere, Torus, Cone, TurnedSpline, PushedSpline, SplineSolid,
                                    LoftedSolid, OffsetSheet, BezierSheet, DrilledBox, SharingBoxes, SheetWithSpur}) {
    test::write_sample(sample, folder / "sample.brep");
    INFO("sample " << static_cast<int>(sample));
    check_stored(folder / "sample.brep");
  }
  test::write_gearbox(folder / "gearbox.step");
  check_stored(folder / "gearbox.step");
  ReadOptions imprinted;
  imprinted.imprint = true;
  test::write_sample(TouchingBoxes, folder / "touching.step");
  check_stored(folder / "touching.step", imprinted);
}

TEST_CASE("stored shared models answer as those that were read, to the last bit") {
  const fs::path folder = fs::path(TETLOOM_SHARED_DIR) / "cad";
  if (!fs::exists(folder)) {
    WARN("skipped: no models in " << folder);
    return;
  }
  for (const char* model : {"OCCT__occ_CrankArm.brep", "OCCT__step_linkrods.step", "OCCT__occ_bottle.brep",
                            "tigl__TestData_simplewing.brep", "GEOUNED__Torus_tank.stp", "OCCT__step_screw.step"})
    check_stored(folder / model);
}

TEST_CASE("of a stored model no more shapes are held than asked for, and one at least") {
  const Folder folder;
  test::write_sample(test::Sample::DrilledBox, folder / "box.brep");
  REQUIRE(store_model(read_model(folder / "box.brep"), folder / "shapes"));
  const auto most_held = [&](std::uint64_t limit) {
    const ModelDocument stored = open_stored_model(folder / "shapes", limit);
    CHECK(stored.model->shape_memory()->most_held_bytes == 0);
    test::check_loops(*stored.model);
    return *stored.model->shape_memory();
  };
  const ShapeMemory all = most_held(kNoLimit), half = most_held(all.total_bytes / 2), one = most_held(0);
  CHECK(all.most_held_bytes == all.total_bytes);
  CHECK(half.most_held_bytes <= all.total_bytes / 2);
  CHECK(one.most_held_bytes > 0);
  CHECK(one.most_held_bytes < half.most_held_bytes);
}

TEST_CASE("the shapes of edges and faces are all that there is in a stored model") {
  const Folder folder;
  test::write_sample(test::Sample::DrilledBox, folder / "box.brep");
  REQUIRE(store_model(read_model(folder / "box.brep"), folder / "shapes"));
  const ModelDocument stored = open_stored_model(folder / "shapes", kNoLimit);
  const ModelTopology& topology = stored.model->topology();
  std::uint64_t sum = 0;
  for (int dim = 0; dim <= 3; ++dim)
    for (std::uint32_t i = 0; i < topology.count(dim); ++i) {
      const std::uint64_t bytes = stored.model->shape_bytes(ModelEntity(dim, i));
      CHECK((bytes > 0) == (dim == 1 || dim == 2));
      sum += bytes;
    }
  CHECK(sum == stored.model->shape_memory()->total_bytes);
  CHECK(read_model(folder / "box.brep").model->shape_bytes(ModelEntity(2, 0)) == 0);
}

TEST_CASE("stored models of facets answer as those that were stored, to the last bit") {
  const Folder folder;
  // A drum of 40 sides, whose rims are closed edges, and a smaller one whose pointed roof is one face with its side.
  std::ofstream obj(folder / "drums.obj");
  constexpr int kSides = 40;
  for (const double shift : {0.0, 5.0}) {
    for (int i = 0; i < kSides; ++i)
      for (const double z : {0.0, 1.0}) {
        const double turn = 2 * std::numbers::pi * i / kSides, radius = shift > 0 ? 0.5 : 1;
        obj << "v " << shift + radius * std::cos(turn) << ' ' << radius * std::sin(turn) << ' ' << z << '\n';
      }
    obj << "v " << shift << " 0 0\nv " << shift << " 0 " << 1 + shift / 5 << '\n';
  }
  for (const int first : {1, 2 * kSides + 3})
    for (int i = 0; i < kSides; ++i) {
      const int low = first + 2 * i, next = first + 2 * ((i + 1) % kSides), center = first + 2 * kSides;
      obj << "f " << low << ' ' << next << ' ' << next + 1 << "\nf " << low << ' ' << next + 1 << ' ' << low + 1
          << "\nf " << center << ' ' << next << ' ' << low << "\nf " << center + 1 << ' ' << low + 1 << ' ' << next + 1
          << '\n';
    }
  obj.close();
  REQUIRE(read_model(folder / "drums.obj").model->topology().region_count() == 2);
  REQUIRE(read_model(folder / "drums.obj").model->topology().edge_count() == 3);
  check_stored(folder / "drums.obj");
  const fs::path shared = fs::path(TETLOOM_SHARED_DIR) / "cad2";
  if (!fs::exists(shared)) {
    WARN("skipped: no models in " << shared);
    return;
  }
  check_stored(shared / "netgen__tutorials_part1.stl");
  check_stored(shared / "common-3d-test-models__data_cow.obj");
}

TEST_CASE("models that were not read are not stored, and nothing is left behind") {
  const Folder folder;
  test::write_sample(test::Sample::Box, folder / "box.brep");
  ModelDocument document;
  document.model = put_into_box(read_model(folder / "box.brep").model, 2);
  fs::remove(folder / "box.brep");
  CHECK_FALSE(store_model(document, folder / "shapes"));
  CHECK(folder.is_empty());
}

TEST_CASE("files of shapes that are missing, cut off or others are refused") {
  const Folder folder;
  CHECK_THROWS_AS(open_stored_model(folder / "missing", kNoLimit), Error);
  test::write_sample(test::Sample::Box, folder / "box.brep");
  const ModelDocument document = read_model(folder / "box.brep");
  CHECK_THROWS_AS(store_model(document, folder / "no folder/shapes"), Error);
  REQUIRE(store_model(document, folder / "shapes"));
  const auto size = fs::file_size(folder / "shapes");
  for (const std::uintmax_t shorter : {std::uintmax_t{0}, std::uintmax_t{10}, size / 2, size - 1}) {
    fs::copy_file(folder / "shapes", folder / "cut", fs::copy_options::overwrite_existing);
    fs::resize_file(folder / "cut", shorter);
    CHECK_THROWS_AS(open_stored_model(folder / "cut", kNoLimit), Error);
  }
  CHECK_THROWS_AS(open_stored_model(folder / "box.brep", kNoLimit), Error);
}
