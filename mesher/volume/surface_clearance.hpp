#pragma once
// Keeps a changing surface from crossing itself where no tets lie between: across gaps and holes.
#include <cstdint>
#include <span>
#include <vector>

#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/tets/surface_geometry.hpp"
#include "mesher/volume/complex.hpp"

namespace tetloom::volume {

/// Asked change by change; one per task. Refers to its arguments: the complex and the tree over it as they were,
/// `triangles` as they are.
class SurfaceClearance {
 public:
  SurfaceClearance(const Complex& complex, const intersection::TriangleTree& tree,
                   std::span<const tets::TriangleVerts> triangles, std::span<const std::uint32_t> tri_to_face)
      : complex_(complex), tree_(tree), triangles_(triangles), tri_to_face_(tri_to_face) {}

  /// Whether the changed triangles meet none of the others, in exact arithmetic. Neighbours in the same model face are
  /// not looked at, nor is anything where regions lie on both sides. A change that is clear is taken as made.
  bool is_clear(const tets::SurfaceChange& change);

 private:
  bool meets(const tets::SurfaceChange& change, std::uint32_t other) const;
  void note(const tets::SurfaceChange& change);

  const Complex& complex_;
  const intersection::TriangleTree& tree_;
  std::span<const tets::TriangleVerts> triangles_;
  std::span<const std::uint32_t> tri_to_face_;
  double farthest_ = 0;          // that a point has moved
  std::vector<Box3> own_boxes_;  // of the change that is asked about
  struct Swapped {
    Box3 box;  // as its points were in the tree
    std::uint32_t triangle;
  };
  std::vector<Swapped> swapped_;  // triangles with other vertices than in the tree
};

}  // namespace tetloom::volume
