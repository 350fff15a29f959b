#pragma once
// Facets of a face by OpenCASCADE's incremental mesher. Private to core/cad.
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <TopoDS_TShape.hxx>
#include <tuple>

#include <TopoDS_Face.hxx>
#include <TopTools_IndexedMapOfShape.hxx>

#include "tetloom/model.hpp"

namespace tetloom::cad {

/// Facets of faces that models have in several places, made once for each fineness and then only moved. Thread safety:
/// any number of threads.
class SharedFacets {
 public:
  /// A face in a place of its own, with its facets.
  struct Facetted;

  SharedFacets();
  ~SharedFacets();

  /// Faces that are here more than once count as repeated from now on.
  void add_places(const TopTools_IndexedMapOfShape& faces);
  void add_repeated(const TopoDS_Face& face);
  /// The facets of the face without its location; null where it is not repeated. Errors: as tessellate_face.
  std::shared_ptr<const Facetted> find(const TopoDS_Face& face, double chord, double angle);

 private:
  struct Entry;
  std::mutex mutex_;
  std::set<Handle(TopoDS_TShape)> repeated_;
  std::map<std::tuple<const TopoDS_TShape*, double, double>, std::shared_ptr<Entry>> entries_;
};

class FaceShape;

/// Works on a copy of the face, because OpenCASCADE writes triangulations into shapes. Where its mesher fails at the
/// fineness asked for, others are tried, finer ones first, then larger angles. Errors: FaceFailed, InvalidArgument.
Tessellation tessellate_face(const FaceShape& shape, const ModelTopology& topology, ModelFaceId id, double chord,
                             double angle);

}  // namespace tetloom::cad
