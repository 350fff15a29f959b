// Loose faces to shells, closed shells to solids.
#include <algorithm>
#include <Bnd_Box.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepClass3d_SolidClassifier.hxx>
#include <BRepLib.hxx>
#include <BRepTools_ReShape.hxx>
#include <Geom_Curve.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopTools_DataMapOfShapeShape.hxx>

#include "core/cad/detail/faults.hpp"
#include "core/cad/detail/healing.hpp"
#include "core/cad/detail/occt_guard.hpp"

namespace tetloom::cad {
namespace {

/// Gaps between loose faces up to this share of the model's diagonal are sewn up.
constexpr double kSewingGap = 1e-5;

TopoDS_Compound compound_of(const std::vector<TopoDS_Shape>& shapes) {
  TopoDS_Compound result;
  BRep_Builder builder;
  builder.MakeCompound(result);
  for (const TopoDS_Shape& shape : shapes) builder.Add(result, shape);
  return result;
}

/// Shells outside solids, and faces outside shells.
std::vector<Body> collect_loose(const Document& document) {
  std::vector<Body> bodies = collect_bodies(document.root, document.attributes);
  std::erase_if(bodies, [](const Body& body) { return body.shape.ShapeType() == TopAbs_SOLID; });
  return bodies;
}

/// Takes the loose pieces out of compounds and remembers what became of those.
class LooseRemover {
 public:
  TopoDS_Shape remove(const TopoDS_Shape& shape) {
    if (shape.ShapeType() == TopAbs_SHELL || shape.ShapeType() == TopAbs_FACE) return {};
    if (shape.ShapeType() != TopAbs_COMPOUND) return shape;
    std::vector<TopoDS_Shape> kept;
    bool changed = false;
    for (TopoDS_Iterator child(shape); child.More(); child.Next()) {
      const TopoDS_Shape next = remove(child.Value());
      if (!next.IsNull()) kept.push_back(next);
      if (next.IsNull() || !next.IsEqual(child.Value())) changed = true;
    }
    if (!changed) return shape;
    const TopoDS_Shape result = kept.empty() ? TopoDS_Shape() : TopoDS_Shape(compound_of(kept));
    replaced_.Bind(shape, result);
    return result;
  }

  /// Null when nothing of the shape is left.
  TopoDS_Shape successor(const TopoDS_Shape& shape) const {
    const TopoDS_Shape* found = replaced_.Seek(shape);
    return found ? *found : shape;
  }

 private:
  TopTools_DataMapOfShapeShape replaced_;
};

double sewing_tolerance(const TopoDS_Shape& shape) {
  Bnd_Box box;
  BRepBndLib::Add(shape, box, false);
  return std::max(Precision::Confusion(), kSewingGap * std::sqrt(box.SquareExtent()));
}

std::vector<TopoDS_Shape> pieces_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> result;
  for (TopExp_Explorer shell(shape, TopAbs_SHELL); shell.More(); shell.Next()) result.push_back(shell.Current());
  for (TopExp_Explorer face(shape, TopAbs_FACE, TopAbs_SHELL); face.More(); face.Next())
    result.push_back(face.Current());
  return result;
}

/// Works for single faces, such as spheres, as well.
TopoDS_Solid solid_of(const TopoDS_Shape& closed_piece) {
  TopoDS_Solid solid;
  TopoDS_Shell shell;
  BRep_Builder builder;
  if (closed_piece.ShapeType() == TopAbs_SHELL) {
    shell = TopoDS::Shell(closed_piece);
  } else {
    builder.MakeShell(shell);
    builder.Add(shell, closed_piece);
  }
  builder.MakeSolid(solid);
  builder.Add(solid, shell);
  BRepLib::OrientClosedSolid(solid);
  return solid;
}

/// Its vertices, and points between them on its edges.
std::vector<gp_Pnt> points_of(const TopoDS_Shape& shape) {
  std::vector<gp_Pnt> points;
  TopTools_IndexedMapOfShape vertices, edges;
  TopExp::MapShapes(shape, TopAbs_VERTEX, vertices);
  TopExp::MapShapes(shape, TopAbs_EDGE, edges);
  for (int i = 1; i <= vertices.Extent(); ++i) points.push_back(BRep_Tool::Pnt(TopoDS::Vertex(vertices(i))));
  for (int i = 1; i <= edges.Extent(); ++i) {
    double first, last;
    const Handle(Geom_Curve) curve = BRep_Tool::Curve(TopoDS::Edge(edges(i)), first, last);
    if (curve.IsNull()) continue;
    for (const double share : {0.25, 0.5, 0.75}) points.push_back(curve->Value(first + share * (last - first)));
  }
  return points;
}

/// Solids from closed shells by even and odd depth of nesting: a shell in a solid is its cavity, a shell in that
/// cavity a solid again.
class ShellNest {
 public:
  explicit ShellNest(const std::vector<TopoDS_Shape>& shells) {
    for (const TopoDS_Shape& shell : shells) {
      solids_.push_back(solid_of(shell));
      BRepBndLib::Add(solids_.back(), boxes_.emplace_back(), false);
    }
    inside_.resize(solids_.size());
    for (std::size_t i = 0; i < solids_.size(); ++i)
      for (std::size_t j = 0; j < solids_.size(); ++j)
        if (i != j && lies_in(i, j)) inside_[i].push_back(j);
  }

  std::vector<TopoDS_Shape> solids() const {
    std::vector<TopoDS_Shape> result;
    for (std::size_t i = 0; i < solids_.size(); ++i)
      if (inside_[i].size() % 2 == 0) result.push_back(with_cavities(i));
    return result;
  }

