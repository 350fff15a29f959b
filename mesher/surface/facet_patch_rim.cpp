// From a tessellation and chains of nodes to a triangulation whose rim holds the nodes.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/spatial/distances.hpp"
#include "mesher/surface/facet_patch_detail.hpp"

namespace tetloom::detail {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

/// Joins what a parametrisation takes apart at poles, and gives every fan of facets a vertex of its own.
class FacetJoiner {
 public:
  explicit FacetJoiner(const Tessellation& in) : in_(in), joined_(in.points.size()), tris_(in.tri_to_vert) {
    std::iota(joined_.begin(), joined_.end(), 0u);
    const Box3 box = box_of(in.points);
    tolerance_ = 1e-9 * box.diagonal();
  }

  void run(Triangulation& mesh, PatchVertices& vertices) {
    join_flat_facets();
    link();
    if (zip_slits()) link();
    number_fans(vertices);
    for (std::uint32_t v = 0; v < vertices.size(); ++v) mesh.add_vertex();
    for (std::uint32_t tri = 0; tri < tris_.size(); ++tri) {
      mesh.add_triangle(corner_to_vert_[3 * tri], corner_to_vert_[3 * tri + 1], corner_to_vert_[3 * tri + 2]);
    }
    for (std::uint32_t h = 0; h < twin_.size(); ++h) {
      if (twin_[h] != kNone && h < twin_[h]) mesh.link(h, twin_[h]);
    }
    add_normals(mesh, vertices);
  }

