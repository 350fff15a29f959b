// Points in the middle of edges inside a patch of facets: the surface stays where it is.
#include <algorithm>
#include <queue>

#include "mesher/surface/facet_patch_detail.hpp"

namespace tetloom::detail {
namespace {

class LongEdgeHalver {
 public:
  LongEdgeHalver(Triangulation& mesh, PatchVertices& vertices, const std::function<double(const Vec3&)>& size_at)
      : mesh_(mesh), vertices_(vertices), size_at_(size_at) {}

  void run(std::span<const std::uint32_t> centers, const std::function<bool()>& keep_going) {
    constexpr std::size_t kAskEvery = 1024;
    center_.assign(vertices_.size(), kNone);
    for (const std::uint32_t v : centers) offer_around(v);
    for (std::size_t step = 0; !queue_.empty(); ++step) {
      if (step % kAskEvery == 0 && keep_going && !keep_going()) {
        throw PatchFailure{FacetPatchVerdict::Cancelled, {}};
      }
      const Entry entry = queue_.top();
      queue_.pop();
      const std::uint32_t half = mesh_.find_half_edge(entry.a, entry.b);
      if (half == kNone) continue;
      const std::uint32_t longest = find_longer(half);
      if (longest == half) {
        halve(half);
      } else if (mesh_.twin(longest) == kNone || kept_.contains(ends_of(longest))) {
        kept_.insert(ends_of(half));
      } else {
        push(longest), queue_.push(entry);
      }
    }
  }

 private:
  struct Entry {
    double length;  // in units of the size
    std::uint32_t a, b;
    auto operator<=>(const Entry&) const = default;
  };

  void offer_around(std::uint32_t center) {
    take_nearer(center, center);
    mesh_.for_each_outgoing(center, [&](std::uint32_t h) {
      take_nearer(mesh_.target(h), center), take_nearer(mesh_.apex(h), center);
      for (const std::uint32_t side : {h, Triangulation::next(h), Triangulation::prev(h)}) offer(side);
      return true;
    });
  }

  void take_nearer(std::uint32_t v, std::uint32_t center) {
    const auto away = [&](std::uint32_t from) { return distance(vertices_.points[v], vertices_.points[from]); };
    if (center_[v] == kNone || away(center) < away(center_[v])) center_[v] = center;
  }

  void offer(std::uint32_t half) {
    constexpr double kLongest = 1.42;
    if (mesh_.twin(half) == kNone) return;
    if (center_[mesh_.origin(half)] == kNone || center_[mesh_.target(half)] == kNone) return;
    if (length(half) > kLongest) push(half);
  }

  void push(std::uint32_t half) {
    const auto [a, b] = ends_of(half);
    queue_.push({length(half), a, b});
  }

  std::array<std::uint32_t, 2> ends_of(std::uint32_t half) const {
    const std::uint32_t a = mesh_.origin(half), b = mesh_.target(half);
    return {std::min(a, b), std::max(a, b)};
  }

  // Asked for once per vertex. Far from the centers, edges may be longer than the size.
  double size_of(std::uint32_t vertex) const {
    constexpr double kGrading = 0.5;
    if (vertex >= sizes_.size()) sizes_.resize(vertices_.size(), 0);
    if (sizes_[vertex] == 0) {
      const Vec3& x = vertices_.points[vertex];
      const double away = center_[vertex] == kNone ? 0 : distance(x, vertices_.points[center_[vertex]]);
      sizes_[vertex] = std::max(size_at_(x), kGrading * away);
    }
    return sizes_[vertex];
  }

  double length(std::uint32_t half) const {
    const Vec3 &a = vertices_.points[mesh_.origin(half)], &b = vertices_.points[mesh_.target(half)];
    return 2 * distance(a, b) / (size_of(mesh_.origin(half)) + size_of(mesh_.target(half)));
  }

