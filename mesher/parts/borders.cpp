#include "mesher/parts/borders.hpp"

#include <algorithm>

#include "core/base/mix_bits.hpp"
#include "mesher/tets/triangle_verts.hpp"

namespace tetloom::parts {

namespace {

using tets::FaceCode;
using tets::TetMesh;

constexpr double kReachInEdges = 6;

std::uint64_t name_of(std::array<VertKey, 3> keys) {
  std::sort(keys.begin(), keys.end());
  std::uint64_t name = 0;
  for (const VertKey key : keys) name = mix_bits(name * 0x9e3779b97f4a7c15u + key);
  return name;
}

}  // namespace

void name_open_faces(PartState& state) {
  const TetMesh& mesh = state.mesh;
  state.open_names.clear();
  for (const FaceCode face : state.open_faces) {
    const auto [a, b, c] = verts_of(mesh, face);
    state.open_names.push_back(name_of({state.keys[a], state.keys[b], state.keys[c]}));
  }
}

std::vector<std::uint64_t> open_faces_near(const PartState& state, const Box3& box) {
  const TetMesh& mesh = state.mesh;
  std::vector<std::uint64_t> near;
  for (std::size_t i = 0; i < state.open_faces.size(); ++i) {
    const auto [a, b, c] = verts_of(mesh, state.open_faces[i]);
    const double length = std::max(distance(mesh.points[a], mesh.points[b]), distance(mesh.points[a], mesh.points[c]));
    if (distance_outside(mesh.points[a], box) <= kReachInEdges * length) near.push_back(state.open_names[i]);
  }
  return near;
}

void check_open_faces(PartState& state, std::span<const std::span<const std::uint64_t>> told) {
  std::sort(state.open_names.begin(), state.open_names.end());
  std::vector<std::uint8_t> met(state.open_names.size(), 0);
  for (const auto& names : told) {
    for (const std::uint64_t name : names) {
      const auto at = std::lower_bound(state.open_names.begin(), state.open_names.end(), name);
      if (at == state.open_names.end() || *at != name) continue;
      std::uint8_t& count = met[static_cast<std::size_t>(at - state.open_names.begin())];
      count = static_cast<std::uint8_t>(std::min(2, count + 1));
    }
  }
  for (std::size_t i = 0; i < met.size(); ++i) {
    if (met[i] == 0) state.unmet_names.push_back(state.open_names[i]);
    if (met[i] > 1) state.fault.message = "three parts have the same face";
  }
}

}  // namespace tetloom::parts
