#pragma once
// What was refined while a surface was made to fit its sizes, and how that is told.
#include <array>
#include <functional>
#include <initializer_list>
#include <vector>

#include "mesher/sizing/build_size_field.hpp"
#include "mesher/sizing/misfits.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/mesh_data.hpp"

namespace tetloom {

/// The refinement that makes a misfit fit.
SizeRefinement refinement_for(const Misfit& misfit, const Mesh& surface);

/// The refinements of a run, in the order in which they were asked for. Thread safety: one call at a time.
class RefinementLog {
 public:
  /// `refinement`: on these triangles of `surface`.
  void note(const SizeRefinement& refinement, std::initializer_list<std::uint32_t> triangles, const Mesh& surface);
  void note(const Misfit& misfit, const Mesh& surface);

  /// Takes back what was refined for misfits, where `is_useless` says so of it. Returns whether there was any.
  bool take_back(const std::function<bool(const SizeRefinement&)>& is_useless);

  std::vector<SizeRefinement> refinements() const;
  std::size_t misfit_count() const;
  /// Of those noted; 0 where there are none.
  double smallest_size() const;
  /// A warning of code SizeReduced with the faces, those with most triangles first, and the place of the smallest size.
  /// `done`: whether what was wanted is in the mesh.
  Diagnostic describe(const SurfaceRefinement& refinement, bool done, const GeometricModel& model) const;

 private:
  struct Entry {
    SizeRefinement refinement;
    std::array<std::uint32_t, 2> faces;  // equal where there is one
    bool is_misfit = false;
  };

  std::vector<Entry> entries_;
};

}  // namespace tetloom
