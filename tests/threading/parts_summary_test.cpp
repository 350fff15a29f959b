// Figures of a mesh in parts are those of the mesh in one piece, on any number of ranks.
#include "threading/parts/parts_summary.hpp"

#include <catch2/catch.hpp>
#include <vector>

#include "core/part/convert.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tests/threading/part_cases.hpp"
#include "threading/comm/simulated_ranks.hpp"
#include "threading/parts/gather_mesh.hpp"

using namespace tetloom;

namespace {

constexpr double kSize = 0.8;

/// On each rank.
std::vector<PartsSummary> summaries(const Mesh& mesh, int ranks, std::size_t parts, test::Dealing dealing) {
  std::vector<PartsSummary> all(static_cast<std::size_t>(ranks));
  const SizeField sizes = SizeField::uniform(kSize);
  on_simulated_ranks(ranks, [&](Communicator& communicator) {
    const TaskRunner runner(ranks == 1 ? 3 : 1);
    PartitionedMesh dealt = distribute_mesh(mesh, communicator);
    migrate(dealt, test::deal(dealt, parts, dealing, 7), parts, runner);
    all[static_cast<std::size_t>(communicator.rank())] = summarize_parts(dealt, runner, &sizes);
  });
  return all;
}

void check_edges(const EdgeConformity& found, const EdgeConformity& expected) {
  CHECK(found.edges == expected.edges);
  CHECK(found.mean_length == Approx(expected.mean_length));
  CHECK(found.mean_length_ratio == Approx(expected.mean_length_ratio));
  CHECK(found.in_band == Approx(expected.in_band));
}

void check_quality(const QualityReport& found, const QualityReport& expected) {
  CHECK(found.cells.counts == expected.cells.counts);
  CHECK(found.cells.inverted == expected.cells.inverted);
  CHECK(found.cells.volume == Approx(expected.cells.volume));
  CHECK(found.cells.min_scaled_jacobian == expected.cells.min_scaled_jacobian);
  CHECK(found.cells.scaled_jacobian_p1 == expected.cells.scaled_jacobian_p1);
  check_edges(found.tets.edges, expected.tets.edges);
  check_edges(found.triangles.edges, expected.triangles.edges);
  REQUIRE(found.cells.regions.size() == expected.cells.regions.size());
  for (std::size_t i = 0; i < found.cells.regions.size(); ++i) {
    CHECK(found.cells.regions[i].region == expected.cells.regions[i].region);
    CHECK(found.cells.regions[i].cells == expected.cells.regions[i].cells);
    CHECK(found.cells.regions[i].tets == expected.cells.regions[i].tets);
    CHECK(found.cells.regions[i].volume == Approx(expected.cells.regions[i].volume));
  }
  CHECK(found.tets.count == expected.tets.count);
  CHECK(found.tets.min_dihedral_deg == expected.tets.min_dihedral_deg);
  CHECK(found.tets.mean_ratio_min == expected.tets.mean_ratio_min);
  CHECK(found.tets.mean_ratio_p1 == expected.tets.mean_ratio_p1);
  CHECK(found.tets.mean_ratio_mean == Approx(expected.tets.mean_ratio_mean));
  CHECK(found.tets.mean_ratio_histogram == expected.tets.mean_ratio_histogram);
  CHECK(found.tets.dihedral_histogram == expected.tets.dihedral_histogram);
  CHECK(found.triangles.count == expected.triangles.count);
  CHECK(found.triangles.shape_p1 == expected.triangles.shape_p1);
  CHECK(found.triangles.area == Approx(expected.triangles.area));
  REQUIRE(found.triangles.faces.size() == expected.triangles.faces.size());
  for (std::size_t i = 0; i < found.triangles.faces.size(); ++i) {
    CHECK(found.triangles.faces[i].face == expected.triangles.faces[i].face);
    CHECK(found.triangles.faces[i].triangles == expected.triangles.faces[i].triangles);
    CHECK(found.triangles.faces[i].min_angle_deg == expected.triangles.faces[i].min_angle_deg);
  }
}

}  // namespace

