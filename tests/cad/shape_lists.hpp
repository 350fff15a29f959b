#pragma once
// Shapes to lists and back, for the samples.
#include <BRep_Builder.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS_Compound.hxx>
#include <vector>

namespace tetloom::test {

inline TopoDS_Shape compound(const std::vector<TopoDS_Shape>& shapes) {
  TopoDS_Compound result;
  const BRep_Builder builder;
  builder.MakeCompound(result);
  for (const TopoDS_Shape& shape : shapes) builder.Add(result, shape);
  return result;
}

inline std::vector<TopoDS_Shape> faces_of(const TopoDS_Shape& shape) {
  std::vector<TopoDS_Shape> result;
  for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next()) result.push_back(face.Current());
  return result;
}

}  // namespace tetloom::test
