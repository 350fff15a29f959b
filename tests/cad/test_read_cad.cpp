// Reading STEP, IGES and BREP files: names, colours, units, healing, imprinting.
#include <unistd.h>
#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <iterator>
#include <random>
#include <set>
#include <sstream>
#include <thread>

#include "tests/cad/cad_samples.hpp"
#include "tests/cad/faulty_samples.hpp"
#include "tests/cad/model_checks.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;
using test::Sample;
using test::TemporaryFolder;
using test::write_file;

namespace {

ModelDocument read_sample(Sample sample, const char* name, const ReadOptions& options = {}) {
  const TemporaryFolder scratch;
  test::write_sample(sample, scratch / name);
  return read_model(scratch / name, options);
}

double total_volume(const GeometricModel& model) {
  double sum = 0;
  for (std::size_t i = 0; i < model.topology().region_count(); ++i) sum += model.volume(ModelRegionId(i));
  return sum;
}

std::size_t shared_faces(const GeometricModel& model) {
  std::size_t count = 0;
  for (const FaceSides& sides : model.topology().face_to_sides)
    count += sides.front.valid() && sides.back.valid() ? 1 : 0;
  return count;
}

bool has_warning(const ModelDocument& document, ErrorCode code) {
  for (const Diagnostic& warning : document.warnings)
    if (warning.code == code) return true;
  return false;
}

/// Four threads that take blocks as they come.
class ThreadLoop : public BlockLoop {
 public:
  void for_blocks(std::size_t count, std::size_t grain,
                  const std::function<void(std::size_t, std::size_t)>& body) const override {
    std::atomic<std::size_t> next = 0;  // shared by the threads below, which count blocks with it
    const auto work = [&] {
      for (std::size_t at; (at = next.fetch_add(grain)) < count;) body(at, std::min(at + grain, count));
    };
    std::vector<std::jthread> threads;
    for (int i = 0; i < 4; ++i) threads.emplace_back(work);
  }
};

/// All that reading finds out: numbers to the last digit.
std::string described(const ModelDocument& document) {
  std::ostringstream text;
  text << std::hexfloat;
  for (const HealingStep& step : document.healing) text << step.what << ' ' << step.count << '\n';
  for (const Diagnostic& warning : document.warnings) {
    text << warning.message;
    for (const NamedEntity& entity : warning.entities)
      text << ' ' << int{entity.entity.dim} << ':' << entity.entity.index;
    text << '\n';
  }
  const GeometricModel& model = *document.model;
  for (const Vec3& corner : {model.bounding_box().lo, model.bounding_box().hi})
    text << corner.x << ' ' << corner.y << ' ' << corner.z << '\n';
  const ModelTopology& topology = model.topology();
  for (std::size_t i = 0; i < topology.vertex_count; ++i) text << model.attributes(ModelVertexId(i)).tolerance << '\n';
  for (std::size_t i = 0; i < topology.edge_count(); ++i) text << model.attributes(ModelEdgeId(i)).tolerance << '\n';
  for (std::size_t i = 0; i < topology.face_count(); ++i) text << model.area(ModelFaceId(i)) << '\n';
  for (std::size_t i = 0; i < topology.region_count(); ++i) text << model.volume(ModelRegionId(i)) << '\n';
  return text.str();
}

}  // namespace

TEST_CASE("a model does not depend on who carries out the loops of its reading") {
  const TemporaryFolder scratch;
  std::vector<std::filesystem::path> files;
  for (const Sample sample : {Sample::DrilledBox, Sample::LoftedSolid, Sample::TurnedSpline, Sample::InsideOutBox,
                              Sample::OffsetSheet, Sample::LooseHollow, Sample::OpenBox}) {
    files.push_back(scratch / ("sample" + std::to_string(files.size()) + ".brep"));
    test::write_sample(sample, files.back());
  }
  for (const Sample sample : {Sample::Cylinder, Sample::Sphere, Sample::Torus, Sample::Cone, Sample::SplineSolid,
                              Sample::LoftedSolid, Sample::DrilledBox, Sample::OffsetSheet}) {
    files.push_back(scratch / ("plain" + std::to_string(files.size()) + ".step"));
    test::write_step_without_parameter_curves(sample, files.back());
  }
  for (const test::Fault fault : {test::Fault::TangentHoleInPlate, test::Fault::CurveShortOfVertex,
                                  test::Fault::FloorInOuterFace, test::Fault::OverlappingBoxes}) {
    files.push_back(scratch / ("fault" + std::to_string(files.size()) + ".brep"));
    test::write_faulty(fault, files.back());
  }
  for (const std::filesystem::path& file : files) {
    INFO(file);
    const std::string alone = described(read_model(file));
    for (int round = 0; round < 3; ++round) CHECK(described(read_model(file, {}, nullptr, ThreadLoop())) == alone);
  }
}

