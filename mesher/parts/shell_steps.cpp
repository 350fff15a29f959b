#include "mesher/parts/shell_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/base/lists.hpp"
#include "core/base/stopwatch.hpp"
#include "core/predicates/predicates.hpp"
#include "core/tets/circumsphere.hpp"
#include "core/tets/find_triangles.hpp"
#include "mesher/parts/shell_sides.hpp"
#include "mesher/parts/shell_tets.hpp"
#include "mesher/tets/delaunay.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;
using tets::TriangleVerts;

// Balls count as a little larger than they are computed to be.
constexpr double kRoundOff = 1e-6;
// A lattice's size may be this much larger than the field's at its points, or smaller.
constexpr double kLevelStep = 1.3;

OpenBall ball_of(const TetMesh& mesh, std::uint32_t tet) {
  OpenBall ball;
  for (int i = 0; i < 4; ++i) ball.corners[static_cast<std::size_t>(i)] = mesh.point_of(tet, i);
  const auto& [a, b, c, d] = ball.corners;
  const Vec3 center = tets::Circumsphere(a, b, c, d).center_from_corner();
  ball.center = a + center;
  ball.radius = norm(center) * (1 + kRoundOff);
  if (!std::isfinite(ball.radius)) ball.center = a, ball.radius = HUGE_VAL;
  return ball;
}

class Shell {
 public:
  Shell(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner)
      : input_(input),
        state_(state),
        part_(part),
        runner_(runner),
        mesh_(state.shell.mesh),
        box_(input.decomposition.box(part)),
        surface_count_(state.surface_count()) {}

  void make() {
    const tets::DelaunayFrame frame{input_.box, state_.keys.span()};
    const auto verts = std::span(state_.shell.verts).subspan(state_.shell.size);
    if (mesh_.points.empty()) mesh_.points = std::move(state_.mesh.points);
    const tets::DelaunayResult delaunay = state_.shell.size == 0
                                              ? make_delaunay(mesh_, verts, runner_, frame)
                                              : extend_delaunay(mesh_, state_.shell.first_outer, verts, runner_, frame);
    state_.shell.size = state_.shell.verts.size();
    state_.shell.first_outer = first_outer_ = delaunay.first_outer;
    if (delaunay.duplicates.empty()) {
      find_kept();
    } else {
      state_.fault.message = "points of the surface coincide";
    }
    mesh_.points.resize(first_outer_);
  }

 private:
  void find_kept() {
    fix_surface();
    state_.shell.kept.clear(), state_.shell.open_balls.clear();
    std::vector<TetKeys> asked_tets;
    find_own_verts();
    sides_.emplace(
        input_,
        ShellView{mesh_, surface_count_, first_outer_, is_own_vert_, {*index_, state_.triangles}, missing_boxes_});
    for (std::uint32_t tet = 0; tet < mesh_.size(); ++tet) {
      if (!has_own_vert(tet) || !is_kept(tet)) continue;
      if (is_own(tet)) state_.shell.kept.push_back(tet);
      note_open_ball(tet, asked_tets);
    }
    std::sort(asked_tets.begin(), asked_tets.end());
    std::vector<TetKeys> all;
    std::set_union(state_.shell.asked_tets.begin(), state_.shell.asked_tets.end(), asked_tets.begin(), asked_tets.end(),
                   std::back_inserter(all));
    state_.shell.asked_tets = std::move(all);
  }

  void fix_surface() {
    if (state_.shell.tri_verts.empty()) number_triangles();
    index_.emplace(state_.shell.tri_verts, surface_count_);
    state_.shell.missing.clear();
    for (const std::uint32_t t : fix_triangles(mesh_, state_.shell.tri_verts, *index_, runner_)) {
      Box3& box = missing_boxes_.emplace_back();
      for (const std::uint32_t v : state_.shell.tri_verts[t]) box.add(mesh_.points[v]);
      const std::uint32_t triangle = state_.triangles[t];
      const auto& verts = input_.filling.complex.tri_to_vert[triangle];
      if (input_.surface.owner_of(*std::min_element(verts.begin(), verts.end())) == part_)
        state_.shell.missing.push_back(triangle);
    }
  }

