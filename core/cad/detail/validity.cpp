#include "core/cad/detail/validity.hpp"

#include <BRep_Tool.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepCheck_ListOfStatus.hxx>
#include <BRepCheck_Shell.hxx>
#include <BRepCheck_Solid.hxx>
#include <Geom_OffsetSurface.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include "core/cad/detail/surface_evaluator.hpp"

namespace tetloom::cad {
namespace {

bool is_clean(const BRepCheck_ListOfStatus& statuses) {
  for (const BRepCheck_Status status : statuses)
    if (status != BRepCheck_NoError) return false;
  return true;
}

bool is_valid_shell(const TopoDS_Shell& shell, const TopoDS_Shape& body) {
  const Handle(BRepCheck_Shell) check = new BRepCheck_Shell(shell);
  if (!is_clean(check->Status())) return false;
  if (body.ShapeType() != TopAbs_SOLID) return true;
  check->InContext(body);
  for (check->InitContextIterator(); check->MoreShapeInContext(); check->NextShapeInContext())
    if (!is_clean(check->StatusOnShape())) return false;
  return true;
}

/// Calls visit(shape) for every solid, shell outside solids and face outside shells, in its place.
template <class Visit>
void for_each_body(const TopoDS_Shape& root, const Visit& visit) {
  for (TopExp_Explorer body(root, TopAbs_SOLID); body.More(); body.Next()) visit(body.Current());
  for (TopExp_Explorer body(root, TopAbs_SHELL, TopAbs_SOLID); body.More(); body.Next()) visit(body.Current());
  for (TopExp_Explorer body(root, TopAbs_FACE, TopAbs_SHELL); body.More(); body.Next()) visit(body.Current());
}

std::vector<TopoDS_Shape> listed(const TopTools_IndexedMapOfShape& map) {
  std::vector<TopoDS_Shape> result;
  for (int i = 1; i <= map.Extent(); ++i) result.push_back(map(i));
  return result;
}

/// The faces of several bodies, each face once.
struct FacesOfBodies {
  std::vector<TopoDS_Face> faces;
  std::vector<std::vector<std::size_t>> of_body;
};

FacesOfBodies list_faces(const std::vector<TopoDS_Shape>& bodies) {
  FacesOfBodies result;
  TopTools_IndexedMapOfShape known;
  for (const TopoDS_Shape& body : bodies) {
    std::vector<std::size_t>& own = result.of_body.emplace_back();
    for (TopExp_Explorer face(body, TopAbs_FACE); face.More(); face.Next()) {
      const std::size_t index = static_cast<std::size_t>(known.Add(face.Current()));
      if (index > result.faces.size()) result.faces.push_back(TopoDS::Face(face.Current()));
      own.push_back(index - 1);
    }
  }
  return result;
}

}  // namespace

bool is_valid_face(const TopoDS_Face& face) {
  try {
    return BRepCheck_Analyzer(face).IsValid();
  } catch (const Standard_Failure&) {
    return false;
  }
}

bool has_valid_shells(const TopoDS_Shape& body) {
  try {
    if (body.ShapeType() == TopAbs_SOLID) {
      const Handle(BRepCheck_Solid) check = new BRepCheck_Solid(TopoDS::Solid(body));
      if (!is_clean(check->Status())) return false;
    }
    for (TopExp_Explorer shell(body, TopAbs_SHELL); shell.More(); shell.Next())
      if (!is_valid_shell(TopoDS::Shell(shell.Current()), body)) return false;
    return true;
  } catch (const Standard_Failure&) {
    return false;
  }
}

std::vector<TopoDS_Shape> distinct_bodies(const TopoDS_Shape& root) {
  TopTools_IndexedMapOfShape bodies;
  for_each_body(root, [&](const TopoDS_Shape& body) { bodies.Add(body.Located(TopLoc_Location())); });
  return listed(bodies);
}

std::vector<TopoDS_Shape> suspect_bodies(const Document& document) {
  TopTools_IndexedMapOfShape bodies;
  for_each_body(document.root, [&](const TopoDS_Shape& body) {
    if (!document.valid_bodies.Contains(body.Located(TopLoc_Location()))) bodies.Add(body);
  });
  return listed(bodies);
}

bool has_offset_surface(const TopoDS_Face& face) {
  TopLoc_Location place;
  const Handle(Geom_Surface)& surface = BRep_Tool::Surface(face, place);
  return !surface.IsNull() && untrimmed(surface)->IsKind(STANDARD_TYPE(Geom_OffsetSurface));
}

std::vector<TopoDS_Shape> find_invalid_bodies(Document& document, const CancelToken* cancel, const BlockLoop& loop) {
  std::vector<TopoDS_Shape> bodies = distinct_bodies(document.root);
  std::erase_if(bodies, [&](const TopoDS_Shape& body) { return document.valid_bodies.Contains(body); });
  const FacesOfBodies list = list_faces(bodies);
  std::vector<char> face_valid(list.faces.size()), valid(bodies.size(), 1);
  for_each_face(list.faces, loop, [&](std::size_t i) {
    if (cancel) cancel->check();
    face_valid[i] = is_valid_face(list.faces[i]) ? 1 : 0;
  });
  loop.for_blocks(bodies.size(), 1, [&](std::size_t i, std::size_t) {
    for (const std::size_t face : list.of_body[i]) valid[i] &= face_valid[face];
    if (valid[i]) valid[i] = has_valid_shells(bodies[i]) ? 1 : 0;
  });
  std::vector<TopoDS_Shape> invalid;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (valid[i]) {
      document.valid_bodies.Add(bodies[i]);
    } else {
      invalid.push_back(bodies[i]);
    }
  }
  return invalid;
}

}  // namespace tetloom::cad
