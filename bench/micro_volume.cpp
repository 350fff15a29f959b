// The steps of the volume mesher one by one, so that a step that becomes slower can be told from the others. They fill
// a ball: the whole of it is `fill_ball`, the other steps start from what the ones before left.
#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <numeric>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "bench/support/sphere_surface.hpp"
#include "core/predicates/predicates.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/lattice/lattice_core.hpp"
#include "mesher/tets/delaunay.hpp"
#include "mesher/tets/edge_removal.hpp"
#include "mesher/tets/insertion_order.hpp"
#include "mesher/tets/locate.hpp"
#include "mesher/tets/newton_smoothing.hpp"
#include "mesher/tets/optimizer.hpp"
#include "mesher/tets/recovery.hpp"
#include "mesher/tets/shell.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::bench {
namespace {

using lattice::LatticeCore;
using lattice::LevelPoints;
using lattice::SiteLattice;
using tets::TetMesh;

const TaskRunner kSerial(1);

std::vector<FaceSides> outward_sides(std::size_t triangles) {
  return std::vector<FaceSides>(triangles, {ModelRegionId{}, ModelRegionId{0}});
}

/// A ball with the size of its surface, filled step by step.
class Ball {
 public:
  explicit Ball(int levels) : surface_(make_sphere(levels)), sides_(outward_sides(surface_.tri_to_vert.size())) {
    const double area = 4 * 3.14159265358979 / static_cast<double>(surface_.tri_to_vert.size());
    sizes_ = SizeField::uniform(std::sqrt(kTrianglesPerSquare * area));
  }

  std::vector<LevelPoints> make_points() const {
    const intersection::TriangleTree tree(surface_.points, surface_.tri_to_vert, kSerial);
    lattice::LatticeRequest request{&tree, sides_, {}, &sizes_};
    for (const Vec3& x : surface_.points) request.box.add(x);
    return make_lattice_points(request, kSerial);
  }
  TetMesh make_empty() const {
    TetMesh mesh;
    mesh.points = GrowingArray<Vec3>(std::span(surface_.points));
    return mesh;
  }
  std::vector<std::uint32_t> shell_verts(const LatticeCore& core) const {
    std::vector<std::uint32_t> verts(surface_.points.size());
    std::iota(verts.begin(), verts.end(), 0u);
    verts.insert(verts.end(), core.shell_verts.begin(), core.shell_verts.end());
    return verts;
  }
  VolumeInput input() const {
    return {surface_.points, surface_.tri_to_vert, sides_, faces_of_triangles(), nullptr, &sizes_};
  }
  const Sphere& surface() const { return surface_; }
  tets::Surface sides() const { return {surface_.tri_to_vert, sides_}; }

 private:
  std::span<const std::uint32_t> faces_of_triangles() const {
    faces_.resize(surface_.tri_to_vert.size());
    return faces_;
  }

  Sphere surface_;
  std::vector<FaceSides> sides_;
  mutable std::vector<std::uint32_t> faces_;
  SizeField sizes_ = SizeField::uniform(1);
};

/// The core and the Delaunay shell around it, not joined yet.
struct CoreAndShell {
  TetMesh mesh, shell;
  LatticeCore core;

