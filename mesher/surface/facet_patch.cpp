#include "mesher/surface/facet_patch.hpp"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "mesher/surface/facet_patch_detail.hpp"

namespace tetloom {
namespace {

using detail::PatchFailure, detail::PatchVertices, detail::Reach, detail::RimRun;

/// Removes the points of the rim that are no nodes.
class RimCleaner {
 public:
  RimCleaner(Triangulation& mesh, PatchVertices& vertices, const std::vector<RimRun>& runs,
             const detail::PatchCallbacks& callbacks)
      : mesh_(mesh),
        vertices_(vertices),
        remover_(mesh, vertices),
        callbacks_(callbacks),
        on_rim_(vertices.size(), false),
        touched_(vertices.size(), 0) {
    for (const RimRun& run : runs) {
      for (const std::uint32_t v : run.verts) {
        on_rim_[v] = true;
        if (vertices.node[v] == FacetPatch::kNoNode) pending_.push_back(v);
      }
    }
  }

  void clean() {
    flip_near_rim();
    // Strict first: a turn of 60°, and nothing inside is given up. Then points beyond the new rim, then the rest.
    sweep_all({{0.5, Reach::Ball, Sacrifice::Nothing},
               {0.5, Reach::Ball, Sacrifice::Beyond},
               {0.5, Reach::Near, Sacrifice::Beyond}});
    if (callbacks_.size_at) halve_around_pending();
    sweep_all({{0.2, Reach::Near, Sacrifice::Beyond},
               {0.5, Reach::Far, Sacrifice::Any},
               {0.2, Reach::Far, Sacrifice::Any},
               {1e-3, Reach::Far, Sacrifice::Any}});
    force_pending();
    repair();
  }

  /// The triangles that face away from the surface; `place` is moved to one.
  std::size_t count_inverted(Vec3& place) const {
    std::size_t count = 0;
    for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri) {
      if (!mesh_.alive(tri) || !faces_away(tri)) continue;
      if (count++ == 0) place = vertices_.points[mesh_.origin(3 * tri)];
    }
    return count;
  }

 private:
  enum class Sacrifice { Nothing, Beyond, Any };
  struct Stage {
    double level;
    Reach reach;
    Sacrifice sacrifice;
  };

  void sweep_all(std::initializer_list<Stage> stages) {
    for (const Stage& stage : stages) {
      while (!pending_.empty() && sweep(stage)) {}
    }
  }

  void halve_around_pending() {
    detail::halve_long_edges(mesh_, vertices_, pending_, callbacks_);
    on_rim_.resize(vertices_.size(), false);
    touched_.resize(vertices_.size(), 0);
    sweep_all({{0.5, Reach::Ball, Sacrifice::Nothing},
               {0.5, Reach::Ball, Sacrifice::Beyond},
               {0.5, Reach::Near, Sacrifice::Beyond}});
  }

  /// Evens out the fans that inserted nodes leave around far corners of coarse facets.
  void flip_near_rim() {
    constexpr int kRounds = 30;
    constexpr double kLevel = 0.7, kFlat = 0.1;
    std::vector<bool> active(vertices_.size(), false);
    for (std::uint32_t v = 0; v < vertices_.size(); ++v) active[v] = on_rim_[v];
    for (int round = 0; round < kRounds; ++round) {
      check_going();
      std::vector<bool> changed(vertices_.size(), false);
      std::size_t flips = 0;
      for (std::uint32_t h = 0; h < mesh_.half_edges(); ++h) {
        const std::uint32_t a = mesh_.origin(h), b = mesh_.target(h);
        if (h > mesh_.twin(h) || !(active[a] || active[b])) continue;
        const std::uint32_t c = mesh_.apex(h), d = mesh_.twin(h) == kNone ? c : mesh_.apex(mesh_.twin(h));
        if (!remover_.improve(h, kLevel, kFlat * size_near(a, b))) continue;
        changed[a] = changed[b] = changed[c] = changed[d] = true;
        ++flips;
      }
      if (flips == 0) break;
      active = std::move(changed);
    }
  }

  double size_near(std::uint32_t a, std::uint32_t b) const {
    return callbacks_.size_at ? callbacks_.size_at(vertices_.points[a])
                              : distance(vertices_.points[a], vertices_.points[b]);
  }

  void check_going() const {
    if (callbacks_.keep_going && !callbacks_.keep_going()) throw PatchFailure{FacetPatchVerdict::Cancelled, {}};
  }

  /// Tries every pending point once, but no two neighbours, so that the rim thins out evenly. False without progress.
  bool sweep(const Stage& stage) {
    ++round_;
    std::size_t tried = 0, kept = 0, removed = 0;
    for (const std::uint32_t v : pending_) {
      if (tried++ % 256 == 0) check_going();
      const bool gone = touched_[v] != round_ && remove(v, stage);
      removed += gone;
      if (!gone) pending_[kept++] = v;
    }
    pending_.resize(kept);
    return removed > 0;
  }

  bool remove(std::uint32_t v, const Stage& stage) {
    const detail::PatchCavity& ball = remover_.collect_ball(v);
    const std::uint32_t after = ball.ring.front(), before = ball.ring.back();
    bool gone = remover_.remove(v, stage.level, stage.reach);
    while (!gone && stage.sacrifice != Sacrifice::Nothing && give_up_one(v, stage))
      gone = remover_.remove(v, stage.level, stage.reach);
    if (gone) touched_[after] = touched_[before] = round_;
    return gone;
  }

  struct Obstacle {
    double height;  ///< above the new rim, towards the inside
    std::uint32_t vertex;
    auto operator<=>(const Obstacle&) const = default;
  };

