#include "mesher/surface_input.hpp"

namespace tetloom {
namespace {

std::vector<FaceSides> sides_of(const Mesh& mesh, const ModelTopology& topology) {
  std::vector<FaceSides> sides(mesh.tri_to_vert.size());
  for (std::size_t t = 0; t < sides.size(); ++t) sides[t] = topology.face_to_sides[mesh.tri_to_entity[t]];
  return sides;
}

}  // namespace

template <class T>
SurfaceInput::Lent<T>::Lent(std::vector<T>& from, const KeepBytes& keep)
    : home(from), kept(keep(std::as_bytes(std::span<const T>(from)))), values(from) {}

template <class T>
void SurfaceInput::Lent<T>::leave_home() {
  if (!kept) return;
  values = {reinterpret_cast<const T*>(kept.get()), home.size()};
  home = std::vector<T>();
}

template <class T>
void SurfaceInput::Lent<T>::give_back() {
  if (kept) home.assign(values.begin(), values.end());
}

SurfaceInput::SurfaceInput(Mesh& mesh, const ModelTopology& topology, const KeepBytes& keep)
    : mesh_(mesh),
      sides_(sides_of(mesh, topology)),
      points_(mesh.points, keep),
      point_to_entity_(mesh.point_to_entity, keep),
      edge_to_vert_(mesh.edge_to_vert, keep),
      tri_to_vert_(mesh.tri_to_vert, keep),
      tri_to_entity_(mesh.tri_to_entity, keep) {
  // Not before all are kept: what is thrown meanwhile finds the mesh as it was.
  sides_.move_to(keep);
  points_.leave_home();
  point_to_entity_.leave_home();
  edge_to_vert_.leave_home();
  tri_to_vert_.leave_home();
  tri_to_entity_.leave_home();
}

SurfaceInput::~SurfaceInput() {
  try {
    points_.give_back();
    point_to_entity_.give_back();
    edge_to_vert_.give_back();
    tri_to_vert_.give_back();
    tri_to_entity_.give_back();
  } catch (const std::bad_alloc&) {
    mesh_ = Mesh();
  }
}

VolumeInput SurfaceInput::input(const GeometricModel& model, const SizeField& sizes) const {
  return {points_.values, tri_to_vert_.values,     sides_.span(),       tri_to_entity_.values, &model,
          &sizes,         point_to_entity_.values, edge_to_vert_.values};
}

}  // namespace tetloom
