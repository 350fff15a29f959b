#include "core/cad/detail/imprint.hpp"

#include <BRepAlgoAPI_BuilderAlgo.hxx>
#include <sstream>
#include <TopExp_Explorer.hxx>
#include <TopTools_ListOfShape.hxx>

#include "core/cad/detail/occt_guard.hpp"

namespace tetloom::cad {
namespace {

/// The fuse knows the history of solids and faces alone: they get what they inherit from the shapes around.
void spread_attributes(const std::vector<Body>& bodies, AttributeMap& map) {
  AttributeMap spread;
  for (const Body& body : bodies) {
    if (body.shape.ShapeType() == TopAbs_SOLID) {
      add_attributes(spread, body.shape, body.attributes);
    } else {
      for (TopExp_Explorer face(body.shape, TopAbs_FACE); face.More(); face.Next()) {
        if (const ShapeAttributes* own = map.Seek(face.Current())) add_attributes(spread, face.Current(), *own);
        add_attributes(spread, face.Current(), body.attributes);
      }
    }
  }
  for (int i = 1; i <= map.Extent(); ++i) add_attributes(spread, map.FindKey(i), map(i));
  map = spread;
}

std::size_t count_faces(const TopoDS_Shape& shape) {
  TopTools_IndexedMapOfShape map;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) map.Add(face.Current());
  return static_cast<std::size_t>(map.Extent());
}

}  // namespace

bool imprint(Document& document, std::vector<HealingStep>& steps, const CancelToken* cancel) {
  const std::vector<Body> bodies = collect_bodies(document.root, document.attributes);
  if (bodies.size() < 2) return false;
  TopTools_ListOfShape arguments;
  for (const Body& body : bodies) arguments.Append(body.shape);
  BRepAlgoAPI_BuilderAlgo fuse;
  fuse.SetArguments(arguments);
  fuse.SetRunParallel(false);
  fuse.SetNonDestructive(true);
  Handle(CancelIndicator) indicator = new CancelIndicator(cancel);
  fuse.Build(Message_ProgressIndicator::Start(indicator));
  if (cancel) cancel->check();
  if (fuse.HasErrors() || fuse.Shape().IsNull()) {
    std::ostringstream reason;
    fuse.DumpErrors(reason);
    throw Error(ErrorCode::InputUnsuitable, "the bodies could not be fused: " + reason.str());
  }
  spread_attributes(bodies, document.attributes);
  const std::size_t before = count_faces(document.root);
  replace_shapes(document, fuse.Shape(), [&](const TopoDS_Shape& shape) {
    std::vector<TopoDS_Shape> result;
    if (!fuse.IsDeleted(shape))
      for (const TopoDS_Shape& next : fuse.Modified(shape)) result.push_back(next);
    if (result.empty() && !fuse.IsDeleted(shape)) result.push_back(shape);
    return result;
  });
  const std::size_t after = count_faces(document.root);
  add_step(steps, "faces were imprinted on each other", before > after ? before - after : after - before);
  return true;
}

}  // namespace tetloom::cad
