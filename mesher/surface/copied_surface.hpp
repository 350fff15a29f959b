#pragma once
// Surfaces of copied complexes: meshed once, then moved to where the copies stand.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "mesher/surface/copied_complexes.hpp"
#include "mesher/surface/edge_mesher.hpp"
#include "mesher/surface/face_mesher.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// The copied complexes whose surfaces are carried over: those with the same sizes everywhere on their surface, to a
/// fifth. A complex that once had other sizes is meshed for itself from then on. Refers to the model and the runner.
class CopiedSurface {
 public:
  CopiedSurface(const GeometricModel& model, const TaskRunner& runner);

  /// Whether the mesh of the face is carried over.
  bool carries(std::size_t face) const { return face_to_copy_[face] != kNone; }

  /// Gives the edges of the copies the nodes that the edges of the complexes have of which they are copies.
  void carry_edges(const SizeField& sizes, std::vector<EdgeMesh>& edges);

  /// Likewise for faces. Pre: the other faces are meshed, and `rim` is that of carry_edges.
  void carry_faces(const SizeField& sizes, const RimNodes& rim, std::vector<FaceMesh>& faces);

  /// The faces, ascending, that have to be meshed for themselves from now on, with edges of their own: those that were
  /// found since the last call.
  std::vector<std::size_t> take_released();

 private:
  bool has_same_edges(const SizeField& sizes, const CopiedComplex& copy, const std::vector<EdgeMesh>& edges) const;
  bool has_same_faces(const SizeField& sizes, const CopiedComplex& copy, const std::vector<FaceMesh>& faces) const;
  void carry(const CopiedComplex& copy, std::vector<EdgeMesh>& edges) const;
  void carry(const CopiedComplex& copy, const RimNodes& rim, std::vector<FaceMesh>& faces) const;
  void release(const std::vector<char>& was_carried);

  const GeometricModel& model_;
  const TaskRunner& runner_;
  std::vector<CopiedComplex> copies_;
  std::vector<char> is_carried_;             // per copy
  std::vector<std::uint32_t> face_to_copy_;  // kNone where it is not carried over
  std::vector<std::size_t> released_;
};

}  // namespace tetloom
