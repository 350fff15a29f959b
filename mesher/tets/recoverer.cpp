#include "mesher/tets/recoverer.hpp"

namespace tetloom::tets {

namespace {

constexpr std::uint64_t kShare = 4;  // one edge or triangle may take one in as many of the steps that are left

}  // namespace

// The cavity grows where its filling fails, as long as it stays small. One edge or triangle leaves steps for others.
template <class Wanted>
bool Recoverer::reconnect(const Wanted& wanted, TetList tets) {
  const std::uint64_t left_to_others = steps_left_ - steps_left_ / kShare;
  for (std::uint32_t growth = 0; growth <= options_.growths && steps_left_ > left_to_others; ++growth) {
    std::optional<RecoveryCavity> cavity = make_cavity(mesh_, kept_, tets, std::min(options_.cavity_points, 64u));
    if (!cavity) return false;
    wanted(*cavity);
    check_cancelled();
    const SmallFilling filling =
        fill_small_polyhedron(cavity->shape, std::min(options_.search_steps, steps_left_ - left_to_others));
    spend_steps(filling.steps);
    if (filling.outcome == SmallFilling::Found) {
      refill(mesh_, *cavity, filling);
      ++(cavity->to_vert.size() <= 5 ? report_.flips : report_.reconnections);
      return true;
    }
    TetList more = grown(mesh_, *cavity, filling);
    if (more.size() == tets.size()) return false;
    tets = std::move(more);
  }
  return false;
}

bool Recoverer::recover_edge(std::uint32_t a, std::uint32_t b, Obstacles& why) {
  if (mesh_.has_edge(a, b)) return true;
  why = find_obstacles(mesh_, a, b);
  if (why.blocked) return false;
  return reconnect([&](RecoveryCavity& cavity) { demand(cavity, a, b); }, why.tets);
}

bool Recoverer::remove_point(std::uint32_t point, std::span<const TriangleVerts> triangles) {
  const auto wanted = [&](RecoveryCavity& cavity) {
    leave_out(cavity, point);
    for (const TriangleVerts& triangle : triangles) demand(cavity, triangle);
  };
  return reconnect(wanted, mesh_.find_ball(point));
}

bool Recoverer::recover_triangle(const TriangleVerts& triangle, Obstacles& why) {
  FaceCode code = mesh_.find_face(triangle);
  if (!code.valid()) {
    why = find_obstacles(mesh_, triangle);
    if (why.blocked) return false;
    if (!reconnect([&](RecoveryCavity& cavity) { demand(cavity, triangle); }, why.tets)) return false;
    code = mesh_.find_face(triangle);
    if (!code.valid()) return false;
  }
  mesh_.fix(code);
  return true;
}

}  // namespace tetloom::tets
