#pragma once
// What a side face looks like, and where its points lie in a plane in which it can be meshed.
#include <array>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "mesher/layers/side_plane.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"

namespace tetloom::layers {

/// In which plane a side face is meshed.
enum class SideKind : std::uint8_t {
  Flat,        ///< it is one
  Parametric,  ///< that of its (u,v)
  Upright      ///< a plane over which it stands, where its (u,v) are of no use
};

/// How points are put on a side face.
struct SideShape {
  SideKind kind = SideKind::Flat;
  SidePlane plane;  ///< unless parametric
  ModelFaceId face;

  /// What puts points on the face. For one task.
  std::unique_ptr<FaceGeometry> make_geometry(const GeometricModel& model) const {
    return kind == SideKind::Flat ? layers::make_geometry(plane) : model.face_geometry(face);
  }
};

/// Finds the places of mesh vertices in the plane of a side face. A vertex on a seam, or at a pole, has several places:
/// that in a triangle is the one beside the middle of the triangle. For one task; refers to its arguments.
class SidePlacer {
 public:
  SidePlacer(const GeometricModel& model, const Mesh& mesh, const SideShape& shape, FaceGeometry& geometry);

  /// The places of the corners.
  std::array<Vec2, 3> corners(std::uint32_t triangle);
  /// The place of any point on the face that lies beside another place.
  Vec2 beside(const Vec2& place, const Vec3& x);
  bool is_pole(std::uint32_t vert) const { return poles_of(vert) != nullptr; }
  /// How far vertices asked for so far lie from the face, at most.
  double distance() const { return distance_; }

 private:
  const std::vector<Vec2>* poles_of(std::uint32_t vert) const;
  void find_poles(const GeometricModel& model);
  Vec2 near(const Vec2& place, Vec2 uv) const;

  const Mesh& mesh_;
  const SideShape& shape_;
  FaceGeometry& geometry_;
  ParameterBox box_;
  Vec2 period_;
  double distance_ = 0;
  std::unordered_map<std::uint32_t, std::vector<Vec2>> pole_to_places_;  // by model vertex; looked up only
  std::unordered_map<std::uint32_t, Vec2> known_;                        // looked up only
};

/// A piece of the rim, with the face on its left, in space and in the plane. Both sides of a seam are part of the rim.
struct RimPiece {
  std::array<std::uint32_t, 2> verts{};
  std::array<Vec2, 2> places;
};

/// The rim of a face of these triangles, ascending by vertices. `edges` are the pieces of model edges in the mesh,
/// smaller vertex first, ascending. Empty where the places are of no use: where a triangle beside the rim is turned
/// over in the plane, where a model edge within the face is no seam, or where the mesh is beside the face.
std::vector<RimPiece> find_rim(const Mesh& mesh, std::span<const std::uint32_t> triangles,
                               std::span<const std::array<std::uint32_t, 2>> edges, SidePlacer& placer);

}  // namespace tetloom::layers