 private:
  std::uint32_t find(std::uint32_t v) const {
    while (joined_[v] != v) v = joined_[v];
    return v;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = find(a), b = find(b);
    joined_[std::max(a, b)] = std::min(a, b);
  }
  bool same_place(std::uint32_t a, std::uint32_t b) const {
    return in_.classification[a].dim == 0 && in_.classification[a] == in_.classification[b] &&
           distance(in_.points[a], in_.points[b]) <= tolerance_;
  }
  void apply_joins() {
    for (Triangle& t : tris_) t = {find(t[0]), find(t[1]), find(t[2])};
    std::erase_if(tris_, [](const Triangle& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
  }

  /// Facets that a pole flattens: two of their corners are the same point in space.
  void join_flat_facets() {
    for (const Triangle& t : tris_) {
      for (int i = 0; i < 3; ++i) {
        if (same_place(t[i], t[(i + 1) % 3])) join(t[i], t[(i + 1) % 3]);
      }
    }
    apply_joins();
  }

  /// Finds twins. Fails where more than two facets or two of contrary orientation share an edge.
  void link() {
    struct Half {
      std::uint32_t low, high, half;
      auto operator<=>(const Half&) const = default;
    };
    std::vector<Half> halves;
    for (std::uint32_t h = 0; h < 3 * tris_.size(); ++h) {
      const std::uint32_t a = origin(h), b = origin(Triangulation::next(h));
      halves.push_back({std::min(a, b), std::max(a, b), h});
    }
    std::sort(halves.begin(), halves.end());
    twin_.assign(halves.size(), kNone);
    const auto same_edge = [](const Half& a, const Half& b) { return a.low == b.low && a.high == b.high; };
    for (std::size_t i = 0; i < halves.size();) {
      std::size_t end = i + 1;
      while (end < halves.size() && same_edge(halves[i], halves[end])) ++end;
      const bool contrary = end == i + 2 && origin(halves[i].half) == origin(halves[i + 1].half);
      if (end > i + 2 || contrary) throw PatchFailure{FacetPatchVerdict::NotManifold, in_.points[halves[i].low]};
      if (end == i + 2) twin_[halves[i].half] = halves[i + 1].half, twin_[halves[i + 1].half] = halves[i].half;
      i = end;
    }
  }

  /// A rim that runs from a pole to a point and back is a slit: the copies of the pole at its two ends are one. Corners
  /// are left out, for there the rim may run up one seam and down another.
  bool zip_slits() {
    std::vector<std::array<std::uint32_t, 2>> to_pole;  // point, pole
    for (std::uint32_t h = 0; h < twin_.size(); ++h) {
      const std::uint32_t v = origin(h), pole = origin(Triangulation::next(h));
      if (twin_[h] == kNone && is_slit(v, pole)) to_pole.push_back({v, pole});
    }
    std::sort(to_pole.begin(), to_pole.end());
    bool zipped = false;
    for (std::uint32_t h = 0; h < twin_.size(); ++h) {
      const std::uint32_t pole = origin(h), v = origin(Triangulation::next(h));
      if (twin_[h] != kNone || !is_slit(v, pole)) continue;
      auto back = std::lower_bound(to_pole.begin(), to_pole.end(), std::array<std::uint32_t, 2>{v, 0});
      for (; back != to_pole.end() && (*back)[0] == v; ++back) {
        if (same_place(pole, (*back)[1])) join(pole, (*back)[1]), zipped = true;
      }
    }
    if (zipped) apply_joins();
    return zipped;
  }
  bool is_slit(std::uint32_t v, std::uint32_t pole) const {
    return in_.classification[v].dim > 0 && in_.classification[pole].dim == 0;
  }

  void number_fans(PatchVertices& vertices) {
    corner_to_vert_.assign(twin_.size(), kNone);
    for (std::uint32_t h = 0; h < twin_.size(); ++h) {
      if (corner_to_vert_[h] != kNone) continue;
      std::uint32_t start = h;
      while (twin_[start] != kNone && Triangulation::next(twin_[start]) != h) start = Triangulation::next(twin_[start]);
      for (std::uint32_t g = start;;) {
        corner_to_vert_[g] = vertices.size();
        g = twin_[Triangulation::prev(g)];
        if (g == kNone || g == start) break;
      }
      const std::uint32_t v = origin(h);
      vertices.points.push_back(in_.points[v]), vertices.uv.push_back(in_.uv[v]);
      vertices.entity.push_back(in_.classification[v]), vertices.t.push_back(in_.edge_parameter[v]);
    }
    vertices.node.assign(vertices.size(), FacetPatch::kNoNode);
  }

  /// Means of the facets' normals, weighted by angle.
  static void add_normals(const Triangulation& mesh, PatchVertices& vertices) {
    vertices.normals.assign(vertices.size(), Vec3{});
    for (std::uint32_t h = 0; h < mesh.half_edges(); ++h) {
      const Vec3 p = vertices.points[mesh.origin(h)];
      const Vec3 a = vertices.points[mesh.target(h)] - p, b = vertices.points[mesh.apex(h)] - p, n = cross(a, b);
      vertices.normals[mesh.origin(h)] += std::atan2(norm(n), dot(a, b)) * normalized(n);
    }
    for (Vec3& n : vertices.normals) n = normalized(n);
    constexpr double kSharp = 0.4;  // cosine
    vertices.sharp.assign(vertices.size(), false);
    for (std::uint32_t h = 0; h < mesh.half_edges(); ++h) {
      const Vec3 p = vertices.points[mesh.origin(h)];
      const Vec3 n = normalized(cross(vertices.points[mesh.target(h)] - p, vertices.points[mesh.apex(h)] - p));
      if (dot(n, vertices.normals[mesh.origin(h)]) < kSharp) vertices.sharp[mesh.origin(h)] = true;
    }
  }

  std::uint32_t origin(std::uint32_t h) const { return tris_[h / 3][h % 3]; }

  const Tessellation& in_;
  std::vector<std::uint32_t> joined_;
  std::vector<Triangle> tris_;
  std::vector<std::uint32_t> twin_, corner_to_vert_;
  double tolerance_ = 0;
};

/// A chain in the direction of its use.
class DirectedChain {
 public:
  explicit DirectedChain(const BoundaryChain& chain) : chain_(chain) {}
  std::size_t size() const { return chain_.nodes.size(); }
  const BoundaryNode& operator[](std::size_t i) const {
    return chain_.nodes[chain_.use.forward ? i : chain_.nodes.size() - 1 - i];
  }
  ModelEntity first() const { return chain_.vertices[chain_.use.forward ? 0 : 1]; }
  ModelEntity last() const { return chain_.vertices[chain_.use.forward ? 1 : 0]; }

 private:
  const BoundaryChain& chain_;
};

class RunMatcher {
 public:
  RunMatcher(const Triangulation& mesh, const PatchVertices& vertices, std::span<const BoundaryChain> chains)
      : mesh_(mesh), vertices_(vertices) {
    for (const BoundaryChain& chain : chains) {
      if (!is_degenerate(chain)) chains_.push_back(&chain);
    }
  }

  std::vector<RimRun> match() {
    trace();
    // Runs with points on their edge know it; the others take what is left.
    for (RimRun& run : runs_) {
      if (run.verts.size() > 2) take_chain(run);
    }
    for (RimRun& run : runs_) {
      if (run.verts.size() == 2) take_chain(run);
    }
    for (const BoundaryChain* chain : chains_) {
      if (chain) throw PatchFailure{FacetPatchVerdict::ChainsDisagree, chain->nodes[chain->nodes.size() / 2].point};
    }
    return std::move(runs_);
  }

 private:
  static bool is_degenerate(const BoundaryChain& chain) {
    return std::all_of(chain.nodes.begin(), chain.nodes.end(),
                       [&](const BoundaryNode& n) { return n.point == chain.nodes[0].point; });
  }

  void trace() {
    std::vector<std::uint32_t> after(vertices_.size(), kNone);
    for (std::uint32_t h = 0; h < mesh_.half_edges(); ++h) {
      if (mesh_.twin(h) != kNone) continue;
      after[mesh_.origin(h)] = mesh_.target(h);
      if (vertices_.entity[mesh_.origin(h)].dim > 1) {
        throw PatchFailure{FacetPatchVerdict::NotManifold, vertices_.points[mesh_.origin(h)]};
      }
    }
    std::size_t traced = 0;
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) {
      if (after[v] == kNone || vertices_.entity[v].dim != 0) continue;
      RimRun run{{v, after[v]}};
      while (vertices_.entity[run.verts.back()].dim != 0) run.verts.push_back(after[run.verts.back()]);
      traced += run.verts.size() - 1;
      runs_.push_back(std::move(run));
    }
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) traced -= after[v] != kNone;
    if (traced != 0) throw PatchFailure{FacetPatchVerdict::ChainsDisagree, any_rim_point(after)};
  }