TEST_CASE("figures and digest of parts are those of the whole mesh", "[parts]") {
  for (unsigned seed = 0; seed < 6; ++seed) {
    Mesh mesh = test::make_case(seed);
    // Parts have none of the points that no cell uses.
    mesh = make_mesh(make_part(mesh));
    const std::string digest = mesh_digest(mesh);
    const SizeField sizes = SizeField::uniform(kSize);
    const QualityReport quality = compute_quality(mesh, &sizes);
    for (const std::size_t parts : {1, 2, 9}) {
      for (const int ranks : {1, 2, 3}) {
        const auto dealing = test::dealing_of(seed + parts);
        CAPTURE(seed, parts, ranks, static_cast<int>(dealing));
        for (const PartsSummary& summary : summaries(mesh, ranks, parts, dealing)) {
          CHECK(summary.digest == digest);
          CHECK(summary.points == mesh.points.size());
          CHECK(summary.triangles == mesh.tri_to_vert.size());
          CHECK(summary.tets == mesh.tet_to_vert.size());
          check_quality(summary.quality, quality);
        }
      }
    }
  }
}

TEST_CASE("figures of parts do not depend on ranks and threads, bit for bit", "[parts]") {
  const Mesh mesh = test::make_tet_box(6, 5, 4, 3, true);
  const PartsSummary one = summaries(mesh, 1, 5, test::Dealing::Scatter)[0];
  for (const int ranks : {2, 3, 7})
    for (const PartsSummary& other : summaries(mesh, ranks, 5, test::Dealing::Scatter)) {
      CAPTURE(ranks);
      CHECK(other.quality.cells.volume == one.quality.cells.volume);
      CHECK(other.quality.tets.mean_ratio_mean == one.quality.tets.mean_ratio_mean);
      CHECK(other.quality.triangles.area == one.quality.triangles.area);
      CHECK(other.quality.tets.edges.mean_length_ratio == one.quality.tets.edges.mean_length_ratio);
      CHECK(other.quality.triangles.edges.mean_length == one.quality.triangles.edges.mean_length);
    }
}

TEST_CASE("an inverted tet and a point without an entity are counted once", "[parts]") {
  Mesh mesh = test::make_tet_box(4, 4, 4, 3);
  std::swap(mesh.tet_to_vert[50][0], mesh.tet_to_vert[50][1]);
  mesh.point_to_entity[mesh.tet_to_vert[90][2]] = ModelEntity();
  for (const PartsSummary& summary : summaries(mesh, 3, 8, test::Dealing::Scatter)) {
    CHECK(summary.quality.cells.inverted == 1);
    CHECK(summary.quality.tets.min_dihedral_deg == 0);
    CHECK(summary.unclassified_points == 1);
  }
}

TEST_CASE("all ranks have the gathered mesh, where it is copied to all", "[parts]") {
  for (unsigned seed = 0; seed < 4; ++seed) {
    const Mesh mesh = test::make_case(seed);
    for (const int ranks : {1, 2, 3}) {
      CAPTURE(seed, ranks);
      std::vector<Mesh> copies(static_cast<std::size_t>(ranks));
      Mesh gathered;
      on_simulated_ranks(ranks, [&](Communicator& communicator) {
        const SharedWork work(1, {}, &communicator);
        work.together([&] {
          PartitionedMesh dealt = distribute_mesh(mesh, work.ranks());
          migrate(dealt, test::deal(dealt, 5, test::Dealing::Scatter, seed), 5, work.runner());
          Mesh whole = gather_mesh(dealt, work.runner());
          if (communicator.rank() == 0) gathered = std::move(whole);
          copies[static_cast<std::size_t>(communicator.rank())] = copy_to_all(std::move(dealt), work);
        });
      });
      for (const Mesh& copy : copies) {
        CHECK(copy.points == gathered.points);
        CHECK(copy.tet_to_vert == gathered.tet_to_vert);
        CHECK(copy.tri_to_vert == gathered.tri_to_vert);
        CHECK(mesh_digest(copy) == mesh_digest(gathered));
        CHECK(field_digest(copy) == field_digest(gathered));
      }
    }
  }
}

TEST_CASE("a summary that is cancelled on one rank is cancelled on all", "[parts]") {
  const Mesh mesh = test::make_tet_box(4, 4, 4, 3);
  std::vector<ErrorCode> codes(2, ErrorCode::Internal);
  on_simulated_ranks(2, [&](Communicator& communicator) {
    const auto rank = static_cast<std::size_t>(communicator.rank());
    PartitionedMesh dealt = distribute_mesh(mesh, communicator);
    migrate(dealt, test::deal(dealt, 4, test::Dealing::Slabs, 1), 4, TaskRunner(1));
    CancelToken stop;
    if (rank == 1) stop.cancel();
    const TaskRunner runner(1, {nullptr, &stop});
    codes[rank] = test::error_of([&] { summarize_parts(dealt, runner); }).code;
  });
  CHECK(codes == std::vector<ErrorCode>(2, ErrorCode::Cancelled));
}
