#include "mesher/volume/angle_causes.hpp"

#include <algorithm>
#include <cstdio>
#include <functional>
#include <map>
#include <utility>

#include "core/tets/triangle_verts.hpp"
#include "mesher/volume/volume_mesher.hpp"

namespace tetloom::volume {

namespace {

using tets::TriangleVerts;

// The model faces of the triangles that tets name; kNone for others.
class FaceFinder {
 public:
  FaceFinder(const VolumeInput& input, const Complex& complex, std::span<const TriangleVerts> tri_to_vert,
             const std::vector<AcuteTet>& tets) {
    for (const AcuteTet& tet : tets)
      for (const TriangleVerts& triangle : tet.triangles) to_face_[tets::sorted(triangle).verts] = kNone;
    for (std::size_t t = 0; !to_face_.empty() && t < tri_to_vert.size(); ++t) {
      const auto wanted = to_face_.find(tets::sorted(tri_to_vert[t]).verts);
      if (wanted != to_face_.end()) wanted->second = input.tri_to_face[complex.to_input_tri[t]];
    }
  }
  std::uint32_t face_of(const TriangleVerts& triangle) const { return to_face_.at(tets::sorted(triangle).verts); }

 private:
  std::map<TriangleVerts, std::uint32_t> to_face_;  // by ascending vertices
};

// The model edge on which two triangles meet: that of a common vertex, where one lies inside of an edge.
ModelEntity common_edge(const VolumeInput& input, const AcuteTet& tet) {
  if (tet.triangles.size() < 2 || input.point_to_entity.empty()) return {};
  ModelEntity edge;
  for (const std::uint32_t v : tet.triangles[0]) {
    if (std::ranges::find(tet.triangles[1], v) == tet.triangles[1].end()) continue;
    const ModelEntity entity = input.point_to_entity[v];
    if (entity.dim == 2) return {};
    if (entity.dim == 1) edge = entity;
  }
  return edge;
}

void add_entity(const VolumeInput& input, ModelEntity entity, AcuteTet& tet) {
  const auto is_same = [&](const NamedEntity& one) { return one.entity == entity; };
  if (entity.valid() && std::ranges::none_of(tet.entities, is_same))
    tet.entities.push_back(named_entity(input, entity));
}

}  // namespace

void name_causes(const VolumeInput& input, const Complex& complex, std::span<const TriangleVerts> tri_to_vert,
                 std::vector<AcuteTet>& tets) {
  const FaceFinder finder(input, complex, tri_to_vert, tets);
  for (AcuteTet& tet : tets) {
    for (TriangleVerts& triangle : tet.triangles) {
      add_entity(input, {2, finder.face_of(triangle)}, tet);
      for (std::uint32_t& v : triangle) v = complex.to_input_vert[v];
    }
    add_entity(input, common_edge(input, tet), tet);
    for (std::uint32_t& v : tet.points) {
      v = complex.to_input_vert[v];
      if (!input.point_to_entity.empty()) add_entity(input, input.point_to_entity[v], tet);
    }
    std::ranges::stable_sort(tet.entities, std::ranges::greater{},
                             [](const NamedEntity& one) { return std::pair(one.entity.dim, ~one.entity.index); });
  }
}

std::optional<Diagnostic> warn_of_flat_tets(const tets::OptimizeReport& report) {
  constexpr double kFlat = 1;  // degrees
  if (report.acute_tets.empty()) return {};
  const AcuteTet& worst = report.acute_tets.front();
  if (worst.angle >= kFlat || worst.cause == AngleCause::NotForced) return {};
  std::array<char, 160> text{};
  if (worst.cause_length > 0)
    std::snprintf(text.data(), text.size(), "the surface leaves flat tets, down to %.2g degrees: it is %.2g wide here",
                  worst.angle, worst.cause_length);
  else
    std::snprintf(text.data(), text.size(),
                  "the surface leaves flat tets, down to %.2g degrees: it has an angle of %.2g degrees here",
                  worst.angle, worst.cause_angle);
  return Diagnostic{ErrorCode::InputUnsuitable, text.data(), worst.entities, worst.point, {}};
}

}  // namespace tetloom::volume
