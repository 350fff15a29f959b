#include "mesher/failed_complexes.hpp"

#include <algorithm>

#include "mesher/complexes.hpp"

namespace tetloom {

FailedComplexes::FailedComplexes(const GeometricModel& model)
    : model_(model), face_to_complex_(find_complexes(model.topology())) {
  const ModelTopology& topology = model.topology();
  edge_to_complexes_.resize(topology.edge_count());
  std::uint32_t count = 0;
  for (std::size_t f = 0; f < topology.face_count(); ++f) {
    count = std::max(count, face_to_complex_[f] + 1);
    for (const ModelLoop& loop : topology.face_to_loops[f])
      for (const EdgeUse& use : loop) edge_to_complexes_[use.edge.value].push_back(face_to_complex_[f]);
  }
  failed_.assign(count, false);
}

// Edges count where neither a face nor a region is named: with a face they only say where in it.
std::vector<std::uint32_t> FailedComplexes::complexes_of(const Diagnostic& error) const {
  const ModelTopology& topology = model_.topology();
  std::vector<std::uint32_t> found, of_edges;
  for (const NamedEntity& named : error.entities) {
    const auto [dim, index] = named.entity;
    if (dim == 2 && index < face_to_complex_.size()) found.push_back(face_to_complex_[index]);
    if (dim == 3 && index < topology.region_count() && !topology.region_to_faces[index].empty())
      found.push_back(face_to_complex_[topology.region_to_faces[index].front().value]);
    if (dim == 1 && index < edge_to_complexes_.size())
      of_edges.insert(of_edges.end(), edge_to_complexes_[index].begin(), edge_to_complexes_[index].end());
  }
  return found.empty() ? of_edges : found;
}

bool FailedComplexes::take(const std::vector<Diagnostic>& errors) {
  std::vector<bool> failed = failed_;
  std::vector<Diagnostic> taken = errors_;
  for (const Diagnostic& error : errors) {
    const std::vector<std::uint32_t> complexes = complexes_of(error);
    if (complexes.empty()) return false;
    const bool known =
        std::all_of(complexes.begin(), complexes.end(), [&](std::uint32_t c) { return bool(failed_[c]); });
    if (!known) taken.push_back(error);
    for (const std::uint32_t complex : complexes) failed[complex] = true;
  }
  if (std::find(failed.begin(), failed.end(), false) == failed.end()) return false;
  failed_ = std::move(failed);
  errors_ = std::move(taken);
  return true;
}

std::vector<bool> FailedComplexes::faces() const {
  std::vector<bool> result;
  for (const std::uint32_t complex : face_to_complex_) result.push_back(failed_[complex]);
  return result;
}

}  // namespace tetloom
