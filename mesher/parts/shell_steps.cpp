#include "mesher/parts/shell_steps.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/base/lists.hpp"
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
  Shell(const SharedInput& input, PartShell& shell, PartId part, const TaskRunner& runner)
      : input_(input),
        shell_(shell),
        part_(part),
        runner_(runner),
        mesh_(shell.mesh),
        box_(input.decomposition.box(part)),
        surface_count_(shell.surface_count()) {}

  tets::Fault make() {
    const tets::DelaunayFrame frame{input_.box, shell_.keys.span()};
    const auto verts = std::span(shell_.verts).subspan(shell_.size);
    if (mesh_.points.empty()) mesh_.points = std::move(shell_.core_mesh.points);
    const tets::DelaunayResult delaunay = shell_.size == 0
                                              ? make_delaunay(mesh_, verts, runner_, frame)
                                              : extend_delaunay(mesh_, shell_.first_outer, verts, runner_, frame);
    shell_.size = shell_.verts.size();
    shell_.first_outer = first_outer_ = delaunay.first_outer;
    tets::Fault fault;
    if (delaunay.duplicates.empty()) {
      find_kept();
    } else {
      fault.message = "points of the surface coincide";
    }
    mesh_.points.resize(first_outer_);
    return fault;
  }

 private:
  void find_kept() {
    fix_surface();
    shell_.kept.clear(), shell_.open_balls.clear();
    std::vector<TetKeys> asked_tets;
    find_own_verts();
    sides_.emplace(
        input_,
        ShellView{mesh_, surface_count_, first_outer_, is_own_vert_, {*index_, shell_.triangles}, missing_boxes_});
    for (std::uint32_t tet = 0; tet < mesh_.size(); ++tet) {
      if (!has_own_vert(tet) || !is_kept(tet)) continue;
      if (is_own(tet)) shell_.kept.push_back(tet);
      note_open_ball(tet, asked_tets);
    }
    std::sort(asked_tets.begin(), asked_tets.end());
    std::vector<TetKeys> all;
    std::set_union(shell_.asked_tets.begin(), shell_.asked_tets.end(), asked_tets.begin(), asked_tets.end(),
                   std::back_inserter(all));
    shell_.asked_tets = std::move(all);
  }

  void fix_surface() {
    if (shell_.tri_verts.empty()) number_triangles();
    index_.emplace(shell_.tri_verts, surface_count_);
    shell_.missing.clear();
    for (const std::uint32_t t : fix_triangles(mesh_, shell_.tri_verts, *index_, runner_)) {
      Box3& box = missing_boxes_.emplace_back();
      for (const std::uint32_t v : shell_.tri_verts[t]) box.add(mesh_.points[v]);
      const std::uint32_t triangle = shell_.triangles[t];
      const auto& verts = input_.filling.complex.tri_to_vert[triangle];
      if (input_.surface.owner_of(*std::min_element(verts.begin(), verts.end())) == part_)
        shell_.missing.push_back(triangle);
    }
  }

  void number_triangles() {
    if (shell_.triangles.empty()) {
      const auto known = input_.surface.triangles_of(part_);
      shell_.triangles.assign(known.begin(), known.end());
    }
    const auto local = [&](std::uint32_t point) {
      return static_cast<std::uint32_t>(std::lower_bound(shell_.surface.begin(), shell_.surface.end(), point) -
                                        shell_.surface.begin());
    };
    for (const std::uint32_t triangle : shell_.triangles) {
      const auto& [a, b, c] = input_.filling.complex.tri_to_vert[triangle];
      shell_.tri_verts.push_back({local(a), local(b), local(c)});
    }
  }

  void find_own_verts() {
    is_own_vert_.assign(first_outer_, 0);
    for_each_own_vert(input_, shell_, part_, [&](std::uint32_t v) { is_own_vert_[v] = 1; });
  }

  // Sets own_, too.
  bool has_own_vert(std::uint32_t tet) {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    own_ = kNone;
    for (int i = 0; i < 4; ++i) {
      if (v[i] >= first_outer_) return false;
      if (is_own_vert_[v[i]] && (own_ == kNone || shell_.keys[v[i]] < shell_.keys[own_])) own_ = v[i];
    }
    return own_ != kNone;
  }

  bool is_own(std::uint32_t tet) const {
    const std::uint32_t* v = &mesh_.to_vert[std::size_t{tet} * 4];
    return std::all_of(v, v + 4, [&](std::uint32_t vert) { return shell_.keys[own_] <= shell_.keys[vert]; });
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
      if (shell_.pure_around[v[i]] == 0) return false;
    const TetBall ball(mesh_, tet);
    return any_pure_around(shell_, own_, [&](const lattice::SiteLattice& lattice, const lattice::Site& site) {
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
    if (std::binary_search(shell_.asked_tets.begin(), shell_.asked_tets.end(), keys)) return;
    shell_.open_balls.push_back(ball);
    asked_tets.push_back(keys);
  }

  TetKeys keys_of(std::uint32_t tet) const {
    TetKeys keys;
    for (std::size_t i = 0; i < 4; ++i) keys[i] = shell_.keys[mesh_.to_vert[std::size_t{tet} * 4 + i]];
    std::sort(keys.begin(), keys.end());
    return keys;
  }

  const SharedInput& input_;
  PartShell& shell_;
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
void add_surface_points(const SharedInput& input, PartShell& shell, std::span<const std::uint32_t> more) {
  const std::uint32_t before = shell.surface_count(), shift = static_cast<std::uint32_t>(more.size());
  std::vector<std::uint32_t> surface(before + shift);
  std::merge(shell.surface.begin(), shell.surface.end(), more.begin(), more.end(), surface.begin());
  GrowingArray<Vec3> points;
  GrowingArray<VertKey> keys;
  std::vector<char> knows(input.filling.complex.points.size(), 0);
  std::vector<std::uint32_t> to_new(before), added;
  for (std::uint32_t v = 0, old = 0; v < surface.size(); ++v) {
    const std::uint32_t point = surface[v];
    points.push_back(input.filling.complex.points[point]);
    keys.push_back(point);
    knows[point] = 1;
    if (old < before && shell.surface[old] == point) {
      to_new[old++] = v;
    } else {
      added.push_back(v);
    }
  }
  shell.surface = std::move(surface);
  points.append(shell.mesh.points.span().subspan(before));
  keys.append(shell.keys.span().subspan(before));
  shell.mesh.points = std::move(points);
  shell.keys = std::move(keys);
  shell.pure_around.insert(shell.pure_around.begin(), shift, 0);
  const auto renumber = [&](std::uint32_t& v) { v = v < before ? to_new[v] : v + shift; };
  for (auto* verts : {&shell.core_mesh.to_vert, &shell.mesh.to_vert})
    for (std::uint32_t& v : *verts) renumber(v);
  for (auto* verts : {&shell.core.shell_verts, &shell.core.level_to_vert, &shell.verts})
    for (std::uint32_t& v : *verts) renumber(v);
  shell.core.first_own_end += shift;
  shell.first_outer += shift;
  shell.verts.insert(shell.verts.end(), added.begin(), added.end());
  const auto& triangles = input.filling.complex.tri_to_vert;
  shell.triangles.clear(), shell.tri_verts.clear();
  for (std::uint32_t t = 0; t < triangles.size(); ++t)
    if (knows[triangles[t][0]] && knows[triangles[t][1]] && knows[triangles[t][2]]) shell.triangles.push_back(t);
}

}  // namespace

tets::Fault make_shell(const SharedInput& input, PartShell& shell, PartId part, const TaskRunner& runner) {
  return Shell(input, shell, part, runner).make();
}

bool add_shell_points(const SharedInput& input, PartShell& shell, std::span<const ShellPoint> points) {
  std::vector<std::uint32_t> surface;
  for (const ShellPoint& sent : points) {
    const auto point = static_cast<std::uint32_t>(sent.key);
    if (is_of_surface(sent.key) && !std::binary_search(shell.surface.begin(), shell.surface.end(), point))
      surface.push_back(point);
  }
  sort_unique(surface);
  if (!surface.empty()) add_surface_points(input, shell, surface);
  std::vector<std::pair<VertKey, std::uint32_t>> known;
  for (std::uint32_t v = shell.surface_count(); v < shell.keys.size(); ++v) known.emplace_back(shell.keys[v], v);
  std::sort(known.begin(), known.end());
  std::vector<char> in_shell(shell.keys.size(), 0);
  for (const std::uint32_t v : shell.verts) in_shell[v] = 1;
  bool any = !surface.empty();
  for (const ShellPoint& sent : points) {
    if (is_of_surface(sent.key)) continue;
    const auto at = std::lower_bound(known.begin(), known.end(), std::pair{sent.key, std::uint32_t{0}});
    std::uint32_t vert = 0;
    if (at != known.end() && at->first == sent.key) {
      vert = at->second;
      if (in_shell[vert]) continue;
    } else {
      vert = static_cast<std::uint32_t>(shell.keys.size());
      known.insert(at, {sent.key, vert});
      shell.mesh.points.push_back(sent.point);
      shell.keys.push_back(sent.key);
      shell.pure_around.push_back(0);
      in_shell.push_back(0);
    }
    in_shell[vert] = 1;
    shell.verts.push_back(vert);
    shell.pure_around[vert] = static_cast<std::uint16_t>(sent.has_pure);
    any = true;
  }
  return any;
}

}  // namespace tetloom::parts
