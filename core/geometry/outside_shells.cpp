#include "core/geometry/outside_shells.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/disjoint_sets.hpp"
#include "core/geometry/bad_geometry.hpp"

namespace tetloom {
namespace {

constexpr double kChord = 0.005;  // of the diagonal: of the facets by which shells are told apart
constexpr double kTurn = 0.2;     // radians between those facets

}  // namespace

OutsideShells::OutsideShells(const GeometricModel& model) : model_(model), topology_(model.topology()) {
  find_shells();
  measure();
  for (Shell& shell : shells_) judge(shell);
}

double OutsideShells::enclosed_volume() const {
  double volume = 0;
  std::vector<bool> is_counted(topology_.region_count(), false);
  DisjointSets bodies(topology_.region_count());
  for (const FaceSides& sides : topology_.face_to_sides)
    if (sides.front.valid() && sides.back.valid()) bodies.join(sides.front.value, sides.back.value);
  std::vector<bool> body_is_outside(topology_.region_count(), false);
  for (std::uint32_t f = 0; f < shell_of_.size(); ++f)
    if (has(f) && region_of(f).valid()) body_is_outside[bodies.find(region_of(f).value)] = true;
  for (std::uint32_t r = 0; r < topology_.region_count(); ++r)
    if (body_is_outside[bodies.find(r)]) volume += model_.volume(ModelRegionId(r));
  for (const Shell& shell : shells_)
    if (shell.volume < 0 && shell.region != kNone && body_is_outside[bodies.find(shell.region)]) volume -= shell.volume;
  return volume;
}

// The one region of a face, or none.
ModelRegionId OutsideShells::region_of(std::uint32_t face) const {
  const FaceSides& sides = topology_.face_to_sides[face];
  return sides.front.valid() ? sides.front : sides.back;
}

// Faces with the outside on one side at least, hanging together through edges.
void OutsideShells::find_shells() {
  DisjointSets sets(topology_.face_count());
  std::vector<std::uint32_t> edge_to_face(topology_.edge_count(), kNone);
  const auto is_outer = [&](std::uint32_t f) {
    return !topology_.face_to_sides[f].front.valid() || !topology_.face_to_sides[f].back.valid();
  };
  for (std::uint32_t f = 0; f < topology_.face_count(); ++f)
    for (const ModelLoop& loop : topology_.face_to_loops[f])
      for (const EdgeUse& use : loop) {
        if (!is_outer(f) || topology_.edges[use.edge.value].degenerate) continue;
        std::uint32_t& other = edge_to_face[use.edge.value];
        if (other == kNone) other = f;
        sets.join(f, other);
      }
  shell_of_.assign(topology_.face_count(), kNone);
  std::vector<std::uint32_t> set_to_shell(topology_.face_count(), kNone);
  for (std::uint32_t f = 0; f < topology_.face_count(); ++f) {
    if (!is_outer(f)) continue;
    std::uint32_t& shell = set_to_shell[sets.find(f)];
    if (shell == kNone) {
      shell = static_cast<std::uint32_t>(shells_.size());
      shells_.emplace_back();
    }
    shell_of_[f] = shell;
  }
}

void OutsideShells::measure() {
  const Box3& box = model_.bounding_box();
  for (std::uint32_t f = 0; f < topology_.face_count(); ++f) {
    if (shell_of_[f] == kNone) continue;
    Shell& shell = shells_[shell_of_[f]];
    const FaceSides& sides = topology_.face_to_sides[f];
    if (region_of(f).valid()) shell.region = region_of(f).value;
    if (!region_of(f).valid()) shell.is_closed = false;
    Tessellation facets;
    tolerate_bad_geometry(
        [&] { facets = model_.face_geometry(ModelFaceId(f))->tessellate(kChord * box.diagonal(), kTurn); });
    for (const auto& [a, b, c] : facets.tri_to_vert) {
      std::array<Vec3, 3> x{facets.points[a], facets.points[b], facets.points[c]};
      if (sides.front.valid()) std::swap(x[1], x[2]);
      shell.volume += dot(x[0] - box.lo, cross(x[1] - box.lo, x[2] - box.lo)) / 6;
      for (const Vec3& p : x) shell.box.add(p);
      shell.facets.push_back(x);
    }
  }
}

// Voids, and what lies in another shell, are not outside.
void OutsideShells::judge(Shell& shell) {
  if (shell.facets.empty()) return;
  shell.is_outside = !(shell.is_closed && shell.volume < 0);
  const Vec3& point = shell.facets[0][0];
  for (const Shell& other : shells_) {
    if (&other == &shell || !other.is_closed || other.volume <= 0 || !other.box.contains(point)) continue;
    constexpr double kInside = 0.5;
    if (winding_number(other, point) > kInside) shell.is_outside = false;
  }
}

// By the solid angles of the facets (van Oosterom & Strackee 1983).
double OutsideShells::winding_number(const Shell& shell, const Vec3& point) {
  double angle = 0;
  for (const auto& facet : shell.facets) {
    const Vec3 a = facet[0] - point, b = facet[1] - point, c = facet[2] - point;
    const double la = norm(a), lb = norm(b), lc = norm(c);
    angle += 2 * std::atan2(dot(a, cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb);
  }
  return angle / (4 * std::numbers::pi);
}

}  // namespace tetloom
