#include "mesher/volume/surface_freedom.hpp"

#include <algorithm>

#include "core/geometry/model_projector.hpp"
#include "mesher/volume/surface_clearance.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

namespace {

std::array<std::uint32_t, 2> edge_key(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

SurfaceFreedom::SurfaceFreedom(const VolumeInput& input, std::span<const Complex> complexes)
    : input_(input), may_slide_(input.points.size(), 0) {
  for (const auto& [a, b] : input.edge_to_vert) kept_edges_.push_back(edge_key(a, b));
  std::ranges::sort(kept_edges_);
  std::vector<std::uint8_t> piece_count(input.points.size(), 0);
  for (const auto& piece : input.edge_to_vert)
    for (const std::uint32_t v : piece) piece_count[v] = static_cast<std::uint8_t>(std::min(3, piece_count[v] + 1));
  std::vector<std::uint8_t> complex_count(input.points.size(), 0);
  std::vector<std::uint8_t> in_complex(input.tri_to_vert.size(), 0);
  for (const Complex& complex : complexes) {
    for (const std::uint32_t v : complex.to_input_vert)
      complex_count[v] = static_cast<std::uint8_t>(std::min(2, complex_count[v] + 1));
    for (const std::uint32_t t : complex.to_input_tri) in_complex[t] = 1;
  }
  for (std::size_t v = 0; v < complex_count.size(); ++v) may_slide_[v] = complex_count[v] == 1;
  // Where edges of the model were merged, more than two pieces may end inside of one of them.
  for (std::size_t v = 0; !kept_edges_.empty() && v < input.point_to_entity.size(); ++v)
    if (input.point_to_entity[v].dim == 1 && piece_count[v] != 2) may_slide_[v] = 0;
  for (std::size_t t = 0; t < in_complex.size(); ++t) {
    if (in_complex[t]) continue;
    for (const std::uint32_t v : input.tri_to_vert[t]) may_slide_[v] = 0;
  }
}

bool SurfaceFreedom::is_kept(std::uint32_t a, std::uint32_t b) const {
  return std::ranges::binary_search(kept_edges_, edge_key(a, b));
}

ModelEntity SurfaceFreedom::entity_of(std::uint32_t vertex) const {
  return input_.point_to_entity.empty() || may_slide_[vertex] == 0 ? ModelEntity{} : input_.point_to_entity[vertex];
}

std::vector<std::array<std::uint32_t, 3>> improve(tets::TetMesh& mesh, const ImprovementInput& input,
                                                  tets::OptimizeReport& report, const TaskRunner& runner) {
  const auto& [complex, tree, freedom, options, is_frozen] = input;
  std::vector<std::array<std::uint32_t, 3>> triangles(complex.tri_to_vert.begin(), complex.tri_to_vert.end());
  std::vector<std::uint32_t> tri_to_face;
  std::vector<ModelEntity> point_to_entity;
  for (const std::uint32_t t : complex.to_input_tri) tri_to_face.push_back(freedom.input().tri_to_face[t]);
  for (std::size_t v = 0; v < complex.points.size(); ++v) {
    const bool stays = !is_frozen.empty() && is_frozen[v];
    point_to_entity.push_back(stays ? ModelEntity{} : freedom.entity_of(complex.to_input_vert[v]));
  }
  tets::ChangeableSurface surface{triangles, tri_to_face, point_to_entity, {}, {}, {}};
  surface.is_kept = [&to_input = complex.to_input_vert, &kept = freedom, frozen = is_frozen](std::uint32_t a,
                                                                                             std::uint32_t b) {
    if (!frozen.empty() && (frozen[a] || frozen[b])) return true;
    return kept.is_kept(to_input[a], to_input[b]);
  };
  SurfaceClearance clearance(complex, tree, triangles, tri_to_face);
  surface.is_clear = [&](const tets::SurfaceChange& change) { return clearance.is_clear(change); };
  if (freedom.input().model) surface.project = make_projector(*freedom.input().model);
  improve_surface(mesh, surface, options, report, runner);
  return triangles;
}

}  // namespace tetloom::volume
