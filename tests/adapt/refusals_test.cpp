// What is refused has changed nothing, in parts with frozen sides and any metric.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <set>

#include "tests/adapt/one_round.hpp"
#include "tests/adapt/random_tensors.hpp"
#include "tests/support/mixed_mesh.hpp"

using namespace tetloom;
using namespace tetloom::adapt;

namespace {

/// Every bit of a part but what is noted about attempts: the state of vertices.
struct Contents {
  std::vector<std::byte> arrays;
  std::vector<std::array<std::uint32_t, 4>> triangles;
  std::vector<std::array<std::uint32_t, 3>> edges;
  friend bool operator==(const Contents&, const Contents&) = default;
};

template <class Array>
void append(std::vector<std::byte>& bytes, const Array& array) {
  const auto span = std::as_bytes(std::span(array.data(), array.size()));
  bytes.insert(bytes.end(), span.begin(), span.end());
}

Contents contents_of(const CavityMesh& part) {
  Contents c;
  append(c.arrays, part.mesh.points), append(c.arrays, part.mesh.to_vert), append(c.arrays, part.mesh.to_neighbor);
  append(c.arrays, part.mesh.to_fixed), append(c.arrays, part.mesh.to_region), append(c.arrays, part.to_quality);
  append(c.arrays, part.to_metric), append(c.arrays, part.to_entity), append(c.arrays, part.vert_to_tet);
  append(c.arrays, part.to_hint), append(c.arrays, part.to_frozen);
  part.surface.for_each_triangle([&](const SurfaceTriangle& t) {
    c.triangles.push_back({t.verts[0], t.verts[1], t.verts[2], t.face});
  });
  part.surface.for_each_edge([&](std::uint32_t a, std::uint32_t b, std::uint32_t edge) {
    c.edges.push_back({a, b, edge});
  });
  std::sort(c.triangles.begin(), c.triangles.end()), std::sort(c.edges.begin(), c.edges.end());
  return c;
}

std::size_t refusals(const Verdicts& verdicts) {
  std::size_t sum = 0;
  for (std::size_t i = 1; i < verdicts.size(); ++i) sum += verdicts[i];
  return sum;
}

/// Everything is tried, whatever has changed.
void ask_for_all(CavityMesh& part) {
  for (std::size_t v = 0; v < part.to_state.size(); ++v) part.to_state[v] = kChanged | kHasChanged | kUnsettled;
}

/// Carries out `pass` until it finds nothing to do any more, and demands that it then changes nothing. Returns how much
/// it was refused then.
std::size_t check_idle_pass(CavityMesh& part, Passes& passes, Verdicts PassCounts::*verdicts,
                            const std::function<std::size_t()>& pass) {
  constexpr int kMostPasses = 300;
  for (int i = 0; i < kMostPasses; ++i) {
    ask_for_all(part);
    const Contents before = contents_of(part);
    const std::size_t refused = refusals(passes.counts().*verdicts);
    if (pass() > 0) continue;
    CHECK((contents_of(part) == before));
    return refusals(passes.counts().*verdicts) - refused;
  }
  FAIL_CHECK("the pass always finds something to do");
  return 0;
}

/// Everywhere another metric, of sizes between two.
MetricField random_metric(const Mesh& mesh, unsigned seed, double least, double most, double aspect) {
  RandomTensors random(seed);
  MetricField metric;
  for (std::size_t v = 0; v < mesh.points.size(); ++v)
    metric.logs.push_back(log(compose(random.metric(random.uniform(least, most), aspect))));
  return metric;
}

/// How often splits, collapses, swaps and moves were refused.
using Refused = std::array<std::size_t, 4>;

Refused check_refusals(double aspect, std::size_t part_count) {
  CAPTURE(aspect, part_count);
  test::BoxSpec spec{4, 4, 4, true, 1};
  spec.h = 0.25;
  const Mesh box = test::make_tet_box(spec);
  MetricField metric = random_metric(box, 5, 0.3 / std::sqrt(aspect), 1.5 / std::sqrt(aspect), aspect);
  scale_to_complexity(metric, {box.points, box.tet_to_vert}, 50);
  const SurfaceProjector no_model;
  Refused refused{};
  const auto check = [&](CavityMesh& part, Passes& passes) {
    refused[2] += check_idle_pass(part, passes, &PassCounts::swaps, [&] { return passes.swap(0.9); });
    refused[1] +=
        check_idle_pass(part, passes, &PassCounts::collapses, [&] { return passes.collapse_edges(0.7, 1.45); });
    refused[0] += check_idle_pass(part, passes, &PassCounts::splits, [&] { return passes.split_edges(1.5); });
    refused[3] += check_idle_pass(part, passes, &PassCounts::moves, [&] { return passes.smooth(0.9); });
  };
  test::in_one_round(box, metric, no_model, part_count, check);
  return refused;
}

using SurfaceEdges = std::set<std::array<std::uint32_t, 2>>;

/// Edges of the surface between vertices that other parts have as well.
SurfaceEdges shared_surface_edges(const CavityMesh& part) {
  SurfaceEdges edges;
  part.surface.for_each_triangle([&](const SurfaceTriangle& triangle) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::uint32_t a = triangle.verts[i], b = triangle.verts[(i + 1) % 3];
      if (part.to_frozen[a] != 0 && part.to_frozen[b] != 0) edges.insert({std::min(a, b), std::max(a, b)});
    }
  });
  return edges;
}

}  // namespace

TEST_CASE("a part makes no edge of the surface between vertices that other parts have", "[short]") {
  // Another part may have it, or make it as well, where nothing but the vertices is shared: then the surface would
  // touch itself there.
  test::BoxSpec spec{10, 10, 3, false, 1};
  spec.h = 0.25;
  const Mesh box = test::make_tet_box(spec);
  const MetricField metric = random_metric(box, 7, 0.2, 1, 5);
  std::size_t operations = 0, shared = 0;
  const auto check = [&](CavityMesh& part, Passes& passes) {
    const SurfaceEdges before = shared_surface_edges(part);
    shared += before.size();
    for (int i = 0; i < 5; ++i) {
      ask_for_all(part);
      operations += passes.collapse_edges(0.7, 1.45) + passes.swap(0.9) + passes.split_edges(1.5) + passes.smooth(0.9);
    }
    CHECK(std::ranges::includes(before, shared_surface_edges(part)));
  };
  test::in_one_round(box, metric, {}, 6, check);
  CHECK(shared > 10);
  CHECK(operations > 100);
}

TEST_CASE("what passes refuse leaves a part as it was, bit by bit", "[short]") {
  Refused all{};
  for (const double aspect : {10.0, 1e4})
    for (const std::size_t part_count : {1u, 3u}) {
      const Refused refused = check_refusals(aspect, part_count);
      for (std::size_t i = 0; i < all.size(); ++i) all[i] += refused[i];
    }
  for (const std::size_t refused : all) CHECK(refused > 10);
}
