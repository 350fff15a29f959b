#include "adapt/kernel/passes.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

namespace tetloom::adapt {

namespace {

using tets::cube;

constexpr double kLengthGain = 0.9;
constexpr float kPoor = 0.03f;  // cubed quality: below, everything is tried again and again

constexpr std::uint32_t kAhead = 8;  // tets whose neighbours are fetched before they are asked for
constexpr int kLengthBits = 12;      // of a float: exponent and three bits of the mantissa

void count(Verdicts& verdicts, Verdict verdict) { ++verdicts[static_cast<std::size_t>(verdict)]; }

}  // namespace

// The longest edge of a tet among those longer than `least`; false where there is none.
bool Passes::longest_edge(std::uint32_t tet, float least, Edge& edge) const {
  const std::uint32_t* v = mesh_.verts(tet);
  edge = {kNone, kNone, least};
  const TetEdges edges = mesh_.edges_of(tet);
  if (edges.most() < least * least) return false;
  for (std::size_t k = 0; k < 6; ++k) {
    if (edges.upper_of(k) < edge.length * edge.length) continue;
    const auto& [i, j] = kOppositeEdges[k];
    const std::uint32_t a = std::min(v[i], v[j]), b = std::max(v[i], v[j]);
    const auto length = static_cast<float>(edges.length_of(k));
    if (length > edge.length ||
        (length == edge.length && edge.a != kNone && std::pair(a, b) < std::pair(edge.a, edge.b)))
      edge = {a, b, length};
  }
  return edge.a != kNone;
}

std::size_t Passes::split_edges(double longest) {
  std::size_t done = 0;
  const auto limit = static_cast<float>(longest);
  // Tets that are made on the way are visited as well.
  const auto size = static_cast<std::uint32_t>(mesh_.mesh.size());
  for (std::uint32_t tet = 0; tet < size; ++tet) {
    if (tet % 4096 == 0) runner_.check_cancelled();
    if (static_cast<double>(mesh_.mesh.size()) >= options_.most_tets) break;
    if (mesh_.mesh.is_dead(tet) || !mesh_.is_active(tet)) continue;
    for (int attempt = 0; attempt < 4 && !mesh_.mesh.is_dead(tet); ++attempt) {
      Edge edge{};
      if (!longest_edge(tet, limit, edge)) break;
      // Along the path of longest edges.
      std::uint32_t at = tet;
      for (int step = 0; step < 64; ++step) {
        const std::array<std::uint32_t, 2> core{edge.a, edge.b};
        if (!mesh_.collect(core, at, cavity_)) break;
        Edge longer = edge;
        for (const std::uint32_t other : cavity_.tets) {
          Edge candidate{};
          if (longest_edge(other, longer.length * 1.0001f, candidate)) longer = candidate, at = other;
        }
        if (longer.length == edge.length) break;
        edge = longer;
      }
      const Verdict verdict = split(edge.a, edge.b, at);
      count(counts_.splits, verdict);
      if (verdict != Verdict::Done) break;
      ++done;
    }
  }
  return done;
}

// The active edges shorter than `shortest`, the shortest first; lengths within an eighth count as the same, and such
// edges follow each other as their vertices do, which lie where they were last.
GrowingArray<Passes::Edge> Passes::short_edges(double shortest) const {
  GrowingArray<Edge> edges;
  for (std::uint32_t tet = 0; tet < mesh_.mesh.size(); ++tet) {
    if (mesh_.mesh.is_dead(tet) || !mesh_.is_active(tet)) continue;
    const TetEdges of_tet = mesh_.edges_of(tet);
    if (of_tet.least() >= shortest * shortest) continue;
    const std::uint32_t* v = mesh_.verts(tet);
    for (std::size_t k = 0; k < 6; ++k) {
      if (of_tet.lower_of(k) >= shortest * shortest) continue;
      const auto& [i, j] = kOppositeEdges[k];
      const double length = of_tet.length_of(k);
      if (length < shortest) edges.push_back({std::min(v[i], v[j]), std::max(v[i], v[j]), static_cast<float>(length)});
    }
  }
  // Lengths are positive, so that their bits have their order.
  const auto key = [](const Edge& edge) {
    return std::pair(std::uint64_t{std::bit_cast<std::uint32_t>(edge.length) >> (32 - kLengthBits)} << 32 | edge.a,
                     edge.b);
  };
  const auto before = [&](const Edge& p, const Edge& q) { return key(p) < key(q); };
  std::sort(edges.begin(), edges.end(), before);
  const auto same = [](const Edge& p, const Edge& q) { return p.a == q.a && p.b == q.b; };
  edges.resize(static_cast<std::size_t>(std::unique(edges.begin(), edges.end(), same) - edges.begin()));
  return edges;
}

std::size_t Passes::collapse_edges(double shortest, double longest) {
  std::size_t done = 0, asked = 0;
  for (const auto& [a, b, length] : short_edges(shortest)) {
    if (++asked % 1024 == 0) runner_.check_cancelled();
    if (mesh_.vert_to_tet[a] == kNone || mesh_.vert_to_tet[b] == kNone) continue;
    if (mesh_.length_of(a, b) >= shortest) continue;
    // What is made must not be as much too long as what goes is too short.
    const std::optional<Verdict> verdict = collapse(a, b, std::max(longest, kLengthGain / double{length}));
    if (!verdict) continue;
    count(counts_.collapses, *verdict);
    done += *verdict == Verdict::Done;
  }
  return done;
}

std::size_t Passes::swap(double limit) {
  std::size_t done = 0;
  const auto bound = static_cast<float>(cube(limit));
  const auto size = static_cast<std::uint32_t>(mesh_.mesh.size());
  for (std::uint32_t tet = 0; tet < size; ++tet) {
    if (tet % 4096 == 0) runner_.check_cancelled();
    if (tet + kAhead < size && mesh_.to_quality[tet + kAhead] < bound) mesh_.prefetch_behind(tet + kAhead);
    const float quality = mesh_.to_quality[tet];
    if (!(quality < bound) || (quality > kPoor && !mesh_.is_active(tet))) continue;
    const Verdict verdict = swap_at(tet);
    count(counts_.swaps, verdict);
    done += verdict == Verdict::Done;
  }
  return done;
}

std::size_t Passes::smooth(double limit) {
  std::size_t done = 0;
  const auto bound = static_cast<float>(cube(limit));
  std::vector<std::uint8_t> visited(mesh_.mesh.points.size(), 0);
  for (std::uint32_t tet = 0; tet < mesh_.mesh.size(); ++tet) {
    if (tet % 4096 == 0) runner_.check_cancelled();
    if (tet + kAhead < mesh_.mesh.size() && mesh_.to_quality[tet + kAhead] < bound) mesh_.prefetch_behind(tet + kAhead);
    if (!(mesh_.to_quality[tet] < bound)) continue;
    // What cannot be snapped to the model goes, and tets with it.
    for (std::uint32_t i = 0; i < 4 && !mesh_.mesh.is_dead(tet); ++i) {
      const std::uint32_t v = mesh_.verts(tet)[i];
      if (visited[v] != 0) continue;
      if (mesh_.to_quality[tet] > kPoor && (mesh_.to_state[v] & kUnsettled) == 0) continue;
      visited[v] = 1;
      const Verdict verdict = move(v);
      count(counts_.moves, verdict);
      done += verdict == Verdict::Done;
    }
  }
  return done;
}

}  // namespace tetloom::adapt