TEST_CASE("a box has six faces, twelve edges, eight vertices and one region in every CAD format") {
  for (const char* name : {"box.step", "box.STP", "box.brep", "box.igs"}) {
    INFO(name);
    const TemporaryFolder scratch;
    const std::string plain = std::string(name) == "box.STP" ? "box.step" : name;
    test::write_sample(Sample::Box, scratch / plain);
    if (plain != name) std::filesystem::rename(scratch / plain, scratch / name);
    const ModelDocument document = read_model(scratch / name);
    const ModelTopology& topology = document.model->topology();
    CHECK(topology.region_count() == 1);
    CHECK(topology.face_count() == 6);
    CHECK(topology.edge_count() == 12);
    CHECK(topology.vertex_count == 8);
    CHECK(total_volume(*document.model) == Approx(6000));
    CHECK(document.model->bounding_box().diagonal() == Approx(std::sqrt(1400.0)));
    CHECK(document.warnings.empty());
    for (const FaceSides& sides : topology.face_to_sides) CHECK(sides.front.valid() != sides.back.valid());
    double area = 0;
    for (std::size_t i = 0; i < 6; ++i) area += document.model->area(ModelFaceId(i));
    CHECK(area == Approx(2200));
  }
}

TEST_CASE("a region lies in front of or behind its faces as their normals say") {
  const ModelDocument document = read_sample(Sample::DrilledBox, "drilled.step");
  const GeometricModel& model = *document.model;
  const Vec3 inside{1, 1, 1};
  for (std::size_t i = 0; i < model.topology().face_count(); ++i) {
    const auto face = model.face_geometry(ModelFaceId(i));
    const ParameterBox box = face->parameter_box();
    const Vec2 middle = 0.5 * (box.lo + box.hi);
    const Vec3 normal = face->normal(middle), point = face->evaluate(middle);
    const bool hole = std::hypot(point.x - 5, point.y - 10) < 3.001 && point.z > 0.1 && point.z < 29.9;
    const Vec3 outward = hole ? Vec3{5 - point.x, 10 - point.y, 0} : point - inside;
    const FaceSides& sides = model.topology().face_to_sides[i];
    if (std::abs(dot(normal, outward)) < 1e-9) continue;
    CHECK((dot(normal, outward) > 0 ? sides.back : sides.front).valid());
    CHECK_FALSE((dot(normal, outward) > 0 ? sides.front : sides.back).valid());
  }
}

TEST_CASE("an assembly keeps names, colours, layers and the place of every instance") {
  const TemporaryFolder scratch;
  test::write_gearbox(scratch / "gearbox.step");
  const ModelDocument document = read_model(scratch / "gearbox.step");
  const GeometricModel& model = *document.model;
  REQUIRE(model.topology().region_count() == 3);
  CHECK(model.attributes(ModelRegionId(0)).name == "gearbox/housing");
  CHECK(model.attributes(ModelRegionId(1)).name == "gearbox/shaft");
  CHECK(model.attributes(ModelRegionId(2)).name == "gearbox/shaft");
  CHECK(model.attributes(ModelRegionId(0)).color == Color{1, 0, 0});
  CHECK(model.attributes(ModelRegionId(1)).color == Color{0, 1, 0});
  CHECK(model.topology().face_count() == 6 + 3 + 3);
  std::size_t lids = 0;
  for (const ModelFaceId id : model.topology().region_to_faces[0]) {
    const EntityAttributes& attributes = model.attributes(id);
    if (attributes.name != "lid") {
      CHECK(attributes.color == Color{1, 0, 0});
      CHECK(attributes.layer.empty());
      continue;
    }
    ++lids;
    CHECK(attributes.color == Color{0, 0, 1});
    CHECK(attributes.layer == "top");
  }
  CHECK(lids == 1);
  for (const ModelFaceId id : model.topology().region_to_faces[2]) {
    CHECK(model.attributes(id).color == Color{0, 1, 0});
    const auto face = model.face_geometry(id);
    const ParameterBox box = face->parameter_box();
    CHECK(std::abs(face->evaluate(0.5 * (box.lo + box.hi)).x - 60) <= 5.001);
  }
}

