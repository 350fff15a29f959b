#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numeric>
#include <random>

#include "core/base/filing.hpp"
#include "core/mesh/statistics_detail.hpp"
#include "tests/support/block_loops.hpp"
#include "tests/support/error_of.hpp"
#include "tests/support/mixed_mesh.hpp"
#include "tetloom/check.hpp"
#include "tetloom/error.hpp"

using namespace tetloom;
using test::BackwardsLoop;
using test::error_of;
using test::ThreadsLoop;

namespace {

using Blocks = std::vector<std::pair<std::size_t, std::size_t>>;

/// Numbers whose sums depend on the order of the terms, for all of the figures of a report.
std::vector<double> figures_of(const QualityReport& report) {
  const TetQuality& tets = report.tets;
  const TriangleQuality& triangles = report.triangles;
  std::vector<double> figures{report.cells.volume,
                              tets.min_dihedral_deg,
                              tets.mean_ratio_min,
                              tets.mean_ratio_p1,
                              tets.mean_ratio_mean,
                              tets.volume,
                              tets.edges.mean_length,
                              tets.edges.in_band,
                              tets.edges.mean_length_ratio,
                              triangles.shape_min,
                              triangles.shape_p1,
                              triangles.shape_mean,
                              triangles.min_angle_deg,
                              triangles.area,
                              triangles.edges.mean_length,
                              triangles.edges.in_band,
                              triangles.edges.mean_length_ratio};
  for (const std::size_t count : {tets.inverted, tets.edges.edges, triangles.edges.edges, report.cells.inverted})
    figures.push_back(static_cast<double>(count));
  for (const std::size_t count : tets.mean_ratio_histogram) figures.push_back(static_cast<double>(count));
  for (const std::size_t count : tets.dihedral_histogram) figures.push_back(static_cast<double>(count));
  for (const RegionQuality& region : report.cells.regions)
    figures.insert(figures.end(), {static_cast<double>(region.region), static_cast<double>(region.tets),
                                   static_cast<double>(region.cells), region.volume});
  for (const FaceQuality& face : triangles.faces)
    figures.insert(figures.end(), {static_cast<double>(face.face), face.area, face.min_angle_deg});
  return figures;
}

std::string text_of(const ValidationReport& report) {
  std::string text;
  for (const MeshProblem& problem : report.problems) {
    text += std::string(to_string(problem.kind)) + ' ' + problem.message;
    for (const std::uint64_t element : problem.elements) text += ' ' + std::to_string(element);
    if (problem.point) text += " at " + std::to_string(problem.point->x) + ' ' + std::to_string(problem.point->y);
    text += '\n';
  }
  for (const std::size_t count : {report.unused_points, report.unclassified_points, report.boundary_faces,
                                  report.interface_faces, report.open_edges, report.nonmanifold_edges})
    text += std::to_string(count) + ' ';
  return text;
}

/// Large enough for several blocks of everything. Some elements are broken in most of the ways there are.
Mesh broken_mesh() {
  Mesh mesh = test::make_mixed_box(24, 24, 12, 7, true);
  std::mt19937_64 random(5);
  const auto any = [&](std::size_t count) { return random() % count; };
  for (int i = 0; i < 40; ++i) {
    std::swap(mesh.tet_to_vert[any(mesh.tet_to_vert.size())][0], mesh.tet_to_vert[any(mesh.tet_to_vert.size())][1]);
    mesh.tet_to_vert.push_back(mesh.tet_to_vert[any(mesh.tet_to_vert.size())]);
    mesh.tet_to_entity.push_back(static_cast<std::uint32_t>(i % 3));
    mesh.tri_to_vert.push_back(mesh.tri_to_vert[any(mesh.tri_to_vert.size())]);
    mesh.tri_to_entity.push_back(static_cast<std::uint32_t>(i));
    std::swap(mesh.tri_to_vert[any(1000)][0], mesh.tri_to_vert[any(1000)][1]);
    mesh.prism_to_entity[any(mesh.prism_to_entity.size())] = ModelRegionId::kNone;
    mesh.point_to_entity[any(mesh.points.size())] = ModelEntity(1, 2);
    mesh.points.push_back({1, 2, 3});
    mesh.point_to_entity.push_back({});
  }
  return mesh;
}

}  // namespace

TEST_CASE("the serial loop goes through blocks cut at multiples of the grain, in their order") {
  Blocks blocks;
  const auto note = [&](std::size_t begin, std::size_t end) { blocks.emplace_back(begin, end); };
  serial_loop().for_blocks(7, 3, note);
  CHECK(blocks == Blocks{{0, 3}, {3, 6}, {6, 7}});
  serial_loop().for_blocks(0, 3, note);
  CHECK(blocks.size() == 3);
}

TEST_CASE("results of blocks come in the order of the blocks, whoever carries them out") {
  const auto sum = [](std::size_t begin, std::size_t end, std::size_t& result) {
    for (std::size_t i = begin; i < end; ++i) result += i;
  };
  const std::vector<std::size_t> expected{3, 12, 6};
  CHECK(map_blocks(serial_loop(), 7, 3, std::size_t{0}, sum) == expected);
  CHECK(map_blocks(BackwardsLoop(), 7, 3, std::size_t{0}, sum) == expected);
  CHECK(map_blocks(ThreadsLoop(5), 7, 3, std::size_t{0}, sum) == expected);
}

