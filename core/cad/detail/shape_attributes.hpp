#pragma once
// Names, colours and layers of shapes on their way from a file to the entities of a model. Private to core/cad.
#include <array>
#include <functional>
#include <NCollection_IndexedDataMap.hxx>
#include <optional>
#include <string>
#include <TopTools_ShapeMapHasher.hxx>
#include <vector>

#include "core/cad/detail/topology.hpp"
#include "tetloom/model.hpp"

namespace tetloom::cad {

/// What a file says of one shape.
struct ShapeAttributes {
  std::string name;
  bool is_part = false;  ///< the name is that of a part in its assembly ("gearbox/shaft") and holds for what is inside
  std::optional<Color> color;       ///< of surfaces; holds for what is inside as well
  std::optional<Color> edge_color;  ///< of curves
  std::string layer;                ///< holds for what is inside as well
};

/// By shape in its place; iterates in the order of insertion.
using AttributeMap = NCollection_IndexedDataMap<TopoDS_Shape, ShapeAttributes, TopTools_ShapeMapHasher>;

/// Adds to what `map` says of `shape`; what is there already stays.
void add_attributes(AttributeMap& map, const TopoDS_Shape& shape, const ShapeAttributes& attributes);

/// The attributes of every entity, by dimension. Colours and layers are inherited from the shapes around. A region is
/// named after its part; where a part has several solids, after its part and itself. Faces of sheets carry the name of
/// their part unless they have one of their own.
std::array<std::vector<EntityAttributes>, 4> make_entity_attributes(const TopoDS_Shape& root, const AttributeMap& map,
                                                                    const ShapeTables& shapes);

/// A solid, a shell outside solids or a face outside shells, with what it has from itself and the shapes around: the
/// name is that of the part (see make_entity_attributes), so is_part is set when there is one.
struct Body {
  TopoDS_Shape shape;
  ShapeAttributes attributes;
};

/// All bodies of a shape, each once, in its order.
std::vector<Body> collect_bodies(const TopoDS_Shape& root, const AttributeMap& map);

/// What became of a shape: itself, or the shapes that replace it (none when it was removed).
using ShapeSuccessors = std::function<std::vector<TopoDS_Shape>(const TopoDS_Shape&)>;

/// The map after the shapes were changed: successors inherit.
AttributeMap transfer_attributes(const AttributeMap& map, const ShapeSuccessors& successors);

}  // namespace tetloom::cad
