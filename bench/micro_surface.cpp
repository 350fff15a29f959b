// The steps of the surface mesher one by one, so that a step that becomes slower can be told from the others.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include "bench/support/sphere_surface.hpp"
#include "bench/support/wavy_face.hpp"
#include "core/spatial/constrained_delaunay.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/surface/frontal_delaunay.hpp"
#include "mesher/surface/patch_optimizer.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::bench {
namespace {

constexpr double kAmplitude = 0.05;

bool keep_going() { return true; }

/// Cells meet a sphere inside the unit cube: refined down to `depth` there, with sizes that grow away from it.
class SphereOctree {
 public:
  explicit SphereOctree(int depth) : depth_(depth) {
    tree_.width = 1;
    tree_.domain = {{0, 0, 0}, {1, 1, 1}};
    tree_.size = 1;
    tree_.gradation = 0.3;
    add_block({0, 0, 0}, 1);
  }
  SizeField build() && {
    set_corner_ratios(tree_, leaf_to_ratios_);
    return SizeField::from_octree(std::move(tree_));
  }

 private:
  double size_at(const Vec3& x) const {
    return std::min(1.0, std::ldexp(1.0, -depth_) + 0.3 * std::abs(distance(x, {0.5, 0.5, 0.5}) - 0.3));
  }

  void add_block(const Vec3& origin, int level) {
    const std::size_t first = tree_.cells.size();
    tree_.cells.resize(first + 8);
    const double width = std::ldexp(1.0, -level);
    for (std::size_t octant = 0; octant < 8; ++octant) {
      const Vec3 corner = origin + width * offset(octant);
      const Vec3 center = corner + 0.5 * width * Vec3{1, 1, 1};
      const bool divide = level < depth_ && width > size_at(center);
      tree_.cells[first + octant] =
          divide ? static_cast<std::uint32_t>(tree_.cells.size() / 8) : add_leaf(corner, width);
      if (divide) add_block(corner, level + 1);
    }
  }

  std::uint32_t add_leaf(const Vec3& corner, double width) {
    std::array<float, 8> ratios{};
    for (std::size_t i = 0; i < 8; ++i) ratios[i] = static_cast<float>(size_at(corner + width * offset(i)));
    leaf_to_ratios_.push_back(ratios);
    return SizeOctree::kLeafBit + static_cast<std::uint32_t>(leaf_to_ratios_.size() - 1);
  }

  static Vec3 offset(std::size_t octant) {
    return {static_cast<double>(octant & 1), static_cast<double>(octant >> 1 & 1), static_cast<double>(octant >> 2)};
  }

  int depth_;
  SizeOctree tree_;
  std::vector<std::array<float, 8>> leaf_to_ratios_;
};

void look_up_size(benchmark::State& state) {
  const SizeField sizes = SphereOctree(static_cast<int>(state.range(0))).build();
  std::mt19937_64 random(20100614);
  std::normal_distribution<double> normal;
  std::vector<Vec3> points(4096);
  for (Vec3& p : points) p = Vec3{0.5, 0.5, 0.5} + 0.3 * normalized({normal(random), normal(random), normal(random)});
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(sizes.size_at(points[i++ % points.size()]));
  state.SetItemsProcessed(state.iterations());
  state.counters["leaves"] = static_cast<double>(sizes.leaf_count());
}
BENCHMARK(look_up_size)->ArgName("depth")->Arg(4)->Arg(7);

/// A star with wavy sides, whose triangulation has many segments to recover.
void triangulate_star(benchmark::State& state) {
  const auto count = static_cast<std::size_t>(state.range(0));
  std::vector<Vec2> points(count);
  std::vector<std::array<std::uint32_t, 2>> segments(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(count);
    const double radius = 1 + 0.5 * std::sin(9 * angle);
    points[i] = {radius * std::cos(angle), radius * std::sin(angle)};
    segments[i] = {static_cast<std::uint32_t>(i), static_cast<std::uint32_t>((i + 1) % count)};
  }
  for (auto _ : state) {
    const PolygonTriangulation result = triangulate_polygon(points, segments);
    if (result.verdict != PolygonVerdict::Ok) return state.SkipWithError("the star was not triangulated");
    benchmark::DoNotOptimize(result.triangulation.slots());
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}
BENCHMARK(triangulate_star)->ArgName("points")->Arg(100)->Arg(1000)->Arg(10000)->Unit(benchmark::kMillisecond);

std::size_t count_triangles(const Patch& patch) {
  std::size_t count = 0;
  for (std::uint32_t tri = 0; tri < patch.topology.slots(); ++tri) count += patch.topology.alive(tri) ? 1 : 0;
  return count;
}

double size_for(std::int64_t triangles) { return std::sqrt(kTrianglesPerSquare / static_cast<double>(triangles)); }

/// Runs `step` on a fresh copy of `patch` each time; what it makes of the patch is counted, the copying is not timed.
void run_step(benchmark::State& state, const Patch& patch, const std::function<void(Patch&)>& step) {
  std::size_t triangles = 0;
  for (auto _ : state) {
    state.PauseTiming();
    Patch copy = patch;
    state.ResumeTiming();
    step(copy);
    state.PauseTiming();
    triangles = count_triangles(copy);
    state.ResumeTiming();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(triangles));
  state.counters["triangles"] = static_cast<double>(triangles);
}

void refine_square(benchmark::State& state) {
  WavyFace face(kAmplitude);
  const SizeField sizes = SizeField::uniform(size_for(state.range(0)));
  const PatchSurface surface(face, sizes, {1, 1});
  run_step(state, make_square_patch(surface, sizes.smallest()),
           [&](Patch& patch) { refine_frontal(patch, surface, keep_going); });
}
BENCHMARK(refine_square)->ArgName("triangles")->Arg(1000)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond);

void optimize_square(benchmark::State& state) {
  WavyFace face(kAmplitude);
  const SizeField sizes = SizeField::uniform(size_for(state.range(0)));
  const PatchSurface surface(face, sizes, {1, 1});
  Patch refined = make_square_patch(surface, sizes.smallest());
  refine_frontal(refined, surface, keep_going);
  sort_spatially(refined);
  run_step(state, refined, [&](Patch& patch) { optimize_patch(patch, surface, {}, keep_going); });
}
BENCHMARK(optimize_square)->ArgName("triangles")->Arg(1000)->Arg(10000)->Arg(100000)->Unit(benchmark::kMillisecond);

void test_sphere_for_intersections(benchmark::State& state) {
  const Sphere sphere = make_sphere(static_cast<int>(state.range(0)));
  const TaskRunner runner(1);
  for (auto _ : state) {
    const auto found = find_self_intersections(
        {.points = sphere.points, .tri_to_vert = sphere.tri_to_vert, .tri_to_group = {}}, runner);
    if (!found.empty()) return state.SkipWithError("a sphere does not cross itself");
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(sphere.tri_to_vert.size()));
  state.counters["triangles"] = static_cast<double>(sphere.tri_to_vert.size());
}
BENCHMARK(test_sphere_for_intersections)->ArgName("levels")->Arg(4)->Arg(7)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tetloom::bench