TEST_CASE("items are filed under their ranges in the order of the sources, in however many goes") {
  const std::size_t sources = 100'000, keys = 30'000;
  const KeyRanges ranges(keys);
  REQUIRE(ranges.count() > 5);
  const auto key_of = [&](std::size_t source) { return source * 7919 % keys; };
  const auto emit = [&](std::size_t begin, std::size_t end, const auto& file) {
    for (std::size_t i = begin; i < end; ++i) file(ranges.of(key_of(i)), static_cast<std::uint64_t>(i));
  };
  std::vector<std::vector<std::uint64_t>> expected(ranges.count());
  for (std::size_t i = 0; i < sources; ++i) expected[ranges.of(key_of(i))].push_back(i);
  for (const std::size_t limit : {std::size_t{1}, std::size_t{20'000}, sources}) {
    INFO(limit);
    std::vector<std::vector<std::uint64_t>> filed(ranges.count());
    const auto visit = [&](std::size_t range, std::span<const std::uint64_t> items) {
      filed[range].insert(filed[range].end(), items.begin(), items.end());
    };
    for_each_filed_range<std::uint64_t>(sources, ranges, ThreadsLoop(3), emit, visit, limit);
    CHECK(filed == expected);
  }
}

TEST_CASE("ranges cover all keys") {
  for (const std::size_t keys : {0, 1, 2048, 2049, 5'000'000}) {
    const KeyRanges ranges(keys);
    std::size_t end = 0;
    for (std::size_t range = 0; range < ranges.count(); ++range) {
      CHECK(ranges.first(range) == end);
      end = ranges.last(range);
      CHECK(ranges.of(end - 1) == range);
    }
    CHECK(end == keys);
    CHECK(ranges.count() <= 2048);
  }
}

TEST_CASE("a quantile is that of the sorted values") {
  std::mt19937_64 random(11);
  for (const std::size_t count : {1, 2, 3, 100, 101, 200'000}) {
    for (const float equal_share : {0.f, 0.5f, 1.f}) {
      INFO(count << " values, equal: " << equal_share);
      std::vector<float> values(count);
      std::uniform_real_distribution<float> uniform;
      for (float& value : values) value = uniform(random) < equal_share ? 0.25f : uniform(random) * 1.01f;
      std::vector<float> sorted = values;
      std::sort(sorted.begin(), sorted.end());
      for (const double share : {0.0, 0.01, 0.5, 1.0}) {
        const double position = share * static_cast<double>(count - 1);
        const auto below = static_cast<std::size_t>(position);
        const double low = sorted[below], high = sorted[std::min(below + 1, count - 1)];
        const double expected = low + (position - static_cast<double>(below)) * (high - low);
        CHECK(detail::quantile(values, share, ThreadsLoop(3)) == expected);
      }
    }
  }
  CHECK(detail::quantile({}, 0.5, serial_loop()) == 0);
}

TEST_CASE("no figure, digest or problem of a mesh depends on who carries out the loops") {
  const Mesh sound = test::make_mixed_box(24, 24, 12, 7, true);
  REQUIRE(validate_mesh(sound).valid());
  for (const Mesh& mesh : {sound, broken_mesh()}) {
    REQUIRE(mesh.tet_to_vert.size() > 32768);
    const SizeField sizes = SizeField::uniform(1);
    const std::vector<double> figures = figures_of(compute_quality(mesh, &sizes));
    const std::string digest = mesh_digest(mesh), fields = field_digest(mesh), problems = text_of(validate_mesh(mesh));
    const auto check = [&](const BlockLoop& loop) {
      CHECK(figures_of(compute_quality(mesh, &sizes, loop)) == figures);
      CHECK(mesh_digest(mesh, loop) == digest);
      CHECK(field_digest(mesh, loop) == fields);
      CHECK(text_of(validate_mesh(mesh, loop)) == problems);
    };
    check(BackwardsLoop());
    for (const std::size_t threads : {2, 7}) check(ThreadsLoop(threads));
  }
  CHECK(validate_mesh(broken_mesh()).problems.size() > 8);
}

TEST_CASE("the first of several bad indices is named, whoever finds it") {
  Mesh mesh = test::make_tet_box(24, 24, 24);
  mesh.tet_to_vert[80'000][1] = 1'000'000;
  mesh.tet_to_vert[5][2] = 2'000'000;
  mesh.tet_to_vert[5][3] = 3'000'000;
  for (const Diagnostic& error :
       {error_of([&] { mesh_digest(mesh); }), error_of([&] { mesh_digest(mesh, BackwardsLoop()); }),
        error_of([&] { compute_quality(mesh, nullptr, ThreadsLoop(4)); })}) {
    CHECK(error.code == ErrorCode::InvalidArgument);
    CHECK(error.elements == std::vector<std::uint64_t>{5});
    CHECK_THAT(error.message, Catch::Contains("refers to point 2000000 of"));
  }
}
