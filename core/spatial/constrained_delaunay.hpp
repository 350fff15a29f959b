#pragma once
// The constrained Delaunay triangulation of a polygonal domain in the plane, the starting point of a face's mesh.
//
// Points are inserted incrementally (Bowyer 1981, Watson 1981), missing segments are recovered by flips (Sloan 1993),
// and the outside is removed by the parity of the segments crossed. All decisions use exact predicates.
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/spatial/triangulation.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// Why a polygon cannot be triangulated.
enum class PolygonVerdict {
  Ok,
  DuplicatePoint,  ///< two points coincide: `first`, `second` are the points
  SegmentsCross,   ///< two segments cross: `first`, `second` are the segments
  PointOnSegment,  ///< a point lies on a segment: `first` is the segment, `second` the point
  NotClosed        ///< the segments do not separate inside from outside, or leave nothing inside
};

/// The triangulated polygon, or what is in the way.
struct PolygonTriangulation {
  PolygonVerdict verdict = PolygonVerdict::Ok;
  std::uint32_t first = 0, second = 0;
  Triangulation triangulation;  ///< the inside only; segments are fixed edges; vertices are the given points
};

/// Pre: `segments` index `points`. A segment given twice counts twice: both of its sides are alike.
PolygonTriangulation triangulate_polygon(std::span<const Vec2> points,
                                         std::span<const std::array<std::uint32_t, 2>> segments);

}  // namespace tetloom