  Vec3 any_rim_point(const std::vector<std::uint32_t>& after) const {
    const auto found = std::find_if(after.begin(), after.end(), [](std::uint32_t v) { return v != kNone; });
    return vertices_.points[static_cast<std::size_t>(found - after.begin())];
  }

  /// How badly a chain fits a run: infinite when it is another edge or runs the other way.
  double misfit(const RimRun& run, const BoundaryChain& chain) const {
    const auto& verts = run.verts;
    const DirectedChain nodes(chain);
    if (nodes.first() != vertices_.entity[verts.front()] || nodes.last() != vertices_.entity[verts.back()])
      return HUGE_VAL;
    for (std::size_t i = 1; i + 1 < verts.size(); ++i) {
      if (vertices_.entity[verts[i]] != ModelEntity(chain.use.edge)) return HUGE_VAL;
    }
    // The two uses of a seam differ in direction alone.
    const double rise = verts.size() > 3 ? vertices_.t[verts[verts.size() - 2]] - vertices_.t[verts[1]] : 0;
    if (rise != 0) return (rise > 0) == chain.use.forward ? 0 : HUGE_VAL;
    double worst = 0;
    for (const BoundaryNode& node : chain.nodes) {
      double nearest = HUGE_VAL;
      for (std::size_t i = 0; i + 1 < verts.size(); ++i) {
        nearest = std::min(nearest,
                           distance_to_segment(node.point, vertices_.points[verts[i]], vertices_.points[verts[i + 1]]));
      }
      worst = std::max(worst, nearest);
    }
    return worst;
  }

  void take_chain(RimRun& run) {
    const BoundaryChain** best = nullptr;
    double best_misfit = HUGE_VAL;
    for (const BoundaryChain*& chain : chains_) {
      const double value = chain ? misfit(run, *chain) : HUGE_VAL;
      if (value < best_misfit) best = &chain, best_misfit = value;
    }
    if (!best) throw PatchFailure{FacetPatchVerdict::ChainsDisagree, vertices_.points[run.verts[run.verts.size() / 2]]};
    run.chain = std::exchange(*best, nullptr);
  }

  const Triangulation& mesh_;
  const PatchVertices& vertices_;
  std::vector<const BoundaryChain*> chains_;
  std::vector<RimRun> runs_;
};

class NodeInserter {
 public:
  NodeInserter(Triangulation& mesh, PatchVertices& vertices, RimRun& run)
      : mesh_(mesh), vertices_(vertices), run_(run), nodes_(*run.chain) {}

  void insert() {
    set_parameters();
    place(0, 0);
    place(run_.verts.size() - 1, nodes_.size() - 1);
    std::vector<std::uint32_t> verts{run_.verts[0]};
    std::size_t next = 1;
    for (std::size_t i = 1; i < nodes_.size() - 1; ++i) {
      while (vert_share_[next] < node_share_[i]) verts.push_back(run_.verts[next++]);
      if (!place_at_near_point(i, next, verts)) verts.push_back(split_before(i, next, verts.back()));
    }
    verts.insert(verts.end(), run_.verts.begin() + static_cast<std::ptrdiff_t>(next), run_.verts.end());
    run_.verts = std::move(verts);
  }

