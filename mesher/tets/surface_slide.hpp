#pragma once
// Slides vertices of the surface within their model face or along their model edge, so that the tets around them become
// better: one damped Newton step in the tangent plane or along the tangent on the sum of 1/q^3, as newton_smoothing.hpp
// does inside, led back to the model.
#include <vector>

#include "core/tets/star_tet.hpp"
#include "core/tets/vertex_star.hpp"
#include "mesher/tets/surface_geometry.hpp"

namespace tetloom::tets {

/// In the order in which a vertex is asked.
enum class SlideVerdict {
  Stays,     ///< it is not inside of a model face or edge, or its triangles do not belong there
  TooLarge,  ///< more than WorkingMesh::kMostTets tets
  NoGain,    ///< no place raises the minimum, or lowers the sum and keeps the minimum, without more poor tets
  OffModel,  ///< the model gives no answer for places that do, or one far away
  Folds,     ///< they would turn a triangle against the model, make it poor, leave the model edge or meet others
  Moved
};

/// Collects the tets on both sides at corner `corner` of `tet`. TooLarge or Found.
StarVerdict find_surface_star(const WorkingMesh& mesh, std::uint32_t tet, std::uint32_t corner, VertexStar& star);

/// Holds the room that one slide needs.
class SurfaceSlider {
 public:
  /// Tets of cubed quality below `limit` count as poor.
  SurfaceSlider(WorkingMesh& mesh, const ChangeableSurface& surface, const SurfaceTriangles& triangles, double limit)
      : mesh_(mesh), surface_(surface), triangles_(triangles), limit_(limit) {}

  /// Moves the vertex at `corner` of `tet`; the tets at it stay positive in exact arithmetic. Nothing changes unless
  /// the verdict is Moved.
  SlideVerdict slide(std::uint32_t tet, std::uint32_t corner);

  /// Moves it to where the smallest dihedral angle of the tets at it is larger; see angle_search.hpp. No tet of a cubed
  /// quality below `least` comes of it, and the sum of the squares of the surface's edges at the vertex, as which its
  /// sag grows, becomes `growth` times what it was at most.
  SlideVerdict slide_for_angle(std::uint32_t tet, std::uint32_t corner, double least, double growth);

 private:
  /// Finds what is at the vertex; Moved: all is there.
  SlideVerdict collect(std::uint32_t tet, std::uint32_t corner);
  struct Worth {
    double sum = 0, least = 0;  // of 1/q^3 and of q^3; 0 when a tet is not surely positive
    int poor = 0;
    bool beats(const Worth& other) const;
  };
  struct FanTriangle {
    std::uint32_t a, b, face;  // the edge opposite to the vertex, the model face
  };

  bool collect_fan(std::uint32_t vertex);
  bool collect_kept(std::uint32_t vertex);
  void measure();
  Worth worth_at(const Vec3& d) const;
  Vec3 newton_step(const Vec3& direction) const;
  Vec3 step_along(const Vec3& tangent) const;
  Vec3 step_across(const Vec3& normal) const;
  Vec3 direction() const;
  double poorest_triangle(const Vec3& x) const;
  double least_cosine(const Vec3& x) const;
  double sag(const Vec3& x) const;
  bool keeps_shape(const Vec3& from, const Vec3& to, double triangle_floor) const;
  bool is_clear_at(const Vec3& to);
  SlideVerdict search();
  double squared_edges(const Vec3& x) const;
  Vec3 widest_step(const Vec3& direction, double goal, double growth);
  void apply(const Vec3& to);

  WorkingMesh& mesh_;
  const ChangeableSurface& surface_;
  const SurfaceTriangles& triangles_;
  double limit_;
  ModelEntity entity_;
  VertexStar star_;
  std::array<StarTet, WorkingMesh::kMostTets> tets_;
  std::vector<FanTriangle> fan_;
  std::vector<std::uint32_t> fan_ids_;
  std::vector<TriangleVerts> fan_verts_;
  std::vector<std::uint32_t> kept_;  // neighbours along the model edge
  double reach_ = 0;  // mean length of the edges in the model face, shortest of those along the model edge
};

}  // namespace tetloom::tets