  /// The longest side of the two triangles at an edge; the edge itself where none is longer. Where a longer one cannot
  /// be halved, as one of the rim, the others are kept too: they cannot all become short, however often they are halved
  /// (Rivara 1984).
  std::uint32_t find_longer(std::uint32_t half) const {
    const std::uint32_t twin = mesh_.twin(half);
    std::uint32_t longest = half;
    double most = length(half);
    for (const std::uint32_t side :
         {Triangulation::next(half), Triangulation::prev(half), Triangulation::next(twin), Triangulation::prev(twin)}) {
      if (const double of_side = length(side); of_side > most) longest = side, most = of_side;
    }
    return longest;
  }

  void halve(std::uint32_t half) {
    const std::uint32_t a = mesh_.origin(half), b = mesh_.target(half);
    const std::uint32_t vertex = halve_edge(mesh_, vertices_, half);
    center_.push_back(center_[a]);
    if (center_[b] != kNone) take_nearer(vertex, center_[b]);
    mesh_.for_each_outgoing(vertex, [&](std::uint32_t h) { return offer(h), true; });
  }

  Triangulation& mesh_;
  PatchVertices& vertices_;
  const std::function<double(const Vec3&)>& size_at_;
  // The nearest center, for the corners of the triangles at the centers and what was added between them.
  std::vector<std::uint32_t> center_;
  std::set<std::array<std::uint32_t, 2>> kept_;  // edges beside longer ones that cannot be halved
  std::priority_queue<Entry> queue_;
  mutable std::vector<double> sizes_;  // per vertex; 0: not asked for yet
};

/// An edge between two nodes, or a side of one.
struct NodeEdge {
  std::uint32_t low, high;  ///< nodes
  bool inside;              ///< rims first: they stay
  std::uint32_t a, b;       ///< vertices
  auto operator<=>(const NodeEdge&) const = default;
};

std::vector<NodeEdge> list_node_edges(const Triangulation& mesh, const PatchVertices& vertices) {
  std::vector<NodeEdge> edges;
  for (std::uint32_t h = 0; h < mesh.half_edges(); ++h) {
    if (!mesh.alive(h / 3) || (mesh.twin(h) != kNone && h > mesh.twin(h))) continue;
    const std::uint32_t a = vertices.node[mesh.origin(h)], b = vertices.node[mesh.target(h)];
    if (a == FacetPatch::kNoNode || b == FacetPatch::kNoNode) continue;
    edges.push_back({std::min(a, b), std::max(a, b), mesh.twin(h) != kNone, mesh.origin(h), mesh.target(h)});
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

std::uint32_t halve_edge(Triangulation& mesh, PatchVertices& vertices, std::uint32_t half) {
  const std::uint32_t a = mesh.origin(half), b = mesh.target(half), vertex = mesh.add_vertex();
  Vec3 normal = normalized(vertices.normals[a] + vertices.normals[b]);
  if (normal == Vec3{}) normal = vertices.normals[a];
  vertices.add_copy(a, 0.5 * (vertices.points[a] + vertices.points[b]), normal);
  vertices.entity[vertex] = ModelFaceId(0);  // whichever: the rim has been traced
  mesh.split_edge(half, vertex);
  return vertex;
}

void halve_long_edges(Triangulation& mesh, PatchVertices& vertices, std::span<const std::uint32_t> centers,
                      const PatchCallbacks& callbacks) {
  LongEdgeHalver(mesh, vertices, callbacks.size_at).run(centers, callbacks.keep_going);
}

void halve_repeated_edges(Triangulation& mesh, PatchVertices& vertices) {
  const std::vector<NodeEdge> edges = list_node_edges(mesh, vertices);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const NodeEdge& edge = edges[i];
    const bool repeated = i > 0 && edges[i - 1].low == edge.low && edges[i - 1].high == edge.high;
    const bool loop = edge.low == edge.high;
    if (!edge.inside && loop) throw PatchFailure{FacetPatchVerdict::Stuck, vertices.points[edge.a]};
    if (edge.inside && (repeated || loop)) halve_edge(mesh, vertices, mesh.find_half_edge(edge.a, edge.b));
  }
}

}  // namespace tetloom::detail
