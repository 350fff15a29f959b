#include "mesher/tets/recoverer.hpp"

namespace tetloom::tets {

// The cavity grows where its filling fails, as long as it stays small.
template <class Wanted>
bool Recoverer::reconnect(const Wanted& wanted, TetList tets) {
  for (std::uint32_t growth = 0; growth <= options_.growths && steps_left_ > 0; ++growth) {
    std::optional<Cavity> cavity = make_cavity(mesh_, kept_, tets, std::min(options_.cavity_points, 64u));
    if (!cavity) return false;
    wanted(*cavity);
    check_cancelled();
    const SmallFilling filling = fill_small_polyhedron(cavity->shape, options_.search_steps);
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
  return reconnect([&](Cavity& cavity) { demand(cavity, a, b); }, why.tets);
}

bool Recoverer::recover_triangle(const TriangleVerts& triangle, Obstacles& why) {
  FaceCode code = mesh_.find_face(triangle);
  if (code == kNone) {
    why = find_obstacles(mesh_, triangle);
    if (why.blocked) return false;
    if (!reconnect([&](Cavity& cavity) { demand(cavity, triangle); }, why.tets)) return false;
    code = mesh_.find_face(triangle);
    if (code == kNone) return false;
  }
  mesh_.fix(code);
  return true;
}

}  // namespace tetloom::tets
