#include "mesher/volume/complex.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>

#include "core/base/disjoint_sets.hpp"

namespace tetloom::volume {

namespace {

constexpr std::size_t kElementsToldAtMost = 100;
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

// Calls visit(use) for the edges of all triangles as the regions beside them use them.
template <class Visit>
void for_each_use(const VolumeInput& input, const Visit& visit) {
  for (std::uint32_t t = 0; t < input.tri_to_vert.size(); ++t) {
    const FaceSides& sides = input.tri_to_sides[t];
    if (sides.front == sides.back) continue;  // a sheet inside a region needs no closing
    for (const auto& [region, sign] : {std::pair(sides.back, 1), std::pair(sides.front, -1)}) {
      if (!region.valid()) continue;
      for (int i = 0; i < 3; ++i) {
        const std::uint32_t a = input.tri_to_vert[t][i], b = input.tri_to_vert[t][(i + 1) % 3];
        if (a == b) continue;  // opens nothing; that the triangle has no area is told later
        visit(EdgeUseOfRegion{region.value, std::min(a, b), std::max(a, b), t, a < b ? sign : -sign});
      }
    }
  }
}

bool comes_before(const EdgeUseOfRegion& a, const EdgeUseOfRegion& b) {
  return std::pair(a.key(), a.triangle) < std::pair(b.key(), b.triangle);
}

// By `low`, and among those as comes_before says: buckets first, since sorting all at once takes longer than meshing.
std::vector<EdgeUseOfRegion> edge_uses(const VolumeInput& input) {
  std::vector<std::size_t> first(input.points.size() + 1, 0);
  for_each_use(input, [&](const EdgeUseOfRegion& use) { ++first[use.low + 1]; });
  std::partial_sum(first.begin(), first.end(), first.begin());
  std::vector<EdgeUseOfRegion> uses(first.back());
  std::vector<std::size_t> next(first.begin(), first.end() - 1);
  for_each_use(input, [&](const EdgeUseOfRegion& use) { uses[next[use.low]++] = use; });
  for (std::size_t v = 0; v < input.points.size(); ++v) {
    const auto at = [&](std::size_t i) { return uses.begin() + static_cast<std::ptrdiff_t>(i); };
    std::sort(at(first[v]), at(first[v + 1]), comes_before);
  }
  return uses;
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

// `to_local` holds kNone for all vertices, before and after.
void number_vertices(const VolumeInput& input, Complex& complex, std::vector<std::uint32_t>& to_local) {
  auto& vertices = complex.to_input_vert;
  for (const std::uint32_t t : complex.to_input_tri) {
    for (const std::uint32_t v : input.tri_to_vert[t]) {
      if (std::exchange(to_local[v], 0u) == kNone) vertices.push_back(v);
    }
  }
  std::sort(vertices.begin(), vertices.end());
  for (std::uint32_t i = 0; i < vertices.size(); ++i) {
    to_local[vertices[i]] = i;
    complex.points.push_back(input.points[vertices[i]]);
  }
  for (const std::uint32_t t : complex.to_input_tri) {
    const auto& [a, b, c] = input.tri_to_vert[t];
    complex.tri_to_vert.push_back({to_local[a], to_local[b], to_local[c]});
  }
  for (const std::uint32_t v : vertices) to_local[v] = kNone;
}

}  // namespace

OpenRegions find_open_regions(const VolumeInput& input) {
  const std::vector<EdgeUseOfRegion> uses = edge_uses(input);
  std::vector<EdgeUseOfRegion> open;
  for (std::size_t begin = 0, end = 0; begin < uses.size(); begin = end) {
    int balance = 0;
    for (end = begin; end < uses.size() && uses[end].key() == uses[begin].key(); ++end) balance += uses[end].step;
    if (balance != 0) open.insert(open.end(), uses.begin() + begin, uses.begin() + end);
  }
  std::sort(open.begin(), open.end(), comes_before);
  OpenRegions result;
  for (std::size_t begin = 0, end = 0; begin < open.size(); begin = end) {
    while (end < open.size() && open[end].region == open[begin].region) ++end;
    result.regions.push_back(open[begin].region);
    result.diagnostics.push_back(open_shell(input, std::span(open).subspan(begin, end - begin)));
  }
  return result;
}

std::vector<Complex> split_complexes(const VolumeInput& input, std::span<const std::uint32_t> without) {
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
  std::vector<Complex> complexes;
  std::vector<std::uint32_t> region_to_complex(region_count, 0);
  for (std::uint32_t region = 0; region < region_count; ++region) {
    if (!bounded[region]) continue;
    if (sets.find(region) == region) complexes.emplace_back();
    region_to_complex[region] = sets.find(region) == region ? static_cast<std::uint32_t>(complexes.size() - 1)
                                                            : region_to_complex[sets.find(region)];
    complexes[region_to_complex[region]].regions.push_back(region);
  }
  for (std::uint32_t t = 0; t < input.tri_to_vert.size(); ++t) {
    const FaceSides sides{kept(input.tri_to_sides[t].front), kept(input.tri_to_sides[t].back)};
    const ModelRegionId any = sides.front.valid() ? sides.front : sides.back;
    if (!any.valid()) continue;
    Complex& complex = complexes[region_to_complex[any.value]];
    complex.to_input_tri.push_back(t);
    complex.tri_to_sides.push_back(sides);
  }
  std::vector<std::uint32_t> to_local(input.points.size(), kNone);
  for (Complex& complex : complexes) number_vertices(input, complex, to_local);
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