 private:
  /// Shares 0 … 1 along the edge of points and nodes: by t where the points' t make sense, else by length.
  void set_parameters() {
    const double begin = nodes_[0].t, length = nodes_[nodes_.size() - 1].t - begin;
    vert_share_.assign(1, 0), node_share_.clear();
    for (std::size_t i = 1; i + 1 < run_.verts.size(); ++i) {
      vert_share_.push_back((vertices_.t[run_.verts[i]] - begin) / length);
    }
    vert_share_.push_back(1);
    for (std::size_t i = 0; i < nodes_.size(); ++i) node_share_.push_back((nodes_[i].t - begin) / length);
    const auto ascends = [](const std::vector<double>& shares) {
      return std::adjacent_find(shares.begin(), shares.end(), [](double a, double b) { return !(a < b); }) ==
             shares.end();
    };
    if (ascends(vert_share_) && ascends(node_share_)) return;
    measure(vert_share_, [&](std::size_t i) { return vertices_.points[run_.verts[i]]; });
    measure(node_share_, [&](std::size_t i) { return nodes_[i].point; });
  }

  template <class Point>
  static void measure(std::vector<double>& shares, Point&& point) {
    shares[0] = 0;
    for (std::size_t i = 1; i < shares.size(); ++i) shares[i] = shares[i - 1] + distance(point(i), point(i - 1));
    for (double& share : shares) share /= shares.back();
    shares.back() = 1;
  }

  void place(std::size_t position, std::size_t i) {
    const std::uint32_t v = run_.verts[position];
    vertices_.node[v] = nodes_[i].node, vertices_.points[v] = nodes_[i].point, vertices_.t[v] = nodes_[i].t;
  }

  /// Uses the run's point after or before the node when it is near, so that no sliver comes of it.
  bool place_at_near_point(std::size_t i, std::size_t& next, std::vector<std::uint32_t>& verts) {
    constexpr double kNear = 0.02;
    const double gap = vert_share_[next] - vert_share_[next - 1];
    if (next + 1 < run_.verts.size() && vert_share_[next] - node_share_[i] <= kNear * gap) {
      place(next, i);
      verts.push_back(run_.verts[next++]);
      return true;
    }
    const bool free_before =
        next > 1 && verts.back() == run_.verts[next - 1] && vertices_.node[verts.back()] == FacetPatch::kNoNode;
    if (!free_before || node_share_[i] - vert_share_[next - 1] > kNear * gap) return false;
    place(next - 1, i);
    return true;
  }

  std::uint32_t split_before(std::size_t i, std::size_t next, std::uint32_t before) {
    const std::uint32_t after = run_.verts[next], vertex = mesh_.add_vertex();
    const double gap = vert_share_[next] - vert_share_[next - 1];
    const double s = std::clamp((node_share_[i] - vert_share_[next - 1]) / gap, 0.0, 1.0);
    const Vec3 normal = normalized((1 - s) * vertices_.normals[run_.verts[next - 1]] + s * vertices_.normals[after]);
    vertices_.add_copy(s < 0.5 ? run_.verts[next - 1] : after, nodes_[i].point, normal);
    vertices_.entity[vertex] = run_.chain->use.edge;
    vertices_.node[vertex] = nodes_[i].node, vertices_.t[vertex] = nodes_[i].t;
    mesh_.split_edge(mesh_.find_half_edge(before, after), vertex);
    return vertex;
  }

  Triangulation& mesh_;
  PatchVertices& vertices_;
  RimRun& run_;
  DirectedChain nodes_;
  std::vector<double> vert_share_, node_share_;
};

}  // namespace

void join_facets(const Tessellation& tessellation, Triangulation& mesh, PatchVertices& vertices) {
  FacetJoiner(tessellation).run(mesh, vertices);
}

std::vector<RimRun> match_runs(const Triangulation& mesh, const PatchVertices& vertices,
                               std::span<const BoundaryChain> chains) {
  return RunMatcher(mesh, vertices, chains).match();
}

void insert_nodes(Triangulation& mesh, PatchVertices& vertices, RimRun& run) {
  NodeInserter(mesh, vertices, run).insert();
}

}  // namespace tetloom::detail
