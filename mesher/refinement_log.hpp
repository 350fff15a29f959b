#pragma once
// What was refined while a surface was made to fit its sizes, and how that is told.
#include <initializer_list>
#include <map>

#include "mesher/sizing/build_size_field.hpp"
#include "mesher/sizing/misfits.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// The refinement that makes a misfit fit.
SizeRefinement refinement_for(const Misfit& misfit, const Mesh& surface);

/// Thread safety: one call at a time.
class RefinementLog {
 public:
  /// `refinement`: on these triangles of `surface`.
  void note(const SizeRefinement& refinement, std::initializer_list<std::uint32_t> triangles, const Mesh& surface);
  void note(const Misfit& misfit, const Mesh& surface);

  /// Of those noted; 0 where there are none.
  double smallest_size() const { return smallest_size_; }
  /// A warning of code SizeReduced with the faces, those with most triangles first, and the place of the smallest size.
  /// `done`: whether what was wanted is in the mesh.
  Diagnostic describe(const SurfaceRefinement& refinement, bool done, const GeometricModel& model) const;

 private:
  std::map<std::uint32_t, std::size_t> face_to_count_;  // of triangles
  double smallest_size_ = 0;
  Vec3 smallest_place_;
};

}  // namespace tetloom