TEST_CASE("lengths are millimetres whatever the unit of the file, and BREP files have no unit") {
  const TemporaryFolder scratch;
  test::write_inch_box(scratch / "inch.step");
  const ModelDocument document = read_model(scratch / "inch.step");
  CHECK(document.model->metres_per_unit() == Approx(0.001));
  CHECK(total_volume(*document.model) == Approx(6 * 25.4 * 25.4 * 25.4));
  CHECK(read_sample(Sample::Box, "box.igs").model->metres_per_unit() == Approx(0.001));
  CHECK(read_sample(Sample::Box, "box.brep").model->metres_per_unit() == 0);
}

TEST_CASE("the format is reported as the extension says") {
  CHECK(read_sample(Sample::Box, "box.step").format == "STEP");
  CHECK(read_sample(Sample::Box, "box.igs").format == "IGES");
  CHECK(read_sample(Sample::Box, "box.brep").format == "BREP");
}

TEST_CASE("loose faces are sewn to a solid") {
  for (const char* name : {"loose.brep", "loose.step"}) {
    const ModelDocument document = read_sample(Sample::LooseFaces, name);
    CHECK(document.model->topology().region_count() == 1);
    CHECK(document.model->topology().edge_count() == 12);
    CHECK(total_volume(*document.model) == Approx(6000));
    CHECK(document.healing.size() >= 2);
    CHECK(document.warnings.empty());
  }
}

TEST_CASE("a closed shell of loose faces inside another one becomes its cavity") {
  const ModelDocument document = read_sample(Sample::LooseHollow, "hollow.brep");
  CHECK(document.model->topology().region_count() == 1);
  CHECK(total_volume(*document.model) == Approx(6000 - 36 * 3.14159265358979).epsilon(1e-6));
  CHECK(total_volume(*read_sample(Sample::HollowBox, "solid.step").model) ==
        Approx(6000 - 36 * 3.14159265358979).epsilon(1e-6));
}

TEST_CASE("without healing loose faces stay a sheet model") {
  ReadOptions options;
  options.heal = false;
  const ModelDocument document = read_sample(Sample::LooseFaces, "loose.brep", options);
  CHECK(document.model->topology().region_count() == 0);
  CHECK(document.model->topology().face_count() == 6);
  CHECK(document.model->topology().edge_count() == 24);
  CHECK(document.healing.empty());
}

TEST_CASE("a solid that is inside out is turned") {
  const ModelDocument document = read_sample(Sample::InsideOutBox, "box.brep");
  CHECK(total_volume(*document.model) == Approx(6000));
  REQUIRE(document.healing.size() == 1);
  CHECK(document.healing[0].count == 1);
  ReadOptions options;
  options.heal = false;
  CHECK(total_volume(*read_sample(Sample::InsideOutBox, "box.brep", options).model) == Approx(-6000));
}

TEST_CASE("a part that is inside out is turned wherever it is placed") {
  const ModelDocument document = read_sample(Sample::PlacedInsideOutBox, "box.brep");
  CHECK(total_volume(*document.model) == Approx(6000));
  CHECK(document.model->bounding_box().lo.x == Approx(100));
}

TEST_CASE("healing leaves valid shapes as they are") {
  for (const Sample sample : {Sample::Box, Sample::DrilledBox, Sample::HollowBox, Sample::Torus, Sample::Cone,
                              Sample::LoftedSolid, Sample::TurnedSpline, Sample::Sheet, Sample::SharingBoxes}) {
    INFO("sample " << static_cast<int>(sample));
    ReadOptions plain;
    plain.heal = false;
    const ModelDocument healed = read_sample(sample, "sample.brep"),
                        as_it_is = read_sample(sample, "sample.brep", plain);
    CHECK(healed.healing.empty());
    CHECK(healed.warnings.size() == as_it_is.warnings.size());
    CHECK(healed.model->topology().vertex_count == as_it_is.model->topology().vertex_count);
    CHECK(healed.model->topology().face_to_loops.size() == as_it_is.model->topology().face_to_loops.size());
    REQUIRE(healed.model->topology().edge_count() == as_it_is.model->topology().edge_count());
    for (std::size_t i = 0; i < healed.model->topology().vertex_count; ++i)
      CHECK(healed.model->vertex_point(ModelVertexId(i)) == as_it_is.model->vertex_point(ModelVertexId(i)));
  }
}

