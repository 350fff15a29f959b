#pragma once
// Repairing one face apart from its neighbours, so that the faces of a body can be repaired side by side. Private to
// core/cad.
#include <BRepTools_ReShape.hxx>
#include <NCollection_IndexedDataMap.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Face.hxx>
#include <TopTools_ShapeMapHasher.hxx>

namespace tetloom::cad {

/// How accurate the file says that its shapes are, and the largest tolerance that a repair may set. Model units.
struct FixPrecision {
  double precision = 0, largest = 0;
};

/// A copy of a face with edges and vertices of its own; curves and surfaces are shared with the original.
/// ShapeFix may change the copy while other threads read or copy the original.
class IsolatedFace {
 public:
  /// Copies what `face` (forward, without location) consists of.
  explicit IsolatedFace(const TopoDS_Face& face);

  /// Gives the copy what it lacks: parameter curves, seams, degenerate edges, order and direction of its wires,
  /// tolerances. False when the result is invalid or when it needs other edges and vertices than the original has.
  bool fix(const FixPrecision& precision);

  /// Carries the result of fix() over to the original: parameter curves and tolerances to its edges and vertices, and
  /// a face with other wires to `context`. Not safe while others use faces that share edges.
  void put_back(BRepTools_ReShape& context) const;

 private:
  using Copies = NCollection_IndexedDataMap<TopoDS_Shape, TopoDS_Shape, TopTools_ShapeMapHasher>;

  TopoDS_Shape copy_children(const TopoDS_Shape& shape);
  TopoDS_Shape copy_once(const TopoDS_Shape& shape, Copies& known);
  void drop_other_curves(const TopoDS_Edge& edge) const;
  bool fits_back() const;

  TopoDS_Face original_, copy_, fixed_;
  Copies edges_, vertices_;  ///< the copies, or what fix() made of them, by what they are copies of
  bool portable_ = true;     ///< whether nothing inside has a location
};

}  // namespace tetloom::cad
