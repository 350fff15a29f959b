#include "mesher/tets/recovery.hpp"

#include <algorithm>

#include "core/base/disjoint_sets.hpp"
#include "core/tets/find_triangles.hpp"
#include "mesher/tets/recoverer.hpp"
#include "mesher/tets/steiner.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::tets {

namespace {

using EdgeVerts = std::array<std::uint32_t, 2>;
constexpr int kRecoveryRounds = 2;
constexpr std::uint64_t kStepsBeforeAsking = 5'000'000;  // whether it is in vain: .2 s
constexpr std::uint64_t kThorough = 10;                  // times as long a search before a point is put
// For new points: more than both says that the input is not sound.
constexpr std::size_t kMissingOfAnySurface = 1000, kLeastPerMissing = 50;

struct MissingEdge {
  EdgeVerts verts;
  std::vector<std::uint32_t> triangles;
  bool there = false;
};

class Recovery {
 public:
  Recovery(TetMesh& mesh, std::span<const TriangleVerts> triangles, const TriangleIndex& index,
           const RecoverOptions& options, const TaskRunner& runner)
      : triangles_(triangles),
        index_(index),
        options_(options),
        runner_(runner),
        local_(mesh),
        recoverer_(local_, kept_, options_, report_, runner),
        thorough_options_(options),
        thorough_recoverer_(local_, kept_, thorough_options_, report_, runner),
        given_points_(static_cast<std::uint32_t>(mesh.points.size())) {}

  RecoveryReport run(std::span<const std::uint32_t> missing) {
    report_.missing_triangles = missing.size();
    for (const std::uint32_t t : missing) {
      if (is_sound(t)) missing_.push_back(t);
    }
    collect_edges();
    recoverer_.grant_steps(options_.steps_in_all);
    for (int round = 0; round < kRecoveryRounds && !missing_.empty(); ++round) {
      const std::size_t before = missing_.size();
      recover_edges();
      recover_triangles();
      if (missing_.size() == before) break;
    }
    const bool are_too_many = missing_.size() > std::max(kMissingOfAnySurface, triangles_.size() / kLeastPerMissing);
    const bool is_hopeless = are_too_many || is_in_vain();
    if (options_.allow_new_points && !missing_.empty() && !is_hopeless) use_new_points();
    for (const std::uint32_t t : missing_) explain(t);
    std::sort(report_.unrecovered.begin(), report_.unrecovered.end(),
              [](const auto& a, const auto& b) { return a.triangle < b.triangle; });
    local_.tidy(given_points_);
    report_.new_points = local_.mesh().points.size() - given_points_;
    return std::move(report_);
  }

 private:
  bool is_in_vain() {
    const std::uint64_t taken = options_.steps_in_all - recoverer_.steps_left();
    if (!asked_ && options_.is_in_vain && taken > kStepsBeforeAsking) {
      asked_ = true;
      in_vain_ = options_.is_in_vain();
    }
    return in_vain_;
  }

  bool is_sound(std::uint32_t t) {
    const TriangleVerts& v = triangles_[t];
    const bool known = std::all_of(v.begin(), v.end(), [&](std::uint32_t x) { return x < given_points_; });
    if (!known || collinear(local_.point(v[0]), local_.point(v[1]), local_.point(v[2]))) {
      report_.unrecovered.push_back({t, RecoveryFault::Degenerate, known ? local_.point(v[0]) : Vec3{}, kNone});
      return false;
    }
    const std::uint32_t first = index_.find(sorted(v))->triangle;
    if (first == t) return true;
    report_.unrecovered.push_back({t, RecoveryFault::Duplicate, local_.point(v[0]), first});
    return false;
  }

  void collect_edges() {
    std::vector<std::pair<EdgeVerts, std::uint32_t>> all;
    for (const std::uint32_t t : missing_) {
      const TriangleVerts v = sorted(triangles_[t]).verts;
      all.insert(all.end(), {{{v[0], v[1]}, t}, {{v[0], v[2]}, t}, {{v[1], v[2]}, t}});
    }
    std::sort(all.begin(), all.end());
    for (const auto& [verts, t] : all) {
      if (edges_.empty() || edges_.back().verts != verts)
        edges_.push_back({verts, {}, local_.has_edge(verts[0], verts[1])});
      edges_.back().triangles.push_back(t);
      kept_.insert(verts[0], verts[1]);
    }
    for (const MissingEdge& edge : edges_) report_.missing_edges += !edge.there;
  }

  void recover_edges() {
    for (MissingEdge& edge : edges_) {
      runner_.check_cancelled();
      if (is_in_vain()) return;
      Obstacles why;
      if (edge.there || !recoverer_.recover_edge(edge.verts[0], edge.verts[1], why)) continue;
      edge.there = true;
      for (const std::uint32_t t : edge.triangles) {
        if (const FaceCode code = local_.find_face(triangles_[t]); code.valid()) local_.fix(code);
      }
    }
  }

