#pragma once
// From a model and the sizes asked for to the size field.
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "mesher/sizing/mesh_estimate.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// What is too small for the mesh; nothing by default.
struct SmallWidth {
  double width = 0;  ///< model length
  double share = 0;  ///< of the size asked for on the entity; counts where there is no width
  /// Nothing above this is small: kSmallOfSolid of the thickness of the thinner solid beside each face. Empty: no
  /// limit.
  std::vector<double> face_limits;

  double on(double size) const { return width > 0 ? width : share * size; }
  double on_face(std::size_t face, double size) const {
    return face_limits.empty() ? on(size) : std::min(on(size), face_limits[face]);
  }
};

/// The share of a solid's thickness, twice its volume over its surface, below which its features may be small.
inline constexpr double kSmallOfSolid = 0.3;

/// `face_limits` of a SmallWidth.
std::vector<double> small_face_limits(const GeometricModel& model);

/// A triangle on which a size is asked for; a point where its corners coincide.
struct SizeRefinement {
  std::array<Vec3, 3> corners;
  double size = 0;  ///< model length, > 0
  friend bool operator==(const SizeRefinement&, const SizeRefinement&) = default;
};

/// The size field that meets all of `options`. At a point the smallest wins of
/// - the global size: `size`, else `relative_size` or 1/40 of the bounding box's diagonal;
/// - the sizes of entities: on the entity and its closure, for a region in its interior too;
/// - point sizes and `refinements` (which may lie below every floor);
/// - the callback, looked at on a grid of 32 cells along the box and more finely where it varies;
/// - curvature, by the rule of curvature_size.hpp, and proximity, a gap's width over the number of layers; both are at
///   least `min_size`, or a tenth of the global size when that is 0 (curvature around wires and balls: a two
///   hundredth);
/// and what these allow at a distance: |h(x) - h(y)| <= g |x - y|. A gradation above 1 acts as 1.
///
/// The field answers at most a few percent more than what was asked at a place (up to ten where sizes vary fastest),
/// the global size exactly where nothing smaller reaches, and is a uniform field when nothing smaller is asked for at
/// all. A size holds within 0.6 to 0.95 edge lengths of its source before it grows. Outside of all regions, further
/// than an edge length from every face, the field is coarse. Faces that cannot be facetted give no sizes; their own
/// mesher reports them.
///
/// The result does not depend on the number of threads. Complexity: O(n log n) in the facets and the leaves; a leaf is
/// about as wide as the sizes in it where the field varies, and as large as can be where it does not.
/// Errors: InvalidArgument naming the option; InputUnsuitable (a model without extent); OutOfMemory when the mesh or
/// the field could not fit in `max_memory` bytes (0: what the machine has free); Cancelled; what the callback throws.
SizeField build_size_field(const GeometricModel& model, const SizeOptions& options,
                           std::span<const SizeRefinement> refinements, const TaskRunner& runner,
                           std::uint64_t max_memory = 0);

/// A size field and what a mesh on it will hold.
struct SizedModel {
  SizeField sizes = SizeField::uniform(1);
  MeshEstimate estimate;
};

/// build_size_field and estimate_mesh in one, again and again with other refinements: the model is facetted, and its
/// own sources are found, once. Where refinements are added at the end of those of the last call, what they do not
/// change is not made again: the field is then the one that would be built anew in the same cube. Ranks share facets,
/// sources, cells and corners; all have the whole field in the end. Faces and edges narrower than `small` ask for no
/// sizes for their curvature: small features are eliminated from the mesh. With `most_refinement` above 1, wires and
/// balls that the sizes would take the shape of get a few edges per turn where no curvature is asked for, as far as the
/// mesh has not more than so many times the elements, or they kFewElements triangles (see find_wires). Refers to its
/// arguments, which must outlive it. Thread safety: one call at a time.
class SizeFieldBuilder {
 public:
  /// Errors: InvalidArgument, InputUnsuitable as for build_size_field.
  SizeFieldBuilder(const GeometricModel& model, const SizeOptions& options, const SharedWork& work,
                   std::uint64_t max_memory = 0, SmallWidth small = {}, double most_refinement = 1);
  ~SizeFieldBuilder();

  SizedModel build(std::span<const SizeRefinement> refinements);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tetloom