TEST_CASE("an open solid is read with a warning that names the region, the open edges and a point") {
  const ModelDocument document = read_sample(Sample::OpenBox, "open.brep");
  REQUIRE(has_warning(document, ErrorCode::OpenShell));
  for (const Diagnostic& warning : document.warnings) {
    if (warning.code != ErrorCode::OpenShell) continue;
    CHECK(warning.point.has_value());
    REQUIRE(warning.entities.size() >= 5);
    CHECK(warning.entities[0].entity == ModelEntity(3, 0));
    CHECK(warning.entities[1].entity.dim == 1);
  }
}

TEST_CASE("boxes that touch share nothing, and share their common face after imprinting") {
  const ModelDocument apart = read_sample(Sample::TouchingBoxes, "touching.step");
  CHECK(apart.model->topology().region_count() == 2);
  CHECK(shared_faces(*apart.model) == 0);
  ReadOptions options;
  options.imprint = true;
  const ModelDocument fused = read_sample(Sample::TouchingBoxes, "touching.step", options);
  CHECK(fused.model->topology().region_count() == 2);
  CHECK(shared_faces(*fused.model) == 1);
  CHECK(fused.model->topology().face_count() == 13);  // both touched faces are cut in two, and one part is common
  CHECK(total_volume(*fused.model) == Approx(2000));
  CHECK(test::check_loops(*fused.model).disconnected == 0);
}

TEST_CASE("imprinting keeps names and colours") {
  const TemporaryFolder scratch;
  test::write_gearbox(scratch / "gearbox.step");
  ReadOptions options;
  options.imprint = true;
  const ModelDocument document = read_model(scratch / "gearbox.step", options);
  const GeometricModel& model = *document.model;
  REQUIRE(model.topology().region_count() == 3);
  CHECK(model.attributes(ModelRegionId(0)).name == "gearbox/housing");
  CHECK(model.attributes(ModelRegionId(2)).name == "gearbox/shaft");
  CHECK(model.attributes(ModelRegionId(2)).color == Color{0, 1, 0});
  std::size_t lids = 0;
  for (std::size_t i = 0; i < model.topology().face_count(); ++i)
    lids += model.attributes(ModelFaceId(i)).name == "lid" && model.attributes(ModelFaceId(i)).color == Color{0, 0, 1};
  CHECK(lids == 1);
}

TEST_CASE("instances of a part have its faces in other places") {
  const TemporaryFolder scratch;
  test::write_gearbox(scratch / "gearbox.step");
  const ModelDocument document = read_model(scratch / "gearbox.step");
  const GeometricModel& model = *document.model;
  const auto& region_to_faces = model.topology().region_to_faces;
  REQUIRE(region_to_faces.size() == 3);
  REQUIRE(region_to_faces[1].size() == region_to_faces[2].size());
  for (std::size_t i = 0; i < region_to_faces[1].size(); ++i) {
    const ModelFaceId first = region_to_faces[1][i], second = region_to_faces[2][i];
    const FacePlace here = model.place(first), there = model.place(second);
    CHECK(here.shape == first.value);
    CHECK(there.shape == first.value);
    const Vec2 uv{0.5, 0.5};
    const Vec3 moved = (there.motion * here.motion.inverse())(model.face_geometry(first)->evaluate(uv));
    CHECK(distance(moved, model.face_geometry(second)->evaluate(uv)) < 1e-9);
  }
  CHECK(model.place(region_to_faces[0][0]).shape == region_to_faces[0][0].value);
}

