#include "core/cad/detail/assembly.hpp"

#include <algorithm>
#include <BRep_Builder.hxx>
#include <cctype>
#include <Quantity_Color.hxx>
#include <TColStd_HSequenceOfExtendedString.hxx>
#include <TDataStd_Name.hxx>
#include <TDF_LabelSequence.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_LayerTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>

#include "core/cad/detail/step_names.hpp"

namespace tetloom::cad {
namespace {

std::string name_of(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  return label.FindAttribute(TDataStd_Name::GetID(), name) ? clean_name(name->Get()) : "";
}

/// Names of instances that say nothing: numbers, and the counters that some systems write.
bool is_counter(std::string_view name) {
  if (name.starts_with("NAUO")) name.remove_prefix(4);
  return std::all_of(name.begin(), name.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
}

std::string joined(const std::string& path, const std::string& name) {
  if (path.empty() || name.empty()) return path + name;
  return path + "/" + name;
}

/// What the tree says of the way down to a label.
struct Placement {
  TopLoc_Location location;
  std::string path;
  ShapeAttributes attributes;  ///< colours and layer
};

class AssemblyWalker {
 public:
  explicit AssemblyWalker(const Handle(TDocStd_Document) & document)
      : shapes_(XCAFDoc_DocumentTool::ShapeTool(document->Main())),
        colors_(XCAFDoc_DocumentTool::ColorTool(document->Main())),
        layers_(XCAFDoc_DocumentTool::LayerTool(document->Main())) {
    BRep_Builder().MakeCompound(out_.root);
  }

  Document walk() {
    TDF_LabelSequence roots;
    shapes_->GetFreeShapes(roots);
    for (const TDF_Label& root : roots) visit(root, {});
    return std::move(out_);
  }

 private:
  // The nearest word wins: an instance's over its part's, and both over those of the assembly around.
  void visit(const TDF_Label& label, Placement placement) {
    TDF_Label target = label;
    std::string name;
    const bool is_instance = XCAFDoc_ShapeTool::IsReference(label);
    if (is_instance) {
      XCAFDoc_ShapeTool::GetReferredShape(label, target);
      placement.location = placement.location * XCAFDoc_ShapeTool::GetLocation(label);
      if (const std::string instance = name_of(label); !is_counter(instance)) name = instance;
    }
    overrule(placement.attributes, own_attributes(target));
    if (is_instance) overrule(placement.attributes, own_attributes(label));
    if (name.empty()) name = name_of(target);
    placement.path = joined(placement.path, name);
    if (XCAFDoc_ShapeTool::IsAssembly(target)) {
      TDF_LabelSequence components;
      XCAFDoc_ShapeTool::GetComponents(target, components);
      for (const TDF_Label& component : components) visit(component, placement);
    } else {
      add_part(target, placement);
    }
  }

  void add_part(const TDF_Label& label, const Placement& placement) {
    TopoDS_Shape shape;
    if (!XCAFDoc_ShapeTool::GetShape(label, shape) || shape.IsNull()) return;
    const TopoDS_Shape placed = shape.Moved(placement.location);
    BRep_Builder().Add(out_.root, placed);
    ShapeAttributes attributes = placement.attributes;
    attributes.name = placement.path;
    attributes.is_part = true;
    add_attributes(out_.attributes, placed, attributes);
    TDF_LabelSequence parts;
    XCAFDoc_ShapeTool::GetSubShapes(label, parts);
    for (const TDF_Label& part : parts) add_sub_shape(part, placement);
  }

  void add_sub_shape(const TDF_Label& label, const Placement& placement) {
    TopoDS_Shape shape;
    if (!XCAFDoc_ShapeTool::GetShape(label, shape) || shape.IsNull()) return;
    ShapeAttributes attributes = own_attributes(label);
    attributes.name = name_of(label);
    add_attributes(out_.attributes, shape.Moved(placement.location), attributes);
  }

  ShapeAttributes own_attributes(const TDF_Label& label) const {
    ShapeAttributes result;
    result.color = color_of(label, XCAFDoc_ColorSurf);
    if (!result.color) result.color = color_of(label, XCAFDoc_ColorGen);
    result.edge_color = color_of(label, XCAFDoc_ColorCurv);
    Handle(TColStd_HSequenceOfExtendedString) names = layers_->GetLayers(label);
    if (!names.IsNull() && !names->IsEmpty()) result.layer = clean_name(names->First());
    return result;
  }

  std::optional<Color> color_of(const TDF_Label& label, XCAFDoc_ColorType type) const {
    Quantity_Color color;
    if (!colors_->GetColor(label, type, color)) return std::nullopt;
    return Color{static_cast<float>(color.Red()), static_cast<float>(color.Green()), static_cast<float>(color.Blue())};
  }

  static void overrule(ShapeAttributes& attributes, const ShapeAttributes& stronger) {
    if (stronger.color) attributes.color = stronger.color;
    if (stronger.edge_color) attributes.edge_color = stronger.edge_color;
    if (!stronger.layer.empty()) attributes.layer = stronger.layer;
  }

  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colors_;
  Handle(XCAFDoc_LayerTool) layers_;
  Document out_;
};

}  // namespace

Document flatten_assembly(const Handle(TDocStd_Document) & document) { return AssemblyWalker(document).walk(); }

}  // namespace tetloom::cad
