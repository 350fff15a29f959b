#include "mesher/parts/shell_sides.hpp"

#include <algorithm>

namespace tetloom::parts {

using tets::FaceCode;

bool ShellSides::is_inside(std::uint32_t tet) {
  if (to_side_[tet] != Side::Unknown) return to_side_[tet] == Side::Inside;
  if (is_sure(tet)) return walk(tet);
  if (const auto told = is_inside_by_faces(input_, shell_.mesh, tet, shell_.known)) return *told;
  if (is_at_outside(tet) && !may_meet_missing(tet)) return false;
  return is_inside_by_center(input_, shell_.mesh, tet);
}

// From tet to tet until one tells. Pre: the tet is sure.
bool ShellSides::walk(std::uint32_t tet) {
  walked_.assign(1, tet);
  to_side_[tet] = Side::Walked;
  std::optional<bool> told;
  for (std::size_t k = 0; k < walked_.size() && !told; ++k) {
    told = told_by(walked_[k]);
    if (told) break;
    for (const FaceCode face : FaceCode::of(walked_[k])) {
      const FaceCode behind = shell_.mesh.behind(face);
      if (!behind.valid() || shell_.mesh.is_fixed(face)) continue;
      const Side side = to_side_[behind.tet()];
      if (side == Side::Inside || side == Side::Outside) told = side == Side::Inside;
      if (side != Side::Unknown || !is_sure(behind.tet())) continue;
      to_side_[behind.tet()] = Side::Walked;
      walked_.push_back(behind.tet());
    }
  }
  const bool inside = told ? *told : is_inside_by_center(input_, shell_.mesh, tet);
  for (const std::uint32_t one : walked_) to_side_[one] = inside ? Side::Inside : Side::Outside;
  return inside;
}

// Points of the lattices lie inside.
std::optional<bool> ShellSides::told_by(std::uint32_t tet) const {
  const std::uint32_t* v = verts(tet);
  if (std::max({v[0], v[1], v[2], v[3]}) >= shell_.surface_count) return true;
  if (const auto told = is_inside_by_faces(input_, shell_.mesh, tet, shell_.known)) return told;
  if (is_at_outside(tet)) return false;
  return std::nullopt;
}

// Whether no triangle of the surface runs through the tet: between own vertices the part knows them all, and those that
// the shell has are faces.
bool ShellSides::is_sure(std::uint32_t tet) const {
  const std::uint32_t* v = verts(tet);
  for (int i = 0; i < 4; ++i)
    if (v[i] >= shell_.first_outer || !shell_.is_own_vert[v[i]]) return false;
  return !may_meet_missing(tet);
}

bool ShellSides::is_at_outside(std::uint32_t tet) const {
  for (const FaceCode face : FaceCode::of(tet)) {
    const FaceCode behind = shell_.mesh.behind(face);
    if (shell_.mesh.is_fixed(face)) continue;
    if (!behind.valid()) return true;
    const std::uint32_t* v = verts(behind.tet());
    if (std::max({v[0], v[1], v[2], v[3]}) >= shell_.first_outer) return true;
  }
  return false;
}

// Only where a triangle is missing, the surface may lie between a tet and the outside that it has behind a face.
bool ShellSides::may_meet_missing(std::uint32_t tet) const {
  if (shell_.missing_boxes.empty()) return false;
  Box3 box;
  for (int i = 0; i < 4; ++i) box.add(shell_.mesh.point_of(tet, i));
  return std::any_of(shell_.missing_boxes.begin(), shell_.missing_boxes.end(),
                     [&](const Box3& missing) { return missing.overlaps(box); });
}

}  // namespace tetloom::parts