TEST_CASE("solids that share a face have it on both their sides") {
  for (const char* name : {"sharing.brep", "sharing.step"}) {
    ReadOptions options;
    options.imprint = std::string(name) == "sharing.step";  // STEP writes each solid with faces of its own
    const ModelDocument document = read_sample(Sample::SharingBoxes, name, options);
    CHECK(document.model->topology().region_count() == 2);
    CHECK(document.model->topology().face_count() == 11);
    CHECK(shared_faces(*document.model) == 1);
  }
}

TEST_CASE("a sheet has no region, and its loop runs counter-clockwise about its normal") {
  const ModelDocument document = read_sample(Sample::Sheet, "sheet.brep");
  const GeometricModel& model = *document.model;
  CHECK(model.topology().region_count() == 0);
  REQUIRE(model.topology().face_to_loops.at(0).size() == 1);
  const auto face = model.face_geometry(ModelFaceId(0));
  double area = 0;
  for (const EdgeUse& use : model.topology().face_to_loops[0][0]) {
    const ParameterRange range = face->edge_range(use);
    const Vec2 a = face->edge_parameters(use, use.forward ? range.lo : range.hi);
    const Vec2 b = face->edge_parameters(use, use.forward ? range.hi : range.lo);
    area += 0.5 * cross(a, b);
  }
  CHECK(area == Approx(200));
}

TEST_CASE("an edge that sticks into a face is run up and down in one loop") {
  ReadOptions options;
  options.heal = false;  // healing takes it away
  const ModelDocument document = read_sample(Sample::SheetWithSpur, "spur.brep", options);
  const ModelTopology& topology = document.model->topology();
  REQUIRE(topology.face_to_loops.at(0).size() == 1);
  const ModelLoop& loop = topology.face_to_loops[0][0];
  CHECK(loop.size() == 7);
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const EdgeUse& use = loop[i];
    std::size_t uses = 0;
    for (const EdgeUse& other : loop) uses += other.edge == use.edge ? 1 : 0;
    if (uses == 1) continue;
    const EdgeUse &before = loop[(i + 6) % 7], &after = loop[(i + 1) % 7];
    CHECK((before.edge == use.edge || after.edge == use.edge));
  }
  CHECK(test::check_loops(*document.model).disconnected == 0);
}

TEST_CASE("a free edge inside a face becomes a loop of its own that runs both ways") {
  const ModelDocument document = read_sample(Sample::SheetWithLine, "line.brep");
  const ModelTopology& topology = document.model->topology();
  REQUIRE(topology.face_to_loops.size() == 1);
  REQUIRE(topology.face_to_loops[0].size() == 2);
  const ModelLoop& loop = topology.face_to_loops[0][1];
  REQUIRE(loop.size() == 2);
  CHECK(loop[0].edge == loop[1].edge);
  CHECK(loop[0].forward != loop[1].forward);
  CHECK(test::check_loops(*document.model).disconnected == 0);
}

TEST_CASE("edges and vertices that bound no face are left out with a warning") {
  const ModelDocument document = read_sample(Sample::BoxWithEdge, "edge.brep");
  CHECK(document.model->topology().edge_count() == 12);
  CHECK(document.model->topology().vertex_count == 8);
  CHECK(document.model->bounding_box().hi.x == Approx(10));
  CHECK(document.warnings.size() == 2);
}

TEST_CASE("facetted models are read through the same call") {
  const TemporaryFolder scratch;
  write_file(scratch / "tet.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
  const ModelDocument document = read_model(scratch / "tet.obj");
  CHECK(document.format == "OBJ");
  CHECK(document.model->topology().face_count() == 4);
}

TEST_CASE("several threads may read at once and get the same model") {
  const TemporaryFolder scratch;
  test::write_gearbox(scratch / "gearbox.step");
  std::array<ModelDocument, 4> documents;
  std::vector<std::thread> threads;
  for (ModelDocument& document : documents)
    threads.emplace_back([&] { document = read_model(scratch / "gearbox.step"); });
  for (std::thread& thread : threads) thread.join();
  for (const ModelDocument& document : documents) {
    REQUIRE(document.model->topology().vertex_count == documents[0].model->topology().vertex_count);
    for (std::size_t i = 0; i < document.model->topology().vertex_count; ++i)
      CHECK(document.model->vertex_point(ModelVertexId(i)) == documents[0].model->vertex_point(ModelVertexId(i)));
  }
}
