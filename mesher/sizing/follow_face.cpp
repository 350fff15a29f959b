#include "mesher/sizing/follow_face.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "tetloom/ids.hpp"

namespace tetloom {
namespace {

constexpr int kMostCuts = 24;
constexpr std::size_t kMostFacets = 4'000'000;

using Facet = std::array<std::uint32_t, 3>;

/// One use of an edge by a facet, which has it opposite to the corner `at`.
struct EdgeUseOfFacet {
  std::uint32_t low, high;
  std::uint32_t facet, at;
  friend bool operator<(const EdgeUseOfFacet& a, const EdgeUseOfFacet& b) {
    return std::pair{a.low, a.high} < std::pair{b.low, b.high};
  }
  bool is_edge_of(const EdgeUseOfFacet& other) const { return low == other.low && high == other.high; }
};

std::vector<EdgeUseOfFacet> sorted_edges(const std::vector<Facet>& facets) {
  std::vector<EdgeUseOfFacet> uses;
  uses.reserve(3 * facets.size());
  for (std::uint32_t f = 0; f < facets.size(); ++f)
    for (std::uint32_t i = 0; i < 3; ++i) {
      const std::uint32_t a = facets[f][(i + 1) % 3], b = facets[f][(i + 2) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), f, i});
    }
  std::stable_sort(uses.begin(), uses.end());
  return uses;
}

/// Per facet and corner the point in the middle of the opposite edge, or kNone where that stays.
using Halves = std::vector<Facet>;

/// Adds points in the middle of edges inside of the face that are farther from it than `chord`.
Halves halve_edges(FaceGeometry& face, double chord, Tessellation& facets) {
  const std::vector<EdgeUseOfFacet> uses = sorted_edges(facets.tri_to_vert);
  Halves halves(facets.tri_to_vert.size(), {kNone, kNone, kNone});
  for (std::size_t i = 0; i + 1 < uses.size(); ++i) {
    if (!uses[i].is_edge_of(uses[i + 1])) continue;
    const std::uint32_t a = uses[i].low, b = uses[i].high;
    const Vec2 uv = 0.5 * (facets.uv[a] + facets.uv[b]);
    const Vec3 point = face.evaluate(uv);
    if (!is_finite(point) || distance(point, 0.5 * (facets.points[a] + facets.points[b])) <= chord) continue;
    const auto middle = static_cast<std::uint32_t>(facets.points.size());
    facets.points.push_back(point);
    facets.uv.push_back(uv);
    for (std::size_t k = i; k < uses.size() && uses[k].is_edge_of(uses[i]); ++k)
      halves[uses[k].facet][uses[k].at] = middle;
  }
  return halves;
}

/// The pieces of a facet some of whose edges have been halved.
void cut(const Facet& facet, const Facet& half, std::vector<Facet>& out) {
  const auto count = std::ranges::count_if(half, [](std::uint32_t v) { return v != kNone; });
  if (count == 0) return out.push_back(facet);
  std::size_t first = 0;  // the corner opposite to the only edge that is, or is not, halved
  while ((half[first] != kNone) != (count == 1) && count != 3) ++first;
  const std::uint32_t a = facet[first], b = facet[(first + 1) % 3], c = facet[(first + 2) % 3];
  const std::uint32_t bc = half[first], ca = half[(first + 1) % 3], ab = half[(first + 2) % 3];
  if (count == 1) {
    out.insert(out.end(), {{a, b, bc}, {a, bc, c}});
  } else if (count == 2) {
    out.insert(out.end(), {{a, ab, ca}, {ab, b, c}, {ab, c, ca}});
  } else {
    out.insert(out.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
}

}  // namespace

void follow_face(FaceGeometry& face, ModelFaceId id, double chord, Tessellation& facets) {
  for (int round = 0; round < kMostCuts && facets.tri_to_vert.size() < kMostFacets; ++round) {
    const std::size_t before = facets.points.size();
    const Halves halves = halve_edges(face, chord, facets);
    if (facets.points.size() == before) return;
    std::vector<Facet> finer;
    for (std::size_t f = 0; f < halves.size(); ++f) cut(facets.tri_to_vert[f], halves[f], finer);
    facets.tri_to_vert = std::move(finer);
    facets.classification.resize(facets.points.size(), id);
    facets.edge_parameter.resize(facets.points.size(), 0);
  }
}

}  // namespace tetloom
