#include "mesher/intersection/pinched_edges.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/lists.hpp"

namespace tetloom {

namespace {

constexpr std::size_t kTrianglesOfList = 1 << 12;

struct Side {
  std::array<std::uint32_t, 2> ends;  // ascending
  std::uint32_t triangle = 0;
  auto operator<=>(const Side&) const = default;
};

// Those between vertices of model edges that are no pieces of them, ascending.
std::vector<Side> find_chords(const Mesh& surface, const SharedWork& work) {
  std::vector<std::array<std::uint32_t, 2>> pieces;
  for (const auto& [a, b] : surface.edge_to_vert) pieces.push_back(ascending(a, b));
  std::ranges::sort(pieces);
  const auto is_on_edge = [&](std::uint32_t v) { return surface.point_to_entity[v].dim <= 1; };
  const std::size_t count = surface.tri_to_vert.size();
  const std::vector<double> blocks((count + kTrianglesOfList - 1) / kTrianglesOfList, 1.0);
  std::vector<Side> chords = joined(work.make_lists<Side>(blocks, [&](std::size_t block) {
    std::vector<Side> found;
    for (std::size_t t = block * kTrianglesOfList; t < std::min(count, (block + 1) * kTrianglesOfList); ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t a = surface.tri_to_vert[t][i], b = surface.tri_to_vert[t][(i + 1) % 3];
        if (!is_on_edge(a) || !is_on_edge(b)) continue;
        if (!std::ranges::binary_search(pieces, ascending(a, b)))
          found.push_back({ascending(a, b), static_cast<std::uint32_t>(t)});
      }
    return found;
  }));
  std::ranges::sort(chords);
  return chords;
}

}  // namespace

std::vector<TriangleIntersection> find_pinched_edges(const Mesh& surface, const SharedWork& work) {
  const std::vector<Side> chords = find_chords(surface, work);
  const auto face = [&](const Side& side) { return surface.tri_to_entity[side.triangle]; };
  std::vector<TriangleIntersection> found;
  for (auto first = chords.begin(); first != chords.end();) {
    const auto end = std::find_if(first, chords.end(), [&](const Side& side) { return side.ends != first->ends; });
    const auto other = std::find_if(first, end, [&](const Side& side) { return face(side) != face(*first); });
    if (end - first > 2 || other != end) {
      const Side& second = other != end ? *other : *(first + 1);
      const auto& [a, b] = first->ends;
      found.push_back(
          {first->triangle, second.triangle, IntersectionKind::Overlap, 0.5 * (surface.points[a] + surface.points[b])});
    }
    first = end;
  }
  std::ranges::sort(found, {}, [](const TriangleIntersection& hit) { return std::pair(hit.first, hit.second); });
  return found;
}

}  // namespace tetloom
