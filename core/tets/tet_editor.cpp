#include "core/tets/tet_editor.hpp"

#include <algorithm>

#include "tetloom/assert.hpp"

namespace tetloom::tets {

std::uint32_t TetEditor::take(TetMesh& mesh, GrowingArray<float>* to_quality) {
  if (first_dead_.valid()) {
    const std::uint32_t tet = first_dead_.tet();
    first_dead_ = mesh.behind(first_dead_);
    return tet;
  }
  const std::size_t tet = mesh.size();
  mesh.to_vert.resize_for_overwrite((tet + 1) * 4);
  mesh.to_neighbor.resize_for_overwrite((tet + 1) * 4);
  mesh.to_region.push_back(kNone);
  mesh.to_fixed.push_back(0);
  if (to_quality) to_quality->push_back(kDeadQuality);
  return static_cast<std::uint32_t>(tet);
}

void TetEditor::drop(TetMesh& mesh, GrowingArray<float>* to_quality, std::uint32_t tet) {
  mesh.to_vert[std::size_t{tet} * 4] = kNone;
  mesh.behind({tet, 0}) = first_dead_;
  mesh.to_fixed[tet] = 0;
  if (to_quality) (*to_quality)[tet] = kDeadQuality;
  first_dead_ = {tet, 0};
}

std::span<const std::uint32_t> TetEditor::replace(TetMesh& mesh, GrowingArray<float>* to_quality,
                                                  const Replacement& what) {
  filling_.open(mesh, what.old, what.made.size());
  filling_.swap_surface(what.before, what.after);
  write(mesh, to_quality, what);
  const bool fits = filling_.close(mesh, ids_);
  TETLOOM_ASSERT(fits);
  return ids_;
}

std::span<const std::uint32_t> TetEditor::write(TetMesh& mesh, GrowingArray<float>* to_quality,
                                                const Replacement& what) {
  const std::size_t kept = std::min(what.old.size(), what.made.size());
  const std::uint32_t region = mesh.to_region[what.old[0]];
  ids_.assign(what.old.begin(), what.old.begin() + static_cast<std::ptrdiff_t>(kept));
  for (const std::uint32_t tet : what.old.subspan(kept)) drop(mesh, to_quality, tet);
  while (ids_.size() < what.made.size()) ids_.push_back(take(mesh, to_quality));
  for (std::size_t i = 0; i < ids_.size(); ++i) {
    const std::uint32_t tet = ids_[i];
    const NewTet& made = what.made[i];
    std::copy(made.verts.begin(), made.verts.end(), &mesh.to_vert[std::size_t{tet} * 4]);
    mesh.to_region[tet] = what.regions.empty() ? region : what.regions[i];
    mesh.to_fixed[tet] = 0;
    if (to_quality) (*to_quality)[tet] = static_cast<float>(made.quality);
  }
  return ids_;
}

}  // namespace tetloom::tets
