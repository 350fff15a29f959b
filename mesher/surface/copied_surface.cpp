#include "mesher/surface/copied_surface.hpp"

#include <algorithm>
#include <utility>

#include "core/sizing/size_change.hpp"
#include "mesher/complexes.hpp"

namespace tetloom {
namespace {

// The partner of an edge; invalid where it has none.
ModelEdgeId partner(const CopiedComplex& copy, ModelEdgeId edge) {
  const auto found = std::ranges::lower_bound(copy.edges, edge, {}, &std::pair<ModelEdgeId, ModelEdgeId>::first);
  return found != copy.edges.end() && found->first == edge ? found->second : ModelEdgeId();
}

// Rim nodes of a complex to those of its copy.
class NodePairs {
 public:
  NodePairs(const CopiedComplex& copy, const RimNodes& rim) {
    for (const auto& [edge, other] : copy.edges)
      for (std::size_t i = 0; i < rim.mesh(edge).points.size(); ++i)
        pairs_.emplace_back(rim.node(edge, i), rim.node(other, i));
    std::ranges::sort(pairs_);
  }

  std::uint32_t operator()(std::uint32_t node) const {
    return std::ranges::lower_bound(pairs_, node, {}, &std::pair<std::uint32_t, std::uint32_t>::first)->second;
  }

 private:
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs_;
};

}  // namespace

CopiedSurface::CopiedSurface(const GeometricModel& model, const TaskRunner& runner)
    : model_(model),
      runner_(runner),
      copies_(find_copied_complexes(model, find_complexes(model.topology()))),
      is_carried_(copies_.size(), 1),
      face_to_copy_(model.topology().face_count(), kNone) {
  for (std::uint32_t c = 0; c < copies_.size(); ++c)
    for (const auto& pair : copies_[c].faces) face_to_copy_[pair.second.value] = c;
}

void CopiedSurface::carry_edges(const SizeField& sizes, std::vector<EdgeMesh>& edges) {
  const std::vector<char> before = is_carried_;
  runner_.for_each(copies_.size(), [&](std::size_t c) {
    is_carried_[c] = is_carried_[c] && has_same_edges(sizes, copies_[c], edges);
    if (is_carried_[c]) carry(copies_[c], edges);
  });
  release(before);
}

void CopiedSurface::carry_faces(const SizeField& sizes, const RimNodes& rim, std::vector<FaceMesh>& faces) {
  const std::vector<char> before = is_carried_;
  runner_.for_each(copies_.size(), [&](std::size_t c) {
    is_carried_[c] = is_carried_[c] && has_same_faces(sizes, copies_[c], faces);
    if (is_carried_[c]) carry(copies_[c], rim, faces);
  });
  release(before);
}

void CopiedSurface::release(const std::vector<char>& was_carried) {
  for (std::size_t c = 0; c < copies_.size(); ++c) {
    if (is_carried_[c] == was_carried[c]) continue;
    for (const auto& pair : copies_[c].faces) {
      face_to_copy_[pair.second.value] = kNone;
      released_.push_back(pair.second.value);
    }
  }
}

std::vector<std::size_t> CopiedSurface::take_released() {
  std::ranges::sort(released_);
  return std::exchange(released_, {});
}

// Nodes that the edge has from an edge of another complex are not the same in both places.
bool CopiedSurface::has_same_edges(const SizeField& sizes, const CopiedComplex& copy,
                                   const std::vector<EdgeMesh>& edges) const {
  return std::ranges::all_of(copy.edges, [&](const auto& pair) {
    const EdgeMesh& edge = edges[pair.first.value];
    if (edge.joined_to.valid() && !partner(copy, edge.joined_to).valid()) return false;
    return has_same_sizes(sizes, copy.motion, edge.points);
  });
}

bool CopiedSurface::has_same_faces(const SizeField& sizes, const CopiedComplex& copy,
                                   const std::vector<FaceMesh>& faces) const {
  return std::ranges::all_of(copy.faces, [&](const auto& pair) {
    const FaceMesh& face = faces[pair.first.value];
    return face.verdict == FaceVerdict::Ok && has_same_sizes(sizes, copy.motion, face.points);
  });
}

void CopiedSurface::carry(const CopiedComplex& copy, std::vector<EdgeMesh>& edges) const {
  for (const auto& [edge, other] : copy.edges) {
    EdgeMesh mesh = edges[edge.value];
    if (mesh.joined_to.valid()) mesh.joined_to = partner(copy, mesh.joined_to);
    for (Vec3& p : mesh.points) p = copy.motion(p);
    const auto [start, end] = model_.topology().edges[other.value].vertices;
    mesh.points.front() = model_.vertex_point(start);
    mesh.points.back() = model_.vertex_point(end);
    edges[other.value] = std::move(mesh);
  }
}

void CopiedSurface::carry(const CopiedComplex& copy, const RimNodes& rim, std::vector<FaceMesh>& faces) const {
  const NodePairs to_copy(copy, rim);
  for (const auto& [face, other] : copy.faces) {
    FaceMesh mesh = faces[face.value];
    for (Vec3& p : mesh.points) p = copy.motion(p);
    for (auto& triangle : mesh.tri_to_vert)
      for (std::uint32_t& v : triangle)
        if (!(v & FaceMesh::kInner)) v = to_copy(v);
    mesh.point = copy.motion(mesh.point);
    faces[other.value] = std::move(mesh);
  }
}

}  // namespace tetloom
