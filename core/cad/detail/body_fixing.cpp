#include "core/cad/detail/body_fixing.hpp"

#include <algorithm>
#include <BRep_Tool.hxx>
#include <memory>
#include <numeric>
#include <ShapeBuild_ReShape.hxx>
#include <ShapeFix_Face.hxx>
#include <ShapeFix_Shape.hxx>
#include <ShapeFix_Solid.hxx>
#include <ShapeFix_Wire.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopTools_DataMapOfShapeInteger.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include "core/cad/detail/healing.hpp"
#include "core/cad/detail/isolated_face.hpp"
#include "core/cad/detail/occt_guard.hpp"
#include "core/cad/detail/validity.hpp"

namespace tetloom::cad {
namespace {

TopoDS_Shape plain(const TopoDS_Shape& shape) { return shape.Located(TopLoc_Location()).Oriented(TopAbs_FORWARD); }

bool lacks_parameter_curves(const TopoDS_Face& face) {
  double first, last;
  for (TopExp_Explorer edge(face, TopAbs_EDGE); edge.More(); edge.Next())
    if (BRep_Tool::CurveOnSurface(TopoDS::Edge(edge.Current()), face, first, last).IsNull()) return true;
  return false;
}

class BodyFixer {
 public:
  BodyFixer(const std::vector<RawBody>& bodies, const CancelToken* cancel, const BlockLoop& loop)
      : cancel_(cancel), loop_(loop) {
    TopTools_IndexedMapOfShape known, faces;
    for (const RawBody& raw : bodies) {
      const TopoDS_Shape shape = plain(raw.shape);
      if (known.Add(shape) <= static_cast<int>(bodies_.size())) continue;
      Body& body = bodies_.emplace_back();
      body.before = shape;
      body.precision = raw.precision;
      for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
        add_face(TopoDS::Face(plain(face.Current())), faces);
    }
  }

  void fix() {
    context_->ModeConsiderLocation() = true;  // a body is one thing wherever it is placed
    fix_faces();
    for (std::size_t i = 0; i < bodies_.size(); ++i) replace(bodies_[i]);
    loop_.for_blocks(bodies_.size(), 1, [&](std::size_t i, std::size_t) { judge(bodies_[i]); });
    fix_whole_bodies();
  }

  void update(Document& document) {
    for (const Body& body : bodies_)
      if (body.valid) add_valid(body.after, document);
    if (!changed_) return;
    const TopoDS_Shape root = context_->Apply(document.root);
    replace_shapes(document, root, [&](const TopoDS_Shape& shape) { return successors(shape); });
  }

 private:
  struct Body {
    TopoDS_Shape before, after;
    TopoDS_Shape before_whole;  ///< with its faces completed, before it was repaired as a whole
    FixPrecision precision;
    std::vector<std::size_t> faces;
    bool valid = true;
    Handle(ShapeBuild_ReShape) context;  ///< of a body that was repaired as a whole
  };

  void add_face(const TopoDS_Face& face, TopTools_IndexedMapOfShape& known) {
    const std::size_t index = static_cast<std::size_t>(known.Add(face));
    if (index > faces_.size()) {
      faces_.push_back(face);
      precisions_.push_back(bodies_.back().precision);
    }
    bodies_.back().faces.push_back(index - 1);
  }

  void fix_faces() {
    std::vector<std::unique_ptr<IsolatedFace>> fixed(faces_.size());
    face_valid_.assign(faces_.size(), 0);
    for_each_face(faces_, loop_, [&](std::size_t i) {
      if (cancel_) cancel_->check();
      if (!lacks_parameter_curves(faces_[i]) && is_valid_face(faces_[i])) {
        face_valid_[i] = 1;
        return;
      }
      auto isolated = std::make_unique<IsolatedFace>(faces_[i]);
      if (!isolated->fix(precisions_[i])) return;
      face_valid_[i] = 1;
      fixed[i] = std::move(isolated);
    });
    for (const auto& face : fixed)
      if (face) face->put_back(*context_);
  }

  void replace(Body& body) {
    body.after = context_->Apply(body.before);
    if (!body.after.IsSame(body.before)) changed_ = true;
  }

  void judge(Body& body) const {
    for (const std::size_t face : body.faces) body.valid = body.valid && face_valid_[face];
    if (!body.valid) return;
    for (const TopoDS_Shape& part : distinct_bodies(body.after)) body.valid = body.valid && has_valid_shells(part);
  }

