#pragma once
// A surface mesh that fits its sizes: sizes, surface, small features and the test for crossings, round after round.
#include <optional>
#include <vector>

#include "mesher/failed_complexes.hpp"
#include "mesher/features/small_features.hpp"
#include "mesher/intersection/new_triangles.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/intersection/triangle_tree.hpp"
#include "mesher/refinement_log.hpp"
#include "mesher/sizing/build_size_field.hpp"
#include "mesher/sizing/misfits.hpp"
#include "mesher/surface/surface_mesher.hpp"
#include "mesher/surface_rounds.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// Makes the surface mesh of one run. Where the sizes do not fit they become smaller, and the surface is made anew
/// there: twice as small where triangles cross because they are too coarse for the shape, and as small as it takes and
/// the budget allows where it is narrow. What still crosses after a few rounds crosses in the model. After the first
/// round a few misfits are not worth another. A round meshes faces again where sizes changed, and looks for crossings
/// and misfits at triangles that are new. Where a surface of facets that do not cross still crosses itself in the end,
/// its facets are kept as they are.
class SurfaceFitter {
 public:
  /// Complexes that fail are taken into `failed` where the options say so. What comes out, figures and seconds go into
  /// `result`, also where an exception ends the run.
  SurfaceFitter(const GeometricModel& model, const MeshOptions& options, const SharedWork& work,
                FailedComplexes& failed, MeshResult& result);

  /// Whether there is a surface that may be filled. To be called once, by all ranks together. Errors: Cancelled,
  /// OutOfMemory, and those of sizes and surface.
  bool run();

 private:
  /// A ball in which walls of a region touch without a common vertex, as a hole and a side that it is tangent to.
  struct Contact {
    Vec3 center;
    double radius = 0;
  };

  struct Candidate {
    SizeField sizes = SizeField::uniform(1);
    double elements = 0;  ///< estimated: tets, or triangles where nothing is filled
    SurfaceMeshResult surface;
    std::vector<AbsorbedEntity> absorbed;
    std::vector<std::uint8_t> tri_is_new;  ///< since the last round; empty: all are
    std::optional<intersection::TriangleTree> tree;
    std::vector<TriangleIntersection> all_hits, solid_hits;  ///< crossings, and those of solids: sheets may cross
  };

  /// Where the surface is too narrow for its sizes.
  struct NarrowPlaces {
    std::vector<Misfit> misfits;
    bool takes_back = false;  ///< of refinements before, those at walls that touch
  };

  SizedModel build_sizes(const std::vector<SizeRefinement>& refinements);
  SizeField build_asked_sizes() const;
  double count_elements(const MeshEstimate& estimate) const;

  Candidate make_candidate(const SizedModel& sized);
  void set_aside(SurfaceMeshResult& surface);
  void settle_features(Candidate& candidate);
  void find_crossings(Candidate& candidate);
  bool crosses_in_model(Candidate& candidate);
  bool has_skins(Candidate& candidate) const;
  bool keep_facets(const Candidate& candidate);
  std::vector<Misfit> find_misfits(const Candidate& candidate) const;
  SizeFloor floor_at(const Vec3& x) const;
  bool drop_contacts(const Candidate& candidate, std::vector<Misfit>& misfits);
  bool is_in_contact(const Vec3& x) const;
  std::vector<TriangleIntersection> those_of_solids(std::vector<TriangleIntersection> hits, const Mesh& mesh) const;
  bool bounds_region(std::uint32_t face) const;

  NarrowPlaces find_narrow_places(const Candidate& candidate, const SurfaceRounds& rounds);
  static SurfaceRound count_round(const Candidate& candidate, const NarrowPlaces& narrow);
  bool refine_together(const Candidate& candidate, const NarrowPlaces& narrow, SizedModel& sized);
  std::optional<SizedModel> refine(const Candidate& candidate, const NarrowPlaces& narrow);
  void refine_at(const TriangleIntersection& hit, const Mesh& mesh);

  bool reject(Candidate&& candidate);
  bool accept(Candidate&& candidate, bool is_fine_enough);
  bool stop_early(Candidate&& candidate);
  bool judge_crossings(Candidate&& candidate);
  void take(Candidate&& candidate);
  void append(const std::vector<Diagnostic>& errors, const std::vector<Diagnostic>& warnings);

  const GeometricModel& model_;
  const MeshOptions& options_;
  const SharedWork& work_;
  const TaskRunner& runner_;
  FailedComplexes& failed_;
  MeshResult& result_;
  std::vector<std::uint32_t> complexes_;  // per face
  SizeFieldBuilder sizing_;
  SurfaceMesher mesher_;
  std::optional<SmallFeatures> features_;
  RefinementLog log_;
  std::vector<Contact> contacts_;
  int kept_rounds_ = 0;                            // in which more facets were kept as they are
  KnownTriangles embedded_;                        // triangles that were there in the last round and did not cross
  SizeField first_sizes_ = SizeField::uniform(1);  // before any refinement
  double first_elements_ = 0;                      // the elements estimated for those
};

}  // namespace tetloom