  void recover_triangles() {
    std::erase_if(missing_, [&](std::uint32_t t) {
      runner_.check_cancelled();
      Obstacles why;
      return !is_in_vain() && has_edges(t) && recoverer_.recover_triangle(triangles_[t], why);
    });
  }

  // Triangles that hang together at edges, apart from others, so that one failure does not spoil others.
  std::vector<std::vector<std::uint32_t>> missing_groups() const {
    DisjointSets groups(missing_.size());
    for (const MissingEdge& edge : edges_) {
      std::uint32_t first = kNone;
      for (const std::uint32_t t : edge.triangles) {
        const auto at = std::lower_bound(missing_.begin(), missing_.end(), t);
        if (at == missing_.end() || *at != t) continue;
        const auto other = static_cast<std::uint32_t>(at - missing_.begin());
        if (first == kNone) first = other;
        groups.join(first, other);
      }
    }
    std::vector<std::vector<std::uint32_t>> members(missing_.size());
    for (std::uint32_t i = 0; i < missing_.size(); ++i) members[groups.find(i)].push_back(missing_[i]);
    std::erase_if(members, [](const auto& list) { return list.empty(); });
    return members;
  }

  // Whether the triangles are there then.
  bool put_points(const std::vector<std::uint32_t>& triangles, SteinerOrder order, std::uint64_t& steps_left) {
    runner_.check_cancelled();
    const std::uint64_t granted = std::min(steps_left, options_.steps_of_group);
    if (granted == 0) return false;
    thorough_recoverer_.grant_steps(granted);
    SteinerRecovery steiner(local_, kept_, thorough_recoverer_, options_);
    for (const std::uint32_t t : triangles) steiner.add(triangles_[t]);
    const bool all_there = steiner.run(order);
    steps_left -= granted - thorough_recoverer_.steps_left();
    return all_there;
  }

  void use_new_points() {
    thorough_options_.search_steps *= kThorough;
    std::uint64_t steps_left = options_.steps_in_all;
    for (const std::vector<std::uint32_t>& triangles : missing_groups()) {
      if (!put_points(triangles, SteinerOrder::SidesFirst, steps_left))
        put_points(triangles, SteinerOrder::PieceByPiece, steps_left);
    }
    std::erase_if(missing_, [&](std::uint32_t t) {
      const FaceCode code = local_.find_face(triangles_[t]);
      if (code.valid()) local_.fix(code);
      return code.valid();
    });
  }

  bool has_edges(std::uint32_t t) const {
    const TriangleVerts& v = triangles_[t];
    return local_.has_edge(v[0], v[1]) && local_.has_edge(v[1], v[2]) && local_.has_edge(v[2], v[0]);
  }

  void explain(std::uint32_t t) {
    const TriangleVerts& v = triangles_[t];
    Obstacles why;
    for (std::size_t i = 0; i < 3 && !why.blocked; ++i) {
      const std::uint32_t a = v[i], b = v[(i + 1) % 3];
      if (!local_.has_edge(a, b)) why = find_obstacles(local_, a, b);
    }
    if (!why.blocked && has_edges(t)) why = find_obstacles(local_, v);
    const Vec3 center = (local_.point(v[0]) + local_.point(v[1]) + local_.point(v[2])) / 3;
    UnrecoveredTriangle entry{t, why.fault, why.blocked ? why.point : center, kNone};
    if (why.face.valid()) {
      if (const TriangleIndex::Entry* other = index_.find(sorted(local_.face(why.face)))) entry.other = other->triangle;
    }
    report_.unrecovered.push_back(entry);
  }

  std::span<const TriangleVerts> triangles_;
  const TriangleIndex& index_;
  RecoverOptions options_;
  const TaskRunner& runner_;
  LocalMesh local_;
  EdgeSet kept_;
  RecoveryReport report_;
  Recoverer recoverer_;
  RecoverOptions thorough_options_;
  Recoverer thorough_recoverer_;
  std::uint32_t given_points_;
  bool asked_ = false, in_vain_ = false;
  std::vector<std::uint32_t> missing_;
  std::vector<MissingEdge> edges_;
};

}  // namespace

RecoveryReport recover_boundary(TetMesh& mesh, std::span<const TriangleVerts> triangles, const RecoverOptions& options,
                                const TaskRunner& runner) {
  const TriangleIndex index(triangles, mesh.points.size());
  const std::vector<std::uint32_t> missing = fix_triangles(mesh, triangles, index, runner);
  if (missing.empty()) return {};
  return Recovery(mesh, triangles, index, options, runner).run(missing);
}

}  // namespace tetloom::tets
