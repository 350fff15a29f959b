#pragma once
// The surface mesh of a model: edges once each, then faces in parallel, then one conforming mesh of all.
#include <memory>
#include <span>
#include <vector>

#include "mesher/surface/kept_facets.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// The surface mesh, with what went wrong.
struct SurfaceMeshResult {
  Mesh mesh;                       ///< points, edges and triangles with their classification; no tets
  std::vector<Diagnostic> errors;  ///< faces that could not be meshed; their triangles are missing
  std::vector<Diagnostic> warnings;
};

/// Meshes all edges and faces. Where pieces of edges cross because they are too coarse for a face, these edges are
/// made finer and the faces at them meshed again. Ranks share the faces, and the pieces of large ones; all have the
/// whole surface in the end. The result does not depend on the number of threads or ranks. Errors: Cancelled,
/// OutOfMemory and EdgeFailed are thrown; faces that fail are in the result.
SurfaceMeshResult mesh_surface(const GeometricModel& model, const SizeField& sizes, const SharedWork& work);

/// mesh_surface again and again, each time with sizes that are those of the last time or smaller: faces are meshed
/// again where a size has changed beside them or on their edges, the others stay as they are. Refers to the model,
/// which must outlive it. Thread safety: one call at a time.
class SurfaceMesher {
 public:
  SurfaceMesher(const GeometricModel& model, const SharedWork& work);
  ~SurfaceMesher();

  SurfaceMeshResult mesh(const SizeField& sizes);
  /// From the next call on, surfaces of facets stay as they are given in these balls. Returns whether one is new.
  bool keep_facets(std::span<const KeptPlace> places);
  /// How many faces the last call has meshed at least once.
  std::size_t remeshed() const;

 private:
  class State;
  std::unique_ptr<State> state_;
};

}  // namespace tetloom
