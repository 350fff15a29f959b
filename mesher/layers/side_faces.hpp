#pragma once
// Faces beside walls, such as inlets and symmetry planes: growth curves on their rim stay on them, layers stand on
// them, and the rest of such a face is meshed anew inside of the layers' top.
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "mesher/layers/side_plane.hpp"
#include "mesher/layers/walls.hpp"
#include "mesher/surface/face_mesher.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom::layers {

/// The top of a growth curve.
struct CurveTop {
  Vec3 point;
  double thickness = 0;  ///< straight from the foot
  bool grows = false;    ///< has layers at all
};

/// A side face with its mesh above the layers. A vertex of `mesh` that is not inside of the face is an index of
/// `nodes`.
struct SideMesh {
  struct Node {
    std::uint32_t vert = kNone;   ///< of the given mesh
    std::uint32_t curve = kNone;  ///< else: the top of this curve
  };
  std::uint32_t face = 0;
  FaceMesh mesh;
  std::vector<Node> nodes;
};

/// Refers to its arguments. A side face is flat, bounds one region alone, and has no edges inside.
class SideFaces {
 public:
  SideFaces(const Mesh& mesh, std::span<const FaceSides> face_to_sides, const Walls& walls);

  /// Whether layers at the curve would stand on something that is no side face, or take away more of a model edge than
  /// can be.
  bool is_blocked(std::uint32_t curve) const { return curves_[curve].blocked; }
  /// The longest straight way that a curve along a model edge has; else infinite.
  double room(std::uint32_t curve) const { return curves_[curve].room; }
  /// Side faces at a curve: 0, 1, or 2 where it runs along the model edge between them.
  int count(std::uint32_t curve) const { return curves_[curve].count; }
  /// The direction that is nearest to the given one and stays on the side faces, of length 1.
  Vec3 constrain(std::uint32_t curve, const Vec3& direction) const;
  /// The point that is nearest to the given one and lies on the side faces.
  Vec3 put(std::uint32_t curve, const Vec3& x) const;
  /// What points on the curve lie on: a model edge, a side face or the region.
  ModelEntity entity_of(std::uint32_t curve) const;

  std::size_t side_count() const { return sides_.size(); }
  std::uint32_t face_of(std::size_t side) const { return sides_[side].face; }
  std::span<const std::uint32_t> curves_on(std::size_t side) const { return sides_[side].curves; }

  /// Meshes the rest of a side face. The verdict of the mesh says whether that was possible.
  SideMesh mesh_rest(std::size_t side, std::span<const CurveTop> tops, const SizeField& sizes,
                     const std::function<bool()>& keep_going) const;
  /// Pieces of model edges that the curve's layers take the place of: their vertices behind the foot, in their order.
  /// The last one's next vertex is joined to the top.
  std::vector<std::uint32_t> dropped_by(std::uint32_t curve, const CurveTop& top) const;

 private:
  using HalfEdge = std::array<std::uint32_t, 2>;

  struct Side {
    std::uint32_t face = 0;
    bool is_usable = true;
    SidePlane plane;
    std::vector<std::uint32_t> triangles;
    std::vector<HalfEdge> rim;          // half-edges of the boundary, ascending
    std::vector<std::uint32_t> curves;  // ascending, each once
  };
  struct CurveSides {
    bool blocked = false;
    std::uint8_t count = 0;
    std::array<std::uint32_t, 2> sides{kNone, kNone};
    Vec3 along;  // of length 1, where there are two
    double room = HUGE_VAL;
    ModelEntity edge;                  // where there are two
    std::vector<std::uint32_t> chain;  // vertices of the model edge behind the foot, without its end
  };

  void find_sides();
  void judge(Side& side) const;
  void find_rim(Side& side) const;
  bool has_edges_inside(const Side& side) const;
  void attach_curves();
  void attach(std::uint32_t curve, std::uint32_t side);
  void find_chain(std::uint32_t curve);
  bool follow(std::uint32_t curve, std::uint32_t next, bool forward);
  void block_shared_chains();
  void drop_ambiguous_feet();
  bool has_half_edge(const Side& side, std::uint32_t from, std::uint32_t to) const;
  std::vector<std::uint32_t> neighbours(const Side& side, std::uint32_t vert, bool forward) const;

  const Mesh& mesh_;
  std::span<const FaceSides> face_to_sides_;
  const Walls& walls_;
  std::vector<std::uint32_t> face_to_side_;
  std::vector<std::uint8_t> is_foot_;  // per vertex
  std::vector<Side> sides_;
  std::vector<CurveSides> curves_;
};

}  // namespace tetloom::layers
