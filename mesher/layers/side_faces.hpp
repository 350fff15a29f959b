#pragma once
// Faces beside walls, such as inlets and symmetry planes: growth curves on their rim stay on them, and layers stand on
// them.
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "mesher/layers/side_shape.hpp"
#include "mesher/layers/walls.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::layers {

/// The top of a growth curve.
struct CurveTop {
  Vec3 point;
  double thickness = 0;  ///< straight from the foot
  bool grows = false;    ///< has layers at all
};

/// Where a growth curve has come to on its side faces.
struct SidePlace {
  Vec3 point;
  Vec3 normal;  ///< of the side face, of length 1
  Vec3 along;   ///< where the curve runs along a model edge, its direction, of length 1; else zero
  Vec2 uv;      ///< in the side face's parameters
};

/// A side face bounds one region alone. Its model edges are its rim, or seams.
struct SideFace {
  SideShape shape;
  bool is_usable = true;
  std::vector<std::uint32_t> triangles;
  std::vector<RimPiece> rim;          ///< ascending by vertices
  std::vector<std::uint32_t> curves;  ///< ascending, each once
};

/// What a growth curve has to do with side faces.
struct CurveSides {
  std::uint32_t curve = 0;
  bool is_blocked = false;     ///< layers would stand on what is no side face, or take too much of a model edge
  std::uint8_t count = 0;      ///< of different side faces, 1 or 2
  bool is_along_edge = false;  ///< of the model: between two side faces, or a seam of one
  std::array<std::uint32_t, 2> sides{kNone, kNone};
  Vec3 into;               ///< from the rim of walls into the side faces, each triangle there by 1
  Vec3 along;              ///< of length 1, at the foot, along the edge
  double room = HUGE_VAL;  ///< the longest straight way along the edge
  ModelEntity edge;
  std::uint32_t next = kNone;        ///< the vertex behind the foot along the edge
  std::vector<std::uint32_t> chain;  ///< vertices of the edge behind the foot, without its end
};

/// Refers to its arguments.
class SideFaces {
 public:
  /// Errors: Cancelled.
  SideFaces(const GeometricModel& model, const Mesh& mesh, const Walls& walls, const TaskRunner& runner);

  /// Curves that have to do with side faces, ascending.
  std::span<const CurveSides> curves() const { return curves_; }
  /// Of `curves`; null for the others.
  const CurveSides* at(std::uint32_t curve) const {
    return curve_to_sides_[curve] == kNone ? nullptr : &curves_[curve_to_sides_[curve]];
  }
  /// The index in `curves`, or none.
  std::uint32_t index_of(std::uint32_t curve) const { return curve_to_sides_[curve]; }
  bool is_along_edge(std::uint32_t curve) const { return at(curve) && at(curve)->is_along_edge; }
  /// What points on the curve lie on: a model edge, a side face or the region.
  ModelEntity entity_of(std::uint32_t curve) const;
  /// Pieces of model edges that the curve's layers take the place of: their vertices behind the foot, in their order.
  /// The last one's next vertex is joined to the top.
  std::vector<std::uint32_t> dropped_by(std::uint32_t curve, const CurveTop& top) const;

  std::span<const SideFace> sides() const { return sides_; }
  /// The number of a face among `sides`, or none.
  std::uint32_t side_of(std::uint32_t face) const { return face_to_side_[face]; }
  const GeometricModel& model() const { return model_; }
  const Mesh& mesh() const { return mesh_; }
  const Walls& walls() const { return walls_; }

 private:
  void find_sides(const TaskRunner& runner);
  void judge(SideFace& side) const;
  void attach_curves();
  Vec3 into_side(const WallRim& rim) const;
  void attach(std::uint32_t curve, std::uint32_t side);
  void find_chain(CurveSides& curve);
  bool follow(CurveSides& curve, std::uint32_t next);
  void block_shared_chains();
  void block_ambiguous_feet();
  bool has_piece(const SideFace& side, std::uint32_t from, std::uint32_t to) const;
  std::vector<std::uint32_t> next_on_rim(const SideFace& side, std::uint32_t vert, bool forward) const;
  std::vector<std::uint32_t> edges_from(const CurveSides& at) const;

  const GeometricModel& model_;
  const Mesh& mesh_;
  const Walls& walls_;
  std::vector<std::array<std::uint32_t, 2>> pieces_;  // of model edges, smaller vertex first, ascending
  std::vector<std::uint32_t> face_to_side_;
  std::vector<std::uint8_t> is_foot_;  // per vertex
  std::vector<SideFace> sides_;
  std::vector<std::uint32_t> curve_to_sides_;
  std::vector<CurveSides> curves_;
};

/// Puts points of growth curves on side faces and model edges. For one task; refers to the side faces.
class SideProjector {
 public:
  explicit SideProjector(const SideFaces& sides) : sides_(sides), faces_(sides.sides().size()) {}

  /// Where the curve stands on its side faces at its foot. Pre: it has some and is not blocked.
  SidePlace at_foot(const CurveSides& curve);
  /// The point of the side faces, or of the model edge, that is near to `x`, coming from another place of the curve.
  SidePlace put(const CurveSides& curve, const Vec3& x, const SidePlace& from);

 private:
  FaceGeometry& face(std::uint32_t side);
  EdgeGeometry& edge(std::uint32_t edge);
  SidePlace put_on_edge(const CurveSides& curve, const Vec3& x, const SidePlace& from);

  const SideFaces& sides_;
  std::vector<std::unique_ptr<FaceGeometry>> faces_;
  std::map<std::uint32_t, std::unique_ptr<EdgeGeometry>> edges_;
};

/// The direction that is nearest to the given one and stays on the side faces, of length 1.
inline Vec3 constrained(const SidePlace& place, const Vec3& direction) {
  if (place.along != Vec3{}) return place.along;
  return normalized(direction - dot(direction, place.normal) * place.normal);
}

}  // namespace tetloom::layers
