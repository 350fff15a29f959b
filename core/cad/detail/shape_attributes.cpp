#include "core/cad/detail/shape_attributes.hpp"

#include <BRep_Tool.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Iterator.hxx>

namespace tetloom::cad {

void add_attributes(AttributeMap& map, const TopoDS_Shape& shape, const ShapeAttributes& attributes) {
  ShapeAttributes* old = map.ChangeSeek(shape);
  if (!old) {
    map.Add(shape, attributes);
    return;
  }
  if (old->name.empty()) old->name = attributes.name, old->is_part = attributes.is_part;
  if (!old->color) old->color = attributes.color;
  if (!old->edge_color) old->edge_color = attributes.edge_color;
  if (old->layer.empty()) old->layer = attributes.layer;
}

AttributeMap transfer_attributes(const AttributeMap& map, const ShapeSuccessors& successors) {
  AttributeMap result;
  for (int i = 1; i <= map.Extent(); ++i)
    for (const TopoDS_Shape& shape : successors(map.FindKey(i))) add_attributes(result, shape, map(i));
  return result;
}

namespace {

std::size_t count_solids(const TopoDS_Shape& shape) {
  std::size_t count = 0;
  for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next()) ++count;
  return count;
}

/// What a shape takes over from the shapes around it.
struct Inherited {
  std::string part;
  std::optional<Color> color;
  std::string layer;
  std::size_t solids_in_part = 0;
  bool in_solid = false;

  void enter(const TopoDS_Shape& shape, const ShapeAttributes* own) {
    if (!own) return;
    if (own->is_part && !own->name.empty()) part = own->name, solids_in_part = count_solids(shape);
    if (own->color) color = own->color;
    if (!own->layer.empty()) layer = own->layer;
  }
  /// The name of a region that calls itself `own` inside this part.
  std::string region_name(const ShapeAttributes* attributes) const {
    const std::string own = attributes && !attributes->is_part ? attributes->name : "";
    if (part.empty()) return own;
    if (own.empty() || solids_in_part <= 1) return part;
    return part + "/" + own;
  }
};

class BodyCollector {
 public:
  BodyCollector(const TopoDS_Shape& root, const AttributeMap& map) : map_(map) {
    for (TopExp_Explorer solid(root, TopAbs_SOLID); solid.More(); solid.Next())
      TopExp::MapShapes(solid.Current(), TopAbs_FACE, faces_of_solids_);
  }

  void visit(const TopoDS_Shape& shape, Inherited state) {
    const ShapeAttributes* own = map_.Seek(shape);
    state.enter(shape, own);
    const TopAbs_ShapeEnum type = shape.ShapeType();
    if (type == TopAbs_COMPOUND || type == TopAbs_COMPSOLID) {
      for (TopoDS_Iterator child(shape); child.More(); child.Next()) visit(child.Value(), state);
    } else if (type == TopAbs_SOLID || ((type == TopAbs_SHELL || type == TopAbs_FACE) && !bounds_solids(shape))) {
      if (seen_.Contains(shape)) return;
      seen_.Add(shape);
      const std::string name = type == TopAbs_SOLID ? state.region_name(own) : state.part;
      bodies.push_back({shape, {name, !name.empty(), state.color, std::nullopt, state.layer}});
    }
  }

  std::vector<Body> bodies;

 private:
  // Some files list the shells and faces of their solids once more beside them.
  bool bounds_solids(const TopoDS_Shape& shape) const {
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
      if (!faces_of_solids_.Contains(face.Current())) return false;
    return true;
  }

  const AttributeMap& map_;
  TopTools_IndexedMapOfShape faces_of_solids_, seen_;
};

class AttributeResolver {
 public:
  AttributeResolver(const AttributeMap& map, const ShapeTables& shapes) : map_(map), shapes_(shapes) {
    const TopTools_IndexedMapOfShape* tables[4] = {&shapes.vertices, &shapes.edges, &shapes.faces, &shapes.solids};
    for (int dim = 0; dim < 4; ++dim) {
      out_[dim].resize(static_cast<std::size_t>(tables[dim]->Extent()));
      seen_[dim].resize(out_[dim].size(), false);
    }
    set_tolerances();
  }

