// Coarse surfaces of real CAD models, their vertices moved at random until triangles nearly cross each other, filled by
// our own means. Prints a table. Skipped with a message where the models are not there.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdio>
#include <filesystem>
#include <random>

#include "core/predicates/predicates.hpp"
#include "mesher/complexes.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tests/mesher/real_models.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;
namespace fs = std::filesystem;

namespace {

constexpr int kRoundsAtMost = 12;

struct CoarseModel {
  Surface surface;
  std::vector<std::uint32_t> tri_to_group;  // triangles of different groups may cross
  SizeField sizes = SizeField::uniform(1);
};

CoarseModel mesh_coarsely(const GeometricModel& model) {
  MeshOptions options;
  options.sizes.relative_size = 1.0 / 15;
  options.surface_only = true;
  const MeshResult result = make_mesh(model, options);
  CHECK(result.status == MeshStatus::Ok);
  CoarseModel coarse;
  coarse.sizes = result.sizes;
  coarse.surface.points = result.mesh.points;
  const std::vector<std::uint32_t> face_to_group = find_complexes(model.topology());
  for (std::size_t t = 0; t < result.mesh.tri_to_vert.size(); ++t) {
    const std::uint32_t face = result.mesh.tri_to_entity[t];
    coarse.surface.tri_to_vert.push_back(result.mesh.tri_to_vert[t]);
    coarse.surface.tri_to_face.push_back(face);
    coarse.surface.tri_to_sides.push_back(model.topology().face_to_sides[face]);
    coarse.tri_to_group.push_back(face_to_group[face]);
  }
  return coarse;
}

// The mean length of the edges at each point.
std::vector<double> lengths_at_points(const Surface& surface) {
  std::vector<double> sums(surface.points.size(), 0), counts(surface.points.size(), 0);
  for (const auto& v : surface.tri_to_vert) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double length = distance(surface.points[v[i]], surface.points[v[(i + 1) % 3]]);
      for (const std::uint32_t end : {v[i], v[(i + 1) % 3]}) sums[end] += length, counts[end] += 1;
    }
  }
  for (std::size_t v = 0; v < sums.size(); ++v) sums[v] /= std::max(counts[v], 1.0);
  return sums;
}

// Moves every point by `share` of its edges' length at most. Where triangles meet then, their points go half of the way
// back, until none do: they end close to each other. Returns false where that comes to no end.
bool perturb(CoarseModel& model, double share, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> amount(-1, 1);
  const std::vector<Vec3> before = model.surface.points;
  const std::vector<double> lengths = lengths_at_points(model.surface);
  for (std::size_t v = 0; v < before.size(); ++v)
    model.surface.points[v] += share * lengths[v] * Vec3{amount(random), amount(random), amount(random)};
  for (int round = 0; round < kRoundsAtMost; ++round) {
    const auto hits = find_self_intersections(
        {model.surface.points, model.surface.tri_to_vert, model.tri_to_group, 100'000}, TaskRunner(2));
    if (hits.empty()) return true;
    std::vector<char> goes_back(before.size(), 0);
    for (const TriangleIntersection& hit : hits) {
      for (const std::uint32_t t : {hit.first, hit.second}) {
        for (const std::uint32_t v : model.surface.tri_to_vert[t]) goes_back[v] = 1;
      }
    }
    for (std::size_t v = 0; v < before.size(); ++v) {
      if (goes_back[v]) model.surface.points[v] = 0.5 * (model.surface.points[v] + before[v]);
    }
  }
  return false;
}

std::size_t count_regions(const Surface& surface) {
  std::set<std::uint32_t> regions;
  for (const FaceSides& sides : surface.tri_to_sides) {
    for (const ModelRegionId side : {sides.front, sides.back})
      if (side.valid()) regions.insert(side.value);
  }
  return regions.size();
}

struct Tally {
  std::size_t regions = 0, filled = 0, missing = 0, points = 0;
};

void fill(const CoarseModel& model, Tally& tally) {
  const VolumeMesh mesh = fill_volume(model.surface.input(model.sizes), {}, TaskRunner(2));
  CHECK(mesh.figures.worker_complexes == 0);
  std::set<std::uint32_t> unfilled;
  for (const Diagnostic& error : mesh.errors) {
    UNSCOPED_INFO(error.message);
    CHECK(error.point);
    CHECK(!error.elements.empty());
    for (const NamedEntity& entity : error.entities)
      if (entity.entity.dim == 3) unfilled.insert(entity.entity.index);
  }
  tally.filled += check_filling(model.surface, mesh, unfilled).size();
  tally.regions += count_regions(model.surface);
  tally.missing += mesh.figures.missing_triangles;
  tally.points += mesh.figures.recovery_points;
}

}  // namespace

TEST_CASE("coarse surfaces of real models are filled when they are perturbed until they nearly cross themselves") {
  const std::vector<fs::path> models = test::list_real_models();
  if (models.empty()) {
    WARN("skipped: no models in " << test::kRealModels);
    return;
  }
  std::printf("%-52s %6s %9s %8s %8s %7s\n", "model", "moved", "triangles", "filled", "missing", "points");
  Tally all;
  for (std::size_t i = 0; i < models.size(); ++i) {
    INFO(models[i]);
    const ModelDocument document = read_model(models[i]);
    const CoarseModel coarse = mesh_coarsely(*document.model);
    for (const double share : {0.01, 0.05, 0.2}) {
      INFO("moved by " << share << " of the local length, seed " << i);
      CoarseModel perturbed = coarse;
      Tally tally;
      if (!perturb(perturbed, share, i)) continue;
      fill(perturbed, tally);
      std::printf("%-52.52s %5.0f%% %9zu %4zu/%-3zu %8zu %7zu\n", models[i].filename().c_str(), 100 * share,
                  perturbed.surface.tri_to_vert.size(), tally.filled, tally.regions, tally.missing, tally.points);
      std::fflush(stdout);
      all.regions += tally.regions, all.filled += tally.filled;
    }
  }
  std::printf("%zu of %zu regions filled\n", all.filled, all.regions);
  CHECK(all.filled == all.regions);
}