  explicit CoreAndShell(const Ball& ball) {
    mesh = ball.make_empty();
    core = emit_core(mesh, ball.make_points(), kSerial);
    shell.points = mesh.points;
    make_delaunay(shell, ball.shell_verts(core), kSerial);
    fix_core_faces(shell, mesh, core.open_faces);
  }
};

/// The ball filled, but not optimised.
TetMesh make_raw_filling(const Ball& ball) {
  CoreAndShell parts(ball);
  recover_boundary(parts.shell, ball.surface().tri_to_vert, {}, kSerial);
  join_shell(parts.mesh, std::move(parts.shell), parts.core.open_faces, ball.sides(), kSerial);
  return std::move(parts.mesh);
}

/// Runs `step` on what `prepare` makes afresh each time; only the step is timed. It returns how many items it did.
template <class Prepare, class Step>
void run_step(benchmark::State& state, const Prepare& prepare, const Step& step) {
  std::size_t items = 0;
  for (auto _ : state) {
    state.PauseTiming();
    {
      auto prepared = prepare();
      state.ResumeTiming();
      items += step(prepared);
      state.PauseTiming();
    }
    state.ResumeTiming();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(items));
}

/// Five points of the lattice, moved by up to 1e-4 where `state` asks for it; the first three and the fifth lie in one
/// plane without.
std::vector<std::array<Vec3, 5>> lattice_neighbors(const benchmark::State& state) {
  const double jitter = 1e-4 * static_cast<double>(state.range(0));
  std::mt19937_64 random(20100614);
  std::uniform_real_distribution<double> shift(-jitter, jitter);
  std::vector<std::array<Vec3, 5>> cases(1024);
  for (auto& one : cases) {
    one = {Vec3{0, 0, 0}, Vec3{2, 0, 0}, Vec3{1, 1, 1}, Vec3{1, -1, 1}, Vec3{0, 2, 2}};
    for (Vec3& x : one) x += Vec3{0.1, 0.3, 0.7} + Vec3{shift(random), shift(random), shift(random)};
  }
  return cases;
}

void insphere_of_lattice(benchmark::State& state) {
  const auto cases = lattice_neighbors(state);
  std::size_t i = 0;
  for (auto _ : state) {
    const auto& [a, b, c, d, e] = cases[i++ % cases.size()];
    benchmark::DoNotOptimize(insphere(a, b, c, d, e));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(insphere_of_lattice)->ArgName("jitter")->Arg(0)->Arg(1);

void orient3d_of_lattice(benchmark::State& state) {
  const auto cases = lattice_neighbors(state);
  std::size_t i = 0;
  for (auto _ : state) {
    const auto& one = cases[i++ % cases.size()];
    benchmark::DoNotOptimize(orient3d(one[0], one[1], one[2], one[4]));
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(orient3d_of_lattice)->ArgName("jitter")->Arg(0)->Arg(1);

void run_delaunay(benchmark::State& state, const std::vector<Vec3>& points) {
  std::vector<std::uint32_t> verts(points.size());
  std::iota(verts.begin(), verts.end(), 0u);
  run_step(
      state,
      [&] {
        TetMesh mesh;
        mesh.points = GrowingArray<Vec3>(std::span(points));
        return mesh;
      },
      [&](TetMesh& mesh) {
        make_delaunay(mesh, verts, kSerial);
        return mesh.size();
      });
}

void insert_random_points(benchmark::State& state) {
  std::mt19937_64 random(20100614);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vec3> points(static_cast<std::size_t>(state.range(0)));
  for (Vec3& x : points) x = {uniform(random), uniform(random), uniform(random)};
  run_delaunay(state, points);
}
BENCHMARK(insert_random_points)->ArgName("points")->Arg(10000)->Arg(200000)->Unit(benchmark::kMillisecond);

/// Points at random, one after the other as far apart as in an insertion (0) or anywhere (1).
void locate_points(benchmark::State& state) {
  std::mt19937_64 random(20100614);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<Vec3> points(200'000);
  for (Vec3& x : points) x = {uniform(random), uniform(random), uniform(random)};
  TetMesh mesh;
  mesh.points = GrowingArray<Vec3>(std::span(points));
  std::vector<std::uint32_t> order(points.size());
  std::iota(order.begin(), order.end(), 0u);
  make_delaunay(mesh, order, kSerial);
  if (state.range(0) == 0) order = tets::make_insertion_order(points, order);
  tets::Walk walk;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(walk.locate(mesh, points[order[i]] + Vec3{1e-9, 1e-9, 1e-9}));
    i = i + 1 < order.size() ? i + 1 : 0;
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(locate_points)->ArgName("anywhere")->Arg(0)->Arg(1);

void insert_lattice_points(benchmark::State& state) {
  const SiteLattice lattice(LatticeKind::Bcc, {0, 0, 0}, 1, 0, true);
  const auto width = static_cast<std::int32_t>(2 * std::cbrt(0.5 * static_cast<double>(state.range(0))));
  std::vector<Vec3> points;
  lattice.for_each_between({0, 0, 0}, {width, width, width},
                           [&](const lattice::Site& site) { points.push_back(lattice.point(site)); });
  run_delaunay(state, points);
}
BENCHMARK(insert_lattice_points)->ArgName("points")->Arg(10000)->Arg(200000)->Unit(benchmark::kMillisecond);

void place_lattice_points(benchmark::State& state) {
  const Ball ball(static_cast<int>(state.range(0)));
  run_step(
      state, [] { return 0; },
      [&](int) {
        std::size_t count = 0;
        for (const LevelPoints& level : ball.make_points()) count += level.sites.size();
        return count;
      });
}
BENCHMARK(place_lattice_points)->ArgName("levels")->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);

void emit_core_tets(benchmark::State& state) {
  const Ball ball(static_cast<int>(state.range(0)));
  const std::vector<LevelPoints> levels = ball.make_points();
  run_step(
      state, [&] { return ball.make_empty(); },
      [&](TetMesh& mesh) {
        emit_core(mesh, levels, kSerial);
        return mesh.size();
      });
}
BENCHMARK(emit_core_tets)->ArgName("levels")->Arg(4)->Arg(6)->Arg(7)->Unit(benchmark::kMillisecond);

/// All triangles are there: what it takes to see that.
void recover_nothing(benchmark::State& state) {
  const Ball ball(static_cast<int>(state.range(0)));
  const CoreAndShell parts(ball);
  run_step(
      state, [&] { return parts.shell; },
      [&](TetMesh& shell) {
        recover_boundary(shell, ball.surface().tri_to_vert, {}, kSerial);
        return ball.surface().tri_to_vert.size();
      });
}
BENCHMARK(recover_nothing)->ArgName("levels")->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);

/// A ball with spikes of a share of its radius, in percent; the items are the triangles that were missing. The other
/// figures are of one run.
void recover_spikes(benchmark::State& state) {
  Sphere spiky = make_sphere(static_cast<int>(state.range(0)));
  std::mt19937_64 random(20100614);
  std::uniform_real_distribution<double> radius(1 - 0.01 * static_cast<double>(state.range(1)), 1);
  for (Vec3& x : spiky.points) x = radius(random) * x;
  TetMesh mesh;
  mesh.points = GrowingArray<Vec3>(std::span(spiky.points));
  std::vector<std::uint32_t> verts(spiky.points.size());
  std::iota(verts.begin(), verts.end(), 0u);
  make_delaunay(mesh, verts, kSerial);
  tets::RecoveryReport report;
  run_step(
      state, [&] { return mesh; },
      [&](TetMesh& copy) {
        report = recover_boundary(copy, spiky.tri_to_vert, {}, kSerial);
        return report.missing_triangles;
      });
  if (report.missing_triangles == 0) state.SkipWithError("no triangle was missing, so nothing was measured");
  state.counters["triangles"] = static_cast<double>(spiky.tri_to_vert.size());
  state.counters["missing_triangles"] = static_cast<double>(report.missing_triangles);
  state.counters["unrecovered"] = static_cast<double>(report.unrecovered.size());
  state.counters["new_points"] = static_cast<double>(report.new_points);
}
BENCHMARK(recover_spikes)
    ->ArgNames({"levels", "depth"})
    ->Args({4, 20})
    ->Args({4, 50})
    ->Args({6, 5})
    ->Unit(benchmark::kMillisecond);

void join_shell_to_core(benchmark::State& state) {
  const Ball ball(static_cast<int>(state.range(0)));
  CoreAndShell parts(ball);
  recover_boundary(parts.shell, ball.surface().tri_to_vert, {}, kSerial);
  run_step(
      state, [&] { return std::pair(parts.mesh, parts.shell); },
      [&](std::pair<TetMesh, TetMesh>& copy) {
        join_shell(copy.first, std::move(copy.second), parts.core.open_faces, ball.sides(), kSerial);
        return copy.first.size();
      });
}
BENCHMARK(join_shell_to_core)->ArgName("levels")->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);

/// One pass over the filling; the items are the tets looked at.
void run_pass(benchmark::State& state, const std::function<std::size_t(tets::WorkingMesh&)>& pass) {
  const Ball ball(static_cast<int>(state.range(0)));
  const TetMesh raw = make_raw_filling(ball);
  const auto fixed = static_cast<std::uint32_t>(ball.surface().points.size());
  std::size_t changes = 0;
  run_step(
      state, [&] { return raw; },
      [&](TetMesh& mesh) {
        state.PauseTiming();
        tets::WorkingMesh working(mesh, fixed);
        state.ResumeTiming();
        changes = pass(working);
        return raw.size();
      });
  state.counters["changes"] = static_cast<double>(changes);
}

void remove_edges_below_60(benchmark::State& state) {
  run_pass(state, [](tets::WorkingMesh& mesh) { return remove_edges(mesh, tets::cube(.60), kSerial); });
}
BENCHMARK(remove_edges_below_60)->ArgName("levels")->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);

void move_vertices_below_70(benchmark::State& state) {
  run_pass(state, [](tets::WorkingMesh& mesh) { return move_vertices(mesh, tets::cube(.70), kSerial); });
}
BENCHMARK(move_vertices_below_70)->ArgName("levels")->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);

void optimize_ball(benchmark::State& state) {
  const Ball ball(static_cast<int>(state.range(0)));
  const TetMesh raw = make_raw_filling(ball);
  tets::OptimizeOptions options;
  options.fixed_points = static_cast<std::uint32_t>(ball.surface().points.size());
  run_step(
      state, [&] { return raw; },
      [&](TetMesh& mesh) {
        optimize(mesh, options, kSerial);
        return mesh.size();
      });
}
BENCHMARK(optimize_ball)->ArgName("levels")->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);

void fill_ball(benchmark::State& state) {
  const Ball ball(static_cast<int>(state.range(0)));
  const auto fill = [](const VolumeInput& input) {
    std::size_t tets = 0;
    for (const PartMesh& part : fill_volume(input, {}, kSerial).parts) tets += part.cell_count();
    return tets;
  };
  run_step(
      state, [&] { return ball.input(); }, fill);
}
BENCHMARK(fill_ball)->ArgName("levels")->Arg(4)->Arg(6)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace tetloom::bench
