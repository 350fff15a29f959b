// Every real CAD model: the counts that are known of it, loops that close, parameter curves that lie on their edges,
// positive volumes. Prints a table.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>

#include "tests/cad/model_checks.hpp"
#include "tetloom/model.hpp"

using namespace tetloom;

namespace {

struct KnownModel {
  const char* file;
  std::size_t solids, faces, edges;
};

// From an independent count of the files.
constexpr KnownModel kModels[] = {
    {"OCCT__step_screw.step", 1, 10, 22},
    {"OCCT__occ_CrankArm.brep", 2, 53, 138},
    {"OCCT__occ_Axis_of_bearing.brep", 17, 63, 121},  // an eighteenth solid has no faces
    {"OCCT__occ_bottle.brep", 1, 71, 157},
    {"elmerfem__step_fusee.stp", 1, 249, 723},
    {"elmerfem__step_pump_carter_sup.stp", 1, 119, 295},
    {"netgen__tutorials_frame.step", 1, 375, 958},
    {"brlcad__nist_NIST_MBE_PMI_5.stp", 1, 163, 426},
    {"Original-Prusa-i3__STEP_fan-shroud.stp", 2, 188, 526},
    {"Voron-0__Electronics_Mounts_SKR_3_EZ_Din_Mount.step", 4, 805, 1976},
    {"open_robot_actuator_hardware__step_files_foot_structure.step", 1, 237, 627},
    {"GEOUNED__Torus_tank.stp", 12, 58, 127},
    {"build123d__docs_M6-1x12-countersunk-screw.step", 1, 28, 72},
    {"tigl__TestData_simplewing.brep", 1, 8, 15},
    {"parallel-preprocessor__test_geometry_test_selfintersect.stp", 1, 14, 45},
    {"gmsh__occ_ellipses.brep", 15, 51, 93},
    {"refine__uniform_annulus.brep", 1, 6, 12},
    // One of seven edges is a spur that the tolerance of its vertex swallows.
    {"brlcad__tests_ap214_permissive_shared_dangling_spur.stp", 1, 4, 6},
    {"GEOUNED__large_Triangle.stp", 229, 1592, 3404},
    {"OCCT__step_linkrods.step", 1, 37, 108},
    {"OCCT__occ_Top.brep", 1, 324, 755},
};

}  // namespace

TEST_CASE("every shared CAD model is read with its known counts and consistent loops") {
  const std::filesystem::path folder = std::filesystem::path(TETLOOM_SHARED_DIR) / "cad";
  if (!std::filesystem::exists(folder)) {
    WARN("skipped: no models in " << folder);
    return;
  }
  std::printf("%-44.44s %6s %6s %6s %6s %9s %9s %9s %6s %5s\n", "model", "solids", "faces", "edges", "read s", "uv gap",
              "3D gap", "pcurve", "healed", "warn");
  for (const KnownModel& known : kModels) {
    INFO(known.file);
    const test::TimedDocument timed = test::read_timed(folder / known.file);
    const GeometricModel& model = *timed.document.model;
    const test::LoopReport loops = test::check_loops(model);
    std::size_t healed = 0;
    for (const HealingStep& step : timed.document.healing) healed += step.count;
    std::printf("%-44.44s %6zu %6zu %6zu %6.2f %9.1e %9.1e %9.1e %6zu %5zu\n", known.file,
                model.topology().region_count(), model.topology().face_count(), model.topology().edge_count(),
                timed.seconds, loops.worst_uv_gap, loops.worst_point_gap, loops.worst_curve_gap, healed,
                timed.document.warnings.size());
    for (const HealingStep& step : timed.document.healing)
      std::printf("    healed: %s (%zu)\n", step.what.c_str(), step.count);
    for (std::size_t i = 0; i < std::min<std::size_t>(5, timed.document.warnings.size()); ++i)
      std::printf("    warning: %s\n", test::describe(timed.document.warnings[i]).c_str());
    std::fflush(stdout);
    CHECK(model.topology().region_count() == known.solids);
    CHECK(model.topology().face_count() == known.faces);
    CHECK(model.topology().edge_count() == known.edges);
    CHECK(loops.disconnected == 0);
    CHECK(loops.off_curve == 0);
    for (std::size_t i = 0; i < model.topology().region_count(); ++i) CHECK(model.volume(ModelRegionId(i)) > 0);
  }
}