  std::array<std::vector<EntityAttributes>, 4> resolve(const TopoDS_Shape& root) {
    Inherited state;
    state.solids_in_part = count_solids(root);
    visit(root, state);
    return std::move(out_);
  }

 private:
  void set_tolerances() {
    for (std::size_t i = 0; i < out_[0].size(); ++i)
      out_[0][i].tolerance = BRep_Tool::Tolerance(shapes_.vertex(ModelVertexId(i)));
    for (std::size_t i = 0; i < out_[1].size(); ++i)
      out_[1][i].tolerance = BRep_Tool::Tolerance(shapes_.edge(ModelEdgeId(i)));
    for (std::size_t i = 0; i < out_[2].size(); ++i)
      out_[2][i].tolerance = BRep_Tool::Tolerance(shapes_.face(ModelFaceId(i)));
  }

  void visit(const TopoDS_Shape& shape, Inherited state) {
    const ShapeAttributes* own = map_.Seek(shape);
    state.enter(shape, own);
    if (!record(shape, own, state)) return;
    if (shape.ShapeType() == TopAbs_SOLID) state.in_solid = true;
    for (TopoDS_Iterator child(shape); child.More(); child.Next()) visit(child.Value(), state);
  }

  /// False when this shape was met before; the first parent wins.
  bool record(const TopoDS_Shape& shape, const ShapeAttributes* own, const Inherited& state) {
    const auto [dim, index] = entity(shape);
    if (dim < 0) return true;
    if (index == 0) return dim > 0;  // not an entity of the model
    if (seen_[dim][index - 1]) return false;
    seen_[dim][index - 1] = true;
    EntityAttributes& out = out_[dim][index - 1];
    out.layer = state.layer;
    const std::string name = own && !own->is_part ? own->name : "";
    if (dim == 3) {
      out.name = state.region_name(own);
      out.color = state.color;
    } else if (dim == 2) {
      out.name = name.empty() && !state.in_solid ? state.part : name;
      out.color = state.color;
    } else {
      out.name = name;
      if (own) out.color = own->edge_color ? own->edge_color : own->color;
    }
    return dim > 0;
  }

  std::pair<int, std::size_t> entity(const TopoDS_Shape& shape) const {
    switch (shape.ShapeType()) {
      case TopAbs_SOLID: return {3, static_cast<std::size_t>(shapes_.solids.FindIndex(shape))};
      case TopAbs_FACE: return {2, static_cast<std::size_t>(shapes_.faces.FindIndex(shape))};
      case TopAbs_EDGE: return {1, static_cast<std::size_t>(shapes_.edges.FindIndex(shape))};
      case TopAbs_VERTEX: return {0, static_cast<std::size_t>(shapes_.vertices.FindIndex(shape))};
      default: return {-1, 0};
    }
  }

  const AttributeMap& map_;
  const ShapeTables& shapes_;
  std::array<std::vector<EntityAttributes>, 4> out_;
  std::array<std::vector<bool>, 4> seen_;
};

}  // namespace

std::vector<Body> collect_bodies(const TopoDS_Shape& root, const AttributeMap& map) {
  BodyCollector collector(root, map);
  Inherited state;
  state.solids_in_part = count_solids(root);
  collector.visit(root, state);
  return std::move(collector.bodies);
}

std::array<std::vector<EntityAttributes>, 4> make_entity_attributes(const TopoDS_Shape& root, const AttributeMap& map,
                                                                    const ShapeTables& shapes) {
  return AttributeResolver(map, shapes).resolve(root);
}

}  // namespace tetloom::cad
