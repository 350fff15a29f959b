// What real_models makes of reports, and what it says of many models.
#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "bench/support/real_table.hpp"

using namespace tetloom::bench;
using nlohmann::json;

namespace {

/// A model of one region of volume 8 that both meshers have filled well.
RealModel filled(double seconds = 2, double gmsh_seconds = 8) {
  RealModel model;
  model.name = "part.step";
  model.facts.diagonal = 3.5, model.facts.volumes = {8};
  MeshFigures mesh;
  mesh.tets = 1000, mesh.triangles = 400, mesh.regions = 1, mesh.volume = 8;
  mesh.min_dihedral_deg = 15, mesh.ratio_mean = .93, mesh.ratio_p1 = .77, mesh.edges_in_band = .98;
  model.tetloom.exit_status = 0, model.tetloom.seconds = seconds, model.tetloom.mesh = mesh;
  model.stages.total = seconds, model.stages.size_field = .1 * seconds;
  model.gmsh = MesherRun{.exit_status = 0, .seconds = gmsh_seconds, .failure = "", .mesh = mesh};
  return model;
}

RealModel too_slow() {
  RealModel model = filled();
  model.name = "slow.step";
  model.tetloom = {.exit_status = 5, .timed_out = true, .seconds = 121, .failure = "Cancelled", .mesh = {}};
  model.stages = {};
  return model;
}

SummaryRow row_of(const std::vector<RealModel>& models, const std::string& measure) {
  for (const SummaryRow& row : summarize(models))
    if (row.measure.starts_with(measure)) return row;
  FAIL("no row " << measure);
  return {};
}

}  // namespace

TEST_CASE("the median of an even number of values is the mean of the two in the middle") {
  CHECK(median({3, 1, 2}) == 2);
  CHECK(median({4, 1, 2, 3}) == 2.5);
  CHECK_FALSE(median({}).has_value());
}

TEST_CASE("solids that were made anew are taken from the report, list after list") {
  CHECK(rebuilt_solids(json::object()).empty());
  const auto lists = rebuilt_solids({{"rebuilt", {{26, 27}, {1}}}});
  REQUIRE(lists.size() == 2);
  CHECK(lists[0] == std::vector{tetloom::ModelRegionId(25), tetloom::ModelRegionId(26)});
  CHECK(lists[1] == std::vector{tetloom::ModelRegionId(0)});
}

TEST_CASE("a run is valid when its mesh fills all regions with the right volume") {
  RealModel model = filled();
  CHECK(is_valid(model));
  SECTION("a volume 2.4 % too small") {
    model.tetloom.mesh->volume = 8 * .976;
    CHECK(verdict(model) == "volume -2.4 %");
  }
  SECTION("a region that is not filled") {
    model.facts.volumes = {4, 4};
    CHECK(verdict(model) == "1 of 2 solids");
  }
  SECTION("a region that encloses nothing need not be filled") {
    model.facts.volumes = {8, 0};
    CHECK(is_valid(model));
  }
  SECTION("an inverted tet") {
    model.tetloom.mesh->inverted = 2;
    CHECK(verdict(model) == "2 inverted");
  }
  SECTION("a problem of the mesh") {
    model.tetloom.mesh->problem = "3 triangles are not on tets";
    CHECK(verdict(model) == "invalid");
  }
  SECTION("no mesh") {
    model.tetloom.mesh.reset();
    CHECK(verdict(model) == "not judged");
    model.tetloom.exit_status = 4;
    CHECK(verdict(model) == "exit 4");
    model.tetloom.timed_out = true;
    CHECK(verdict(model) == "too slow");
  }
  SECTION("a sheet has triangles alone") {
    model.facts.volumes.clear();
    model.tetloom.mesh->tets = 0;
    CHECK(is_valid(model));
    model.tetloom.mesh->triangles = 0;
    CHECK_FALSE(is_valid(model));
  }
}

TEST_CASE("descriptions and reports are read, whatever is missing in them") {
  RealModel model = filled();
  model.facts = {};
  take_description(json::parse(R"({"model": {"bounding_box": [[0, 0, 0], [1, 2, 2]],
      "regions": [{"volume": 1.5}, {"volume": 2}]}})"),
                   model.facts);
  CHECK(model.facts.diagonal == 3);
  CHECK(model.facts.volume() == 3.5);
  CHECK(model.facts.good_regions() == 2);
  take_report(json::parse(R"({"seconds": {"total": 4, "size_field": 1, "volume": null}, "digest": "abc",
      "quality": {"edges_in_band": 0.5}, "warnings": [{"message": "small"}],
      "errors": [{"code": "face_failed", "message": "face 3"}],
      "filling": {"acute_tets": {"worst": [
        {"dihedral_deg": 3, "cause": null, "cause_deg": null, "entities": []},
        {"dihedral_deg": 2, "cause": "narrow_region", "cause_deg": 2.5, "cause_length": 0.125,
         "entities": [{"dim": 2, "id": 7}, {"dim": 1, "id": 4}]}]}}})"),
              model);
  CHECK(model.stages.total == 4);
  CHECK(model.stages.size_field == 1);
  CHECK(model.stages.volume == 0);
  CHECK(model.digest == "abc");
  CHECK(model.tetloom.mesh->edges_in_band == .5);
  CHECK(model.tetloom.failure == "face_failed: face 3");
  REQUIRE(model.worst.has_value());
  CHECK(model.worst->dihedral_deg == 2);
  CHECK(model.worst->cause == "narrow_region");
  CHECK(model.worst->cause_length == 0.125);
  CHECK(model.worst->entities == "face 7, edge 4");

  RealModel nothing;
  take_description(json::object(), nothing.facts);
  take_report(json::object(), nothing);
  CHECK(nothing.facts.diagonal == 0);
  CHECK(nothing.stages.total == 0);
  CHECK_FALSE(nothing.worst.has_value());
}