 private:
  // Wholly: of shells that cross each other each is the outside of a solid of its own.
  bool lies_in(std::size_t inner, std::size_t outer) const {
    const std::vector<gp_Pnt> points = points_of(solids_[inner]);
    if (points.empty() || boxes_[outer].IsOut(boxes_[inner])) return false;
    return all_are(TopAbs_IN, points, outer) && all_are(TopAbs_OUT, points_of(solids_[outer]), inner);
  }

  bool all_are(TopAbs_State state, const std::vector<gp_Pnt>& points, std::size_t solid) const {
    BRepClass3d_SolidClassifier classifier(solids_[solid]);
    return std::all_of(points.begin(), points.end(), [&](const gp_Pnt& point) {
      if (boxes_[solid].IsOut(point)) return state == TopAbs_OUT;
      classifier.Perform(point, Precision::Confusion());
      return classifier.State() == state;
    });
  }

  TopoDS_Shape with_cavities(std::size_t outer) const {
    TopoDS_Solid solid = solids_[outer];
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const bool direct = inside_[i].size() == inside_[outer].size() + 1 &&
                          std::find(inside_[i].begin(), inside_[i].end(), outer) != inside_[i].end();
      if (!direct) continue;
      for (TopoDS_Iterator shell(solids_[i]); shell.More(); shell.Next())
        BRep_Builder().Add(solid, shell.Value().Reversed());
    }
    return solid;
  }

  std::vector<TopoDS_Solid> solids_;
  std::vector<Bnd_Box> boxes_;
  std::vector<std::vector<std::size_t>> inside_;
};

/// The loose pieces as they are sewn, and how to find an old face among the new ones.
struct SewnPieces {
  std::vector<TopoDS_Shape> shapes;
  Handle(BRepTools_ReShape) context = new BRepTools_ReShape;
  std::size_t closed_edges = 0;
};

SewnPieces sew(const std::vector<Body>& loose, double tolerance, const CancelToken* cancel) {
  std::vector<TopoDS_Shape> pieces;
  for (const Body& body : loose) pieces.push_back(body.shape);
  SewnPieces result{pieces};
  const std::size_t open_before = find_open_edges(compound_of(pieces)).size();
  if (pieces.size() < 2 || open_before == 0) return result;
  BRepBuilderAPI_Sewing sewing(tolerance);
  for (const TopoDS_Shape& piece : pieces) sewing.Add(piece);
  Handle(CancelIndicator) indicator = new CancelIndicator(cancel);
  sewing.Perform(Message_ProgressIndicator::Start(indicator));
  if (cancel) cancel->check();
  if (sewing.SewedShape().IsNull()) return result;
  const std::size_t open_after = find_open_edges(sewing.SewedShape()).size();
  if (open_after >= open_before) return result;
  return {pieces_of(sewing.SewedShape()), sewing.GetContext(), open_before - open_after};
}

/// Gives the new faces and bodies what the old pieces had or inherited.
void inherit(const std::vector<Body>& loose, const Handle(BRepTools_ReShape) & context,
             const std::vector<TopoDS_Shape>& bodies, AttributeMap& attributes) {
  TopTools_DataMapOfShapeInteger face_to_body;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (TopExp_Explorer face(bodies[i], TopAbs_FACE); face.More(); face.Next())
      face_to_body.Bind(face.Current(), static_cast<int>(i));
  for (const Body& piece : loose) {
    for (TopExp_Explorer old_face(piece.shape, TopAbs_FACE); old_face.More(); old_face.Next()) {
      const TopoDS_Shape face = context->Apply(old_face.Current());
      if (face.IsNull()) continue;
      ShapeAttributes of_face = piece.attributes;
      of_face.name.clear();
      of_face.is_part = false;
      add_attributes(attributes, face, of_face);
      if (const int* body = face_to_body.Seek(face))
        add_attributes(attributes, bodies[static_cast<std::size_t>(*body)], piece.attributes);
    }
  }
}

}  // namespace

void sew_loose_faces(Document& document, std::vector<HealingStep>& steps, const CancelToken* cancel) {
  const std::vector<Body> loose = collect_loose(document);
  if (loose.empty()) return;
  const SewnPieces sewn = sew(loose, sewing_tolerance(document.root), cancel);
  std::vector<TopoDS_Shape> closed, open;
  for (const TopoDS_Shape& piece : sewn.shapes) (find_open_edges(piece).empty() ? closed : open).push_back(piece);
  if (closed.empty() && sewn.closed_edges == 0) return;
  std::vector<TopoDS_Shape> bodies = ShellNest(closed).solids();
  add_step(steps, "free edges of loose faces were sewn together", sewn.closed_edges);
  add_step(steps, "solids were made of closed shells", bodies.size());
  bodies.insert(bodies.end(), open.begin(), open.end());

  LooseRemover remover;
  std::vector<TopoDS_Shape> everything = bodies;
  if (const TopoDS_Shape rest = remover.remove(document.root); !rest.IsNull())
    everything.insert(everything.begin(), rest);
  replace_shapes(document, compound_of(everything), [&](const TopoDS_Shape& shape) -> std::vector<TopoDS_Shape> {
    const TopoDS_Shape next =
        shape.ShapeType() == TopAbs_COMPOUND ? remover.successor(shape) : sewn.context->Apply(shape);
    if (next.IsNull()) return {};
    return {next};
  });
  inherit(loose, sewn.context, bodies, document.attributes);
}

}  // namespace tetloom::cad
