#include "mesher/refinement_log.hpp"

#include <algorithm>
#include <sstream>

namespace tetloom {

SizeRefinement refinement_for(const Misfit& misfit, const Mesh& surface) {
  const auto& [a, b, c] = surface.tri_to_vert[misfit.triangle];
  return {{surface.points[a], surface.points[b], surface.points[c]}, misfit.size};
}

void RefinementLog::note(const SizeRefinement& refinement, std::initializer_list<std::uint32_t> triangles,
                         const Mesh& surface) {
  for (const std::uint32_t triangle : triangles) ++face_to_count_[surface.tri_to_entity[triangle]];
  if (smallest_size_ > 0 && smallest_size_ <= refinement.size) return;
  smallest_size_ = refinement.size;
  const auto& [a, b, c] = refinement.corners;
  smallest_place_ = (1.0 / 3) * (a + b + c);
}

void RefinementLog::note(const Misfit& misfit, const Mesh& surface) {
  note(refinement_for(misfit, surface), {misfit.triangle}, surface);
}

Diagnostic RefinementLog::describe(const SurfaceRefinement& refinement, bool done, const GeometricModel& model) const {
  std::ostringstream message;
  message << "the size asked for does not fit everywhere (" << refinement.narrow_places
          << " triangles at walls, faces or edges narrower than 0.4 of it, " << refinement.crossings << " crossings): ";
  if (done)
    message << "it was made smaller there, down to " << smallest_size_;
  else
    message << "there is too little memory for sizes that do";
  std::vector<std::pair<std::size_t, std::uint32_t>> most;
  for (const auto& [face, count] : face_to_count_) most.push_back({count, face});
  std::ranges::sort(
      most, [](const auto& s, const auto& t) { return s.first != t.first ? s.first > t.first : s.second < t.second; });
  Diagnostic diagnostic{ErrorCode::SizeReduced, message.str(), {}, smallest_place_, {}};
  for (const auto& [count, face] : most) diagnostic.entities.push_back({{2, face}, model.attributes({2, face}).name});
  return diagnostic;
}

}  // namespace tetloom