TEST_CASE("speeds are compared where both have meshed the model") {
  RealModel partial = filled();
  partial.gmsh->mesh->volume = 4;
  CHECK_FALSE(can_compare(partial));
  CHECK_FALSE(can_compare(too_slow()));
  RealModel alone = filled();
  alone.gmsh.reset();
  CHECK_FALSE(can_compare(alone));

  const std::vector<RealModel> models{filled(1, 10), filled(2, 8), filled(4, 2), partial, too_slow(), alone};
  CHECK(row_of(models, "tets/s against Gmsh").value == "4.00 / 1 of 3");
  CHECK_FALSE(row_of(models, "tets/s against Gmsh").reached);
  CHECK(row_of(models, "wall time").value == "0.25");
  CHECK(row_of(models, "wall time").reached);
  CHECK(row_of({filled(1, 10)}, "tets/s against Gmsh").reached);
}

TEST_CASE("the summary counts models, and says where it misses what is asked") {
  RealModel flat = filled(), sharp = filled();
  flat.tetloom.mesh->min_dihedral_deg = .5;
  sharp.tetloom.mesh->min_dihedral_deg = 4;
  flat.stages.size_field = .5 * flat.stages.total;
  const std::vector<RealModel> models{filled(), flat, sharp, filled(), too_slow()};
  CHECK(row_of(models, "valid").value == "4 of 5 (Gmsh 5 of 5)");
  CHECK_FALSE(row_of(models, "valid").reached);
  CHECK(row_of(models, "longest run").value == "> 121.0 s, slow.step");
  CHECK_FALSE(row_of(models, "longest run").reached);
  CHECK(row_of(models, "size field").value == "10 % / 50 %");
  CHECK_FALSE(row_of(models, "size field").reached);
  CHECK(row_of(models, "smallest dihedral").value == "50 % / 25 %");
  CHECK_FALSE(row_of(models, "smallest dihedral").reached);
  CHECK(row_of(models, "mean ratio").value == "0.930 / 0.770");
  CHECK(row_of(models, "mean ratio").reached);
  CHECK(row_of(models, "edges in band").value == "98.0 %");
  CHECK(row_of(models, "closed manifold").value == "-");
  CHECK(row_of(models, "surface's distance").value == "- / -");
  for (const SummaryRow& row : summarize({})) CHECK(row.reached);
}

TEST_CASE("the distance of the surface from the model counts where it was measured") {
  RealModel near = filled(), far = filled();
  near.tetloom.mesh->surface_distance = .02, far.tetloom.mesh->surface_distance = .2;
  CHECK(row_of({near, filled()}, "surface's distance").value == "0.020 / 0.020");
  CHECK(row_of({near, filled()}, "surface's distance").reached);
  CHECK(row_of({near, far}, "surface's distance").value == "0.110 / 0.200");
  CHECK_FALSE(row_of({near, far}, "surface's distance").reached);
  CHECK(json(*far.tetloom.mesh).get<MeshFigures>().surface_distance == .2);
  CHECK_FALSE(json(MeshFigures{}).get<MeshFigures>().surface_distance.has_value());
}

TEST_CASE("meshes of over five million tets may take longer") {
  RealModel large = filled(50, 100);
  large.tetloom.mesh->tets = 6'000'000;
  CHECK(row_of({large, filled()}, "longest run").reached);
  large.tetloom.mesh->tets = 4'000'000;
  CHECK_FALSE(row_of({large, filled()}, "longest run").reached);
}

TEST_CASE("closed manifold triangle surfaces are counted apart") {
  RealModel closed = filled(), refused = too_slow();
  closed.facts.facets = closed.facts.closed_manifold = true;
  refused.facts.facets = refused.facts.closed_manifold = true;
  CHECK(row_of({closed, refused, filled()}, "closed manifold").value == "1 of 2");
  CHECK_FALSE(row_of({closed, refused, filled()}, "closed manifold").reached);
}