  void number_triangles() {
    if (state_.triangles.empty()) {
      const auto known = input_.surface.triangles_of(part_);
      state_.triangles.assign(known.begin(), known.end());
    }
    const auto local = [&](std::uint32_t point) {
      return static_cast<std::uint32_t>(std::lower_bound(state_.surface.begin(), state_.surface.end(), point) -
                                        state_.surface.begin());
    };
    for (const std::uint32_t triangle : state_.triangles) {
      const auto& [a, b, c] = input_.filling.complex.tri_to_vert[triangle];
      state_.shell.tri_verts.push_back({local(a), local(b), local(c)});
    }
  }

  void find_own_verts() {
    is_own_vert_.assign(first_outer_, 0);
    for_each_own_vert(input_, state_, part_, [&](std::uint32_t v) { is_own_vert_[v] = 1; });
  }

  // Sets own_, too.
  bool has_own_vert(std::uint32_t tet) {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    own_ = kNone;
    for (int i = 0; i < 4; ++i) {
      if (v[i] >= first_outer_) return false;
      if (is_own_vert_[v[i]] && (own_ == kNone || state_.keys[v[i]] < state_.keys[own_])) own_ = v[i];
    }
    return own_ != kNone;
  }

  bool is_own(std::uint32_t tet) const {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    return std::all_of(v, v + 4, [&](std::uint32_t vert) { return state_.keys[own_] <= state_.keys[vert]; });
  }

  // Whether the tet is one of the mesh, of those that are no tets of the core: neither outside nor in the core's place.
  bool is_kept(std::uint32_t tet) {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    const auto of_surface = [&](std::uint32_t vert) { return vert < surface_count_; };
    const auto count = std::count_if(v, v + 4, of_surface);
    if (count == 4) return sides_->is_inside(tet);
    return count > 0 || !is_in_core(tet);
  }

  // In the place of the core when it holds a pure site. One next to its own vertex is held then: near that vertex, the
  // tet overlaps a tet of the core, which has another vertex in the ball.
  bool is_in_core(std::uint32_t tet) const {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    for (int i = 0; i < 4; ++i)
      if (state_.shell.pure_around[v[i]] == 0) return false;
    const TetBall ball(mesh_, tet);
    return any_pure_around(state_, own_, [&](const lattice::SiteLattice& lattice, const lattice::Site& site) {
      return ball.holds(lattice, site);
    });
  }

  // Tets of other parts are asked about, too: where the part does not know a point of a tet of its own, another one
  // stands in its place. One that is still there after others have been asked about it holds no point of theirs.
  void note_open_ball(std::uint32_t tet, std::vector<TetKeys>& asked_tets) {
    const OpenBall ball = ball_of(mesh_, tet);
    const Vec3 reach{ball.radius, ball.radius, ball.radius};
    const double outside =
        std::max(distance_outside(ball.center - reach, box_), distance_outside(ball.center + reach, box_));
    if (outside <= 0) return;
    const double size = input_.size_at(mesh_.points[own_]);
    const double least =
        input_.is_graded() ? (size - 2 * input_.filling.sizes.gradation() * ball.radius) / kLevelStep : size;
    if (outside <= kShellReach * least) return;
    const TetKeys keys = keys_of(tet);
    if (std::binary_search(state_.shell.asked_tets.begin(), state_.shell.asked_tets.end(), keys)) return;
    state_.shell.open_balls.push_back(ball);
    asked_tets.push_back(keys);
  }

  TetKeys keys_of(std::uint32_t tet) const {
    TetKeys keys;
    for (std::size_t i = 0; i < 4; ++i) keys[i] = state_.keys[mesh_.to_vert[std::size_t{tet} * 4 + i]];
    std::sort(keys.begin(), keys.end());
    return keys;
  }

  const SharedInput& input_;
  PartState& state_;
  PartId part_;
  const TaskRunner& runner_;
  TetMesh& mesh_;
  const Box3& box_;
  std::uint32_t surface_count_, first_outer_ = 0;
  std::uint32_t own_ = 0;  // of a tet's vertices of the part, the one of the lowest key
  std::vector<char> is_own_vert_;
  std::optional<tets::TriangleIndex> index_;
  std::vector<Box3> missing_boxes_;  // of all triangles that the part knows and the shell does not have
  std::optional<ShellSides> sides_;
};

