#include "mesher/refinement_log.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

namespace tetloom {

SizeRefinement refinement_for(const Misfit& misfit, const Mesh& surface) {
  const auto& [a, b, c] = surface.tri_to_vert[misfit.triangle];
  return {{surface.points[a], surface.points[b], surface.points[c]}, misfit.size};
}

void RefinementLog::note(const SizeRefinement& refinement, std::initializer_list<std::uint32_t> triangles,
                         const Mesh& surface) {
  const std::uint32_t first = surface.tri_to_entity[*triangles.begin()];
  entries_.push_back({refinement, {first, surface.tri_to_entity[*(triangles.end() - 1)]}});
}

void RefinementLog::note(const Misfit& misfit, const Mesh& surface) {
  note(refinement_for(misfit, surface), {misfit.triangle}, surface);
  entries_.back().is_misfit = true;
}

bool RefinementLog::take_back(const std::function<bool(const SizeRefinement&)>& is_useless) {
  return std::erase_if(entries_, [&](const Entry& e) { return e.is_misfit && is_useless(e.refinement); }) > 0;
}

std::vector<SizeRefinement> RefinementLog::refinements() const {
  std::vector<SizeRefinement> all;
  for (const Entry& entry : entries_) all.push_back(entry.refinement);
  return all;
}

std::size_t RefinementLog::misfit_count() const {
  return static_cast<std::size_t>(std::ranges::count(entries_, true, &Entry::is_misfit));
}

double RefinementLog::smallest_size() const {
  double smallest = HUGE_VAL;
  for (const Entry& entry : entries_) smallest = std::min(smallest, entry.refinement.size);
  return entries_.empty() ? 0 : smallest;
}

Diagnostic RefinementLog::describe(const SurfaceRefinement& refinement, bool done, const GeometricModel& model) const {
  std::ostringstream message;
  message << "the size asked for does not fit everywhere (" << refinement.narrow_places
          << " triangles at walls, faces or edges too narrow for it, " << refinement.crossings << " crossings): ";
  if (done)
    message << "it was made smaller there, down to " << smallest_size();
  else
    message << "there is too little memory for sizes that do";
  std::map<std::uint32_t, std::size_t> face_to_count;  // of triangles
  Diagnostic diagnostic{ErrorCode::SizeReduced, message.str(), {}, {}, {}};
  double smallest = HUGE_VAL;
  for (const Entry& entry : entries_) {
    ++face_to_count[entry.faces[0]];
    if (entry.faces[1] != entry.faces[0]) ++face_to_count[entry.faces[1]];
    if (entry.refinement.size >= smallest) continue;
    smallest = entry.refinement.size;
    const auto& [a, b, c] = entry.refinement.corners;
    diagnostic.point = (1.0 / 3) * (a + b + c);
  }
  std::vector<std::pair<std::size_t, std::uint32_t>> most;
  for (const auto& [face, count] : face_to_count) most.push_back({count, face});
  std::ranges::sort(
      most, [](const auto& s, const auto& t) { return s.first != t.first ? s.first > t.first : s.second < t.second; });
  for (const auto& [count, face] : most) diagnostic.entities.push_back({{2, face}, model.attributes({2, face}).name});
  return diagnostic;
}

}  // namespace tetloom