  // Bodies that share edges wait for each other.
  void fix_whole_bodies() {
    const std::vector<std::vector<std::size_t>> groups = invalid_groups();
    loop_.for_blocks(groups.size(), 1, [&](std::size_t i, std::size_t) {
      for (const std::size_t body : groups[i]) fix_whole(bodies_[body]);
    });
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const Body& body = bodies_[i];
      if (body.context.IsNull() || body.after.IsSame(body.before_whole)) continue;
      TopTools_IndexedMapOfShape parts;
      TopExp::MapShapes(body.before_whole, parts);
      for (int k = 2; k <= parts.Extent(); ++k) whole_.Bind(plain(parts(k)), static_cast<int>(i));
      context_->Replace(body.before, body.after);
      changed_ = true;
    }
  }

  std::vector<std::vector<std::size_t>> invalid_groups() const {
    std::vector<std::size_t> chief(bodies_.size());
    std::iota(chief.begin(), chief.end(), std::size_t{0});
    const auto find = [&](std::size_t i) {
      while (chief[i] != i) i = chief[i];
      return i;
    };
    TopTools_DataMapOfShapeInteger owner;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      if (bodies_[i].valid) continue;
      TopTools_IndexedMapOfShape vertices;
      TopExp::MapShapes(bodies_[i].after, TopAbs_VERTEX, vertices);
      for (int k = 1; k <= vertices.Extent(); ++k) {
        const TopoDS_Shape vertex = plain(vertices(k));
        if (const int* other = owner.Seek(vertex)) {
          const std::size_t a = find(static_cast<std::size_t>(*other)), b = find(i);
          chief[std::max(a, b)] = std::min(a, b);
        } else {
          owner.Bind(vertex, static_cast<int>(i));
        }
      }
    }
    std::vector<std::vector<std::size_t>> groups(bodies_.size());
    for (std::size_t i = 0; i < bodies_.size(); ++i)
      if (!bodies_[i].valid) groups[find(i)].push_back(i);
    std::erase_if(groups, [](const std::vector<std::size_t>& group) { return group.empty(); });
    return groups;
  }

  // As OpenCASCADE's STEP reader does it.
  void fix_whole(Body& body) const {
    if (cancel_) cancel_->check();
    try {
      const Handle(ShapeFix_Shape) fix = new ShapeFix_Shape(body.after);
      fix->SetPrecision(body.precision.precision);
      fix->SetMaxTolerance(body.precision.largest);
      fix->FixFaceTool()->FixWireTool()->FixSameParameterMode() = 0;
      fix->FixSolidTool()->CreateOpenSolidMode() = false;
      Handle(CancelIndicator) indicator = new CancelIndicator(cancel_);
      fix->Perform(Message_ProgressIndicator::Start(indicator));
      if (cancel_) cancel_->check();
      if (fix->Shape().IsNull()) return;
      body.before_whole = body.after;
      body.after = fix->Shape();
      body.context = fix->Context();
    } catch (const Standard_Failure&) {  // the body stays as it is; whoever heals the document sees that it is invalid
    }
  }

  std::vector<TopoDS_Shape> successors(const TopoDS_Shape& shape) const {
    TopoDS_Shape next = context_->Apply(shape);
    if (next.IsNull()) return {};
    if (const int* body = whole_.Seek(plain(next))) {
      const TopoDS_Shape fixed =
          bodies_[static_cast<std::size_t>(*body)].context->Apply(next.Located(TopLoc_Location()));
      if (fixed.IsNull()) return {};
      next = fixed.Moved(next.Location());
    }
    if (next.ShapeType() == shape.ShapeType()) return {next};
    std::vector<TopoDS_Shape> parts;
    for (TopExp_Explorer part(next, shape.ShapeType()); part.More(); part.Next()) parts.push_back(part.Current());
    return parts;
  }

  static void add_valid(const TopoDS_Shape& shape, Document& document) {
    for (const TopoDS_Shape& body : distinct_bodies(shape)) document.valid_bodies.Add(body);
  }

  const CancelToken* cancel_;
  const BlockLoop& loop_;
  std::vector<Body> bodies_;
  std::vector<TopoDS_Face> faces_;  ///< each once, forward
  std::vector<FixPrecision> precisions_;
  std::vector<char> face_valid_;
  Handle(BRepTools_ReShape) context_ = new BRepTools_ReShape;
  TopTools_DataMapOfShapeInteger whole_;  ///< parts of bodies that were repaired as a whole
  bool changed_ = false;
};

}  // namespace

void fix_raw_bodies(Document& document, const CancelToken* cancel, const BlockLoop& loop) {
  if (document.raw_bodies.empty()) return;
  BodyFixer fixer(document.raw_bodies, cancel, loop);
  fixer.fix();
  fixer.update(document);
  document.raw_bodies.clear();
}

}  // namespace tetloom::cad