// Points of the surface stand first, ascending: nearly all vertices get new numbers.
void add_surface_points(const SharedInput& input, PartState& state, std::span<const std::uint32_t> more) {
  const std::uint32_t before = state.surface_count(), shift = static_cast<std::uint32_t>(more.size());
  std::vector<std::uint32_t> surface(before + shift);
  std::merge(state.surface.begin(), state.surface.end(), more.begin(), more.end(), surface.begin());
  GrowingArray<Vec3> points;
  GrowingArray<VertKey> keys;
  std::vector<char> knows(input.filling.complex.points.size(), 0);
  std::vector<std::uint32_t> to_new(before), added;
  for (std::uint32_t v = 0, old = 0; v < surface.size(); ++v) {
    const std::uint32_t point = surface[v];
    points.push_back(input.filling.complex.points[point]);
    keys.push_back(point);
    knows[point] = 1;
    if (old < before && state.surface[old] == point) {
      to_new[old++] = v;
    } else {
      added.push_back(v);
    }
  }
  state.surface = std::move(surface);
  points.append(state.shell.mesh.points.span().subspan(before));
  keys.append(state.keys.span().subspan(before));
  state.shell.mesh.points = std::move(points);
  state.keys = std::move(keys);
  state.shell.pure_around.insert(state.shell.pure_around.begin(), shift, 0);
  const auto renumber = [&](std::uint32_t& v) { v = v < before ? to_new[v] : v + shift; };
  for (auto* verts : {&state.mesh.to_vert, &state.shell.mesh.to_vert})
    for (std::uint32_t& v : *verts) renumber(v);
  for (auto* verts : {&state.core.shell_verts, &state.core.level_to_vert, &state.shell.verts})
    for (std::uint32_t& v : *verts) renumber(v);
  state.core.first_own_end += shift;
  state.shell.first_outer += shift;
  state.shell.verts.insert(state.shell.verts.end(), added.begin(), added.end());
  const auto& triangles = input.filling.complex.tri_to_vert;
  state.triangles.clear(), state.shell.tri_verts.clear();
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    if (knows[triangles[t][0]] && knows[triangles[t][1]] && knows[triangles[t][2]]) state.triangles.push_back(t);
}

}  // namespace

void make_shell(const SharedInput& input, PartState& state, PartId part, const TaskRunner& runner) {
  Stopwatch watch;
  Shell(input, state, part, runner).make();
  state.figures.seconds.delaunay += watch.lap();
}

bool add_shell_points(const SharedInput& input, PartState& state, std::span<const ShellPoint> points) {
  std::vector<std::uint32_t> surface;
  for (const ShellPoint& sent : points) {
    const auto point = static_cast<std::uint32_t>(sent.key);
    if (is_of_surface(sent.key) && !std::binary_search(state.surface.begin(), state.surface.end(), point))
      surface.push_back(point);
  }
  sort_unique(surface);
  if (!surface.empty()) add_surface_points(input, state, surface);
  std::vector<std::pair<VertKey, std::uint32_t>> known;
  for (std::uint32_t v = state.surface_count(); v < state.keys.size(); ++v) known.emplace_back(state.keys[v], v);
  std::sort(known.begin(), known.end());
  std::vector<char> in_shell(state.keys.size(), 0);
  for (const std::uint32_t v : state.shell.verts) in_shell[v] = 1;
  bool any = !surface.empty();
  for (const ShellPoint& sent : points) {
    if (is_of_surface(sent.key)) continue;
    const auto at = std::lower_bound(known.begin(), known.end(), std::pair{sent.key, std::uint32_t{0}});
    std::uint32_t vert = 0;
    if (at != known.end() && at->first == sent.key) {
      vert = at->second;
      if (in_shell[vert]) continue;
    } else {
      vert = static_cast<std::uint32_t>(state.keys.size());
      known.insert(at, {sent.key, vert});
      state.shell.mesh.points.push_back(sent.point);
      state.keys.push_back(sent.key);
      state.shell.pure_around.push_back(0);
      in_shell.push_back(0);
    }
    in_shell[vert] = 1;
    state.shell.verts.push_back(vert);
    state.shell.pure_around[vert] = static_cast<std::uint16_t>(sent.has_pure);
    any = true;
  }
  return any;
}

}  // namespace tetloom::parts
