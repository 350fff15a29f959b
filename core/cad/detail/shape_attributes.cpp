#include "core/cad/detail/shape_attributes.hpp"

#include <BRep_Tool.hxx>
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

/// What a shape takes over from the shapes around it.
struct Inherited {
  std::string part;
  std::optional<Color> color;
  std::string layer;
  std::size_t solids_in_part = 0;
  bool in_solid = false;
};

std::size_t count_solids(const TopoDS_Shape& shape) {
  std::size_t count = 0;
  for (TopExp_Explorer solid(shape, TopAbs_SOLID); solid.More(); solid.Next()) ++count;
  return count;
}

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
    if (own) {
      if (own->is_part && !own->name.empty()) state.part = own->name, state.solids_in_part = count_solids(shape);
      if (own->color) state.color = own->color;
      if (!own->layer.empty()) state.layer = own->layer;
    }
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
      out.name = region_name(name, state);
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

  static std::string region_name(const std::string& own, const Inherited& state) {
    if (state.part.empty()) return own;
    if (own.empty() || state.solids_in_part <= 1) return state.part;
    return state.part + "/" + own;
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

std::array<std::vector<EntityAttributes>, 4> make_entity_attributes(const TopoDS_Shape& root, const AttributeMap& map,
                                                                    const ShapeTables& shapes) {
  return AttributeResolver(map, shapes).resolve(root);
}

}  // namespace tetloom::cad