  /// Removes one point inside that is joined to v: those that lie furthest beyond the new rim first.
  bool give_up_one(std::uint32_t v, const Stage& stage) {
    const std::vector<std::uint32_t> ring = remover_.collect_ball(v).ring;
    const std::uint32_t from = ring.back(), to = ring.front();
    const bool all = stage.sacrifice == Sacrifice::Any || remover_.connected(from, to);
    const Vec3 inwards = normalized(cross(vertices_.normals[v], vertices_.points[to] - vertices_.points[from]));
    std::vector<Obstacle> obstacles;
    for (const std::uint32_t u : ring) {
      if (on_rim_[u]) continue;
      if (all || remover_.score(from, to, u, stage.level) < 0) {
        obstacles.push_back({dot(inwards, vertices_.points[u] - vertices_.points[from]), u});
      }
    }
    std::sort(obstacles.begin(), obstacles.end());
    return std::any_of(obstacles.begin(), obstacles.end(), [&](const Obstacle& obstacle) {
      return remover_.remove(obstacle.vertex, stage.level, stage.reach);
    });
  }

  /// Facets beside the rim that the nodes' places have turned over are reshaped, if need be without a point inside.
  void repair() {
    constexpr int kRounds = 3;
    std::size_t bad = 1;
    for (int round = 0; round < kRounds && bad > 0; ++round) {
      bad = 0;
      for (std::uint32_t tri = 0; tri < mesh_.slots(); ++tri) {
        if (!mesh_.alive(tri) || is_good(tri)) continue;
        ++bad;
        check_going();
        for (const double level : {0.5, 0.2, 1e-3}) {
          if (remover_.reshape(tri, level, Reach::Far) || give_up_corner(tri, level)) break;
        }
      }
    }
  }

  /// What no stage could remove goes whatever the triangles then look like.
  void force_pending() {
    for (const std::uint32_t v : pending_) {
      check_going();
      if (!remover_.force(v)) throw PatchFailure{FacetPatchVerdict::Stuck, vertices_.points[v]};
    }
    pending_.clear();
    on_rim_.resize(vertices_.size(), false);
  }

  bool is_good(std::uint32_t tri) const {
    const auto [a, b, c] = mesh_.triangle(tri);
    return remover_.score(a, b, c, 1e-3) > 0;
  }
  bool faces_away(std::uint32_t tri) const {
    const auto [a, b, c] = mesh_.triangle(tri);
    const Vec3 n = cross(vertices_.points[b] - vertices_.points[a], vertices_.points[c] - vertices_.points[a]);
    return dot(n, vertices_.normals[a] + vertices_.normals[b] + vertices_.normals[c]) < -1e-9 * norm(n);
  }
  bool give_up_corner(std::uint32_t tri, double level) {
    const auto corners = mesh_.triangle(tri);
    return std::any_of(corners.begin(), corners.end(),
                       [&](std::uint32_t v) { return !on_rim_[v] && remover_.remove(v, level, Reach::Near); });
  }

  Triangulation& mesh_;
  PatchVertices& vertices_;
  detail::PatchVertexRemover remover_;
  const detail::PatchCallbacks& callbacks_;
  std::vector<bool> on_rim_;
  std::vector<std::uint32_t> touched_, pending_;
  std::uint32_t round_ = 0;
};

FacetPatch collect_patch(const Triangulation& mesh, const PatchVertices& vertices) {
  FacetPatch patch;
  std::vector<std::uint32_t> number(vertices.size(), kNone);
  for (std::uint32_t tri = 0; tri < mesh.slots(); ++tri) {
    if (mesh.alive(tri)) patch.tri_to_vert.push_back(mesh.triangle(tri));
  }
  for (const auto& t : patch.tri_to_vert) {
    for (const std::uint32_t v : t) number[v] = 0;
  }
  for (std::uint32_t v = 0; v < vertices.size(); ++v) {
    if (number[v] == kNone) continue;
    number[v] = static_cast<std::uint32_t>(patch.points.size());
    patch.points.push_back(vertices.points[v]), patch.uv.push_back(vertices.uv[v]);
    patch.normals.push_back(vertices.sharp[v] ? Vec3{} : vertices.normals[v]);
    patch.node.push_back(vertices.node[v]);
  }
  for (auto& t : patch.tri_to_vert) t = {number[t[0]], number[t[1]], number[t[2]]};
  return patch;
}

}  // namespace

FacetPatch make_facet_patch(const Tessellation& tessellation, std::span<const BoundaryChain> chains,
                            const std::function<bool()>& keep_going,
                            const std::function<double(const Vec3&)>& size_at) {
  try {
    Triangulation mesh;
    PatchVertices vertices;
    detail::join_facets(tessellation, mesh, vertices);
    std::vector<RimRun> runs = detail::match_runs(mesh, vertices, chains);
    for (RimRun& run : runs) detail::insert_nodes(mesh, vertices, run);
    const detail::PatchCallbacks callbacks{keep_going, size_at};
    RimCleaner cleaner(mesh, vertices, runs, callbacks);
    cleaner.clean();
    Vec3 place;
    const std::size_t inverted = cleaner.count_inverted(place);
    detail::halve_repeated_edges(mesh, vertices);
    FacetPatch patch = collect_patch(mesh, vertices);
    patch.inverted = inverted, patch.trouble = place;
    return patch;
  } catch (const PatchFailure& failure) {
    FacetPatch refused;
    refused.verdict = failure.verdict, refused.trouble = failure.point;
    return refused;
  }
}

}  // namespace tetloom
