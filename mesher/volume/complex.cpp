#include "mesher/volume/complex.hpp"

#include <algorithm>
#include <map>
#include <numeric>
#include <tuple>
#include <utility>

#include "core/base/disjoint_sets.hpp"
#include "core/base/failure.hpp"
#include "core/base/filing.hpp"
#include "core/base/lists.hpp"
#include "core/base/local_numbers.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/own_share.hpp"

namespace tetloom::volume {

namespace {

constexpr std::size_t kRegionsToldAtMost = 3;

std::size_t region_bound(const VolumeInput& input) {
  std::size_t bound = 0;
  for (const FaceSides& sides : input.tri_to_sides) {
    for (const ModelRegionId region : {sides.front, sides.back}) {
      if (region.valid()) bound = std::max<std::size_t>(bound, region.value + 1u);
    }
  }
  return bound;
}

// One appearance of an edge in the boundary of a region; `step` is +1 when it is run through from `low` to `high`.
struct EdgeUseOfRegion {
  std::uint32_t region, low, high, triangle;
  int step;
  auto key() const { return std::tuple(region, low, high); }
};

// Calls visit(use) for the edges of triangle t as the regions beside it use them.
template <class Visit>
void for_each_use(const VolumeInput& input, std::uint32_t t, const Visit& visit) {
  const FaceSides& sides = input.tri_to_sides[t];
  if (sides.front == sides.back) return;  // a sheet inside a region needs no closing
  for (const auto& [region, sign] : {std::pair(sides.back, 1), std::pair(sides.front, -1)}) {
    if (!region.valid()) continue;
    for (int i = 0; i < 3; ++i) {
      const std::uint32_t a = input.tri_to_vert[t][i], b = input.tri_to_vert[t][(i + 1) % 3];
      if (a == b) continue;  // opens nothing; that the triangle has no area is told later
      visit(EdgeUseOfRegion{region.value, std::min(a, b), std::max(a, b), t, a < b ? sign : -sign});
    }
  }
}

bool comes_before(const EdgeUseOfRegion& a, const EdgeUseOfRegion& b) {
  return std::pair(a.key(), a.triangle) < std::pair(b.key(), b.triangle);
}

// Of the uses of edges whose low vertices lie from `begin` on, below `end`: those of edges that are run through more
// often one way than the other. By vertex first, since sorting all at once takes longer than meshing.
std::vector<EdgeUseOfRegion> find_open(std::span<const EdgeUseOfRegion> uses, std::size_t begin, std::size_t end) {
  std::vector<std::size_t> next(end - begin + 1, 0);
  for (const EdgeUseOfRegion& use : uses) ++next[use.low - begin + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<EdgeUseOfRegion> by_vertex(uses.size()), open;
  for (const EdgeUseOfRegion& use : uses) by_vertex[next[use.low - begin]++] = use;
  auto first = by_vertex.begin();
  for (std::size_t v = begin; v < end; ++v) {  // each place still holds the end of its vertex
    const auto last = by_vertex.begin() + static_cast<std::ptrdiff_t>(next[v - begin]);
    std::sort(first, last, comes_before);
    while (first != last) {
      const auto other =
          std::find_if(first, last, [&](const EdgeUseOfRegion& use) { return use.key() != first->key(); });
      const int balance = std::accumulate(first, other, 0, [](int sum, const auto& use) { return sum + use.step; });
      if (balance != 0) open.insert(open.end(), first, other);
      first = other;
    }
  }
  return open;
}

// Of what for_each_in(i, visit) names for each i below `count`.
template <class ForEachIn>
std::vector<EdgeUseOfRegion> find_open_of(const VolumeInput& input, std::size_t count, const TaskRunner& runner,
                                          const ForEachIn& for_each_in) {
  const KeyRanges ranges(input.points.size());
  std::vector<std::vector<EdgeUseOfRegion>> range_to_open(ranges.count());
  for_each_filed_range<EdgeUseOfRegion>(
      count, ranges, runner,
      [&](std::size_t begin, std::size_t end, const auto& file) {
        for (std::size_t i = begin; i < end; ++i)
          for_each_in(i, [&](const EdgeUseOfRegion& use) { file(ranges.of(use.low), use); });
      },
      [&](std::size_t range, std::span<const EdgeUseOfRegion> uses) {
        range_to_open[range] = find_open(uses, ranges.first(range), ranges.last(range));
      });
  return joined(range_to_open);
}

std::vector<EdgeUseOfRegion> find_open_alone(const VolumeInput& input, const TaskRunner& runner) {
  return find_open_of(input, input.tri_to_vert.size(), runner, [&](std::size_t t, const auto& visit) {
    for_each_use(input, static_cast<std::uint32_t>(t), visit);
  });
}

// Each rank reads its share of the triangles, and looks at the edges whose low vertices are its own.
std::vector<EdgeUseOfRegion> find_open_on_ranks(const VolumeInput& input, const SharedWork& work) {
  const auto ranks = static_cast<std::size_t>(work.rank_count());
  const ItemRange share = own_share(input.tri_to_vert.size(), work);
  const std::vector<Bytes> sent = work.exchange([&](std::span<MessageWriter> to) {
    std::vector<std::vector<EdgeUseOfRegion>> rank_to_uses(ranks);
    for (std::size_t t = share.first; t < share.last; ++t)
      for_each_use(input, static_cast<std::uint32_t>(t), [&](const EdgeUseOfRegion& use) {
        rank_to_uses[use.low * ranks / input.points.size()].push_back(use);
      });
    for (std::size_t r = 0; r < ranks; ++r) to[r].put_array<EdgeUseOfRegion>(rank_to_uses[r]);
  });
  std::vector<EdgeUseOfRegion> own;
  work.each([&] {
    const auto uses = joined_lists<EdgeUseOfRegion>(sent);
    own = find_open_of(input, uses.size(), work.runner(), [&](std::size_t i, const auto& visit) { visit(uses[i]); });
  });
  return gather_lists<EdgeUseOfRegion>(work.ranks(), own);
}

Diagnostic open_shell(const VolumeInput& input, std::span<const EdgeUseOfRegion> open) {
  Diagnostic diagnostic;
  diagnostic.code = ErrorCode::OpenShell;
  std::vector<std::uint32_t> triangles;
  for (const EdgeUseOfRegion& use : open) triangles.push_back(use.triangle);
  diagnostic.entities = faces_of(input, triangles);
  const std::uint32_t region = open[0].region;
  diagnostic.message = "the boundary of " + describe_regions(input, std::span(&region, 1)) + " is not closed along " +
                       describe(diagnostic.entities[0]);
  diagnostic.entities.push_back(named_entity(input, {3, region}));
  diagnostic.point = 0.5 * (input.points[open[0].low] + input.points[open[0].high]);
  triangles.resize(std::min(triangles.size(), kElementsToldAtMost));
  diagnostic.elements.assign(triangles.begin(), triangles.end());
  return diagnostic;
}

bool has_all_points(const VolumeInput& input) {
  std::vector<char> is_used(input.points.size(), 0);
  for (const auto& verts : input.tri_to_vert)
    for (const std::uint32_t v : verts) is_used[v] = 1;
  return std::ranges::count(is_used, 0) == 0;
}

// Whether the complex has all points and triangles, so that the input's arrays will do; otherwise it gets its own.
// `numbers`: working memory.
bool number_vertices(const VolumeInput& input, ComplexArrays& complex, LocalNumbers& numbers) {
  if (complex.to_input_tri.size() == input.tri_to_vert.size() && has_all_points(input)) {
    complex.to_input_vert.resize(input.points.size());
    std::iota(complex.to_input_vert.begin(), complex.to_input_vert.end(), std::uint32_t{0});
    return true;
  }
  numbers.set_item_count(input.points.size());
  numbers.clear();
  for (const std::uint32_t t : complex.to_input_tri)
    for (const std::uint32_t v : input.tri_to_vert[t]) numbers.add(v);
  numbers.sort();
  complex.to_input_vert.assign(numbers.items().begin(), numbers.items().end());
  complex.points.reserve(numbers.size());
  complex.tri_to_vert.reserve(complex.to_input_tri.size());
  for (const std::uint32_t v : numbers.items()) complex.points.push_back(input.points[v]);
  for (const std::uint32_t t : complex.to_input_tri) {
    const auto& [a, b, c] = input.tri_to_vert[t];
    complex.tri_to_vert.push_back({numbers[a], numbers[b], numbers[c]});
  }
  return false;
}

}  // namespace

OpenRegions find_open_regions(const VolumeInput& input, const SharedWork& work) {
  std::vector<EdgeUseOfRegion> open =
      work.rank_count() > 1 ? find_open_on_ranks(input, work) : find_open_alone(input, work.runner());
  std::sort(open.begin(), open.end(), comes_before);
  OpenRegions result;
  for (std::size_t begin = 0, end = 0; begin < open.size(); begin = end) {
    while (end < open.size() && open[end].region == open[begin].region) ++end;
    result.regions.push_back(open[begin].region);
    result.diagnostics.push_back(open_shell(input, std::span(open).subspan(begin, end - begin)));
  }
  return result;
}

// Of triangles, in each pass over them, and then of points: the fewer of the two.
std::size_t open_region_pieces(const VolumeInput& input) {
  const FilingPlan plan(input.tri_to_vert.size(), 0);
  return std::min(input.tri_to_vert.size() / plan.grain() + 1, KeyRanges(input.points.size()).count());
}

Complexes split_complexes(const VolumeInput& input, std::span<const std::uint32_t> without) {
  const std::size_t region_count = region_bound(input);
  std::vector<char> left_out(region_count, 0);
  for (const std::uint32_t region : without) left_out[region] = 1;
  const auto kept = [&](ModelRegionId id) { return id.valid() && !left_out[id.value] ? id : ModelRegionId{}; };

  DisjointSets sets(region_count);
  std::vector<char> bounded(region_count, 0);
  for (const FaceSides& sides : input.tri_to_sides) {
    const ModelRegionId front = kept(sides.front), back = kept(sides.back);
    if (front.valid() && back.valid()) sets.join(front.value, back.value);
    for (const ModelRegionId id : {front, back}) {
      if (id.valid()) bounded[id.value] = 1;
    }
  }
  std::vector<std::vector<std::uint32_t>> complex_to_regions;
  std::vector<std::uint32_t> region_to_complex(region_count, 0);
  for (std::uint32_t region = 0; region < region_count; ++region) {
    if (!bounded[region]) continue;
    if (sets.find(region) == region) complex_to_regions.emplace_back();
    region_to_complex[region] = sets.find(region) == region ? static_cast<std::uint32_t>(complex_to_regions.size() - 1)
                                                            : region_to_complex[sets.find(region)];
    complex_to_regions[region_to_complex[region]].push_back(region);
  }
  const auto for_each_triangle = [&](const auto& visit) {
    for (std::uint32_t t = 0; t < input.tri_to_vert.size(); ++t) {
      const FaceSides sides{kept(input.tri_to_sides[t].front), kept(input.tri_to_sides[t].back)};
      const ModelRegionId any = sides.front.valid() ? sides.front : sides.back;
      if (any.valid()) visit(t, sides, region_to_complex[any.value]);
    }
  };
  std::vector<ComplexArrays> arrays(complex_to_regions.size());
  std::vector<std::size_t> counts(arrays.size(), 0);
  for_each_triangle([&](std::uint32_t, const FaceSides&, std::uint32_t complex) { ++counts[complex]; });
  for (std::size_t i = 0; i < arrays.size(); ++i) arrays[i].to_input_tri.reserve(counts[i]);
  for_each_triangle(
      [&](std::uint32_t t, const FaceSides&, std::uint32_t complex) { arrays[complex].to_input_tri.push_back(t); });
  LocalNumbers numbers;
  Complexes complexes;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    ComplexArrays& own = arrays[i];
    const bool is_all = number_vertices(input, own, numbers);
    if (!is_all || !without.empty()) {
      own.tri_to_sides.reserve(own.to_input_tri.size());
      for (const std::uint32_t t : own.to_input_tri)
        own.tri_to_sides.push_back({kept(input.tri_to_sides[t].front), kept(input.tri_to_sides[t].back)});
    }
    Complex& complex = complexes.list.emplace_back(own.view(std::move(complex_to_regions[i])));
    if (!is_all) continue;
    complex.points = input.points, complex.tri_to_vert = input.tri_to_vert;
    if (without.empty()) complex.tri_to_sides = input.tri_to_sides;
  }
  complexes.arrays = std::move(arrays);
  return complexes;
}

NamedEntity named_entity(const VolumeInput& input, ModelEntity entity) {
  if (input.model && entity.index < input.model->topology().count(entity.dim)) return input.model->named(entity);
  return {entity, {}};
}

std::vector<NamedEntity> faces_of(const VolumeInput& input, std::span<const std::uint32_t> triangles) {
  std::map<std::uint32_t, std::size_t> face_to_count;
  for (const std::uint32_t t : triangles) ++face_to_count[input.tri_to_face[t]];
  std::vector<std::pair<std::uint32_t, std::size_t>> faces(face_to_count.begin(), face_to_count.end());
  std::stable_sort(faces.begin(), faces.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  std::vector<NamedEntity> named;
  for (const auto& [face, count] : faces) named.push_back(named_entity(input, {2, face}));
  return named;
}

std::string describe_regions(const VolumeInput& input, std::span<const std::uint32_t> regions) {
  std::string text;
  for (std::size_t i = 0; i < std::min(regions.size(), kRegionsToldAtMost); ++i) {
    text += (i > 0 ? ", " : "") + describe(named_entity(input, {3, regions[i]}));
  }
  if (regions.size() > kRegionsToldAtMost) text += " … (" + std::to_string(regions.size()) + " in all)";
  return text;
}

}  // namespace tetloom::volume
