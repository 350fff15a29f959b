#pragma once
// Small features of a model, from the options: what is small at a place, and what has to stay.
#include <optional>
#include <vector>

#include "mesher/features/eliminate_features.hpp"
#include "mesher/intersection/self_intersection.hpp"
#include "mesher/sizing/build_size_field.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// The elimination of small features in one run of the mesher, which meshes the surface several times.
/// Thread safety: one call at a time.
class SmallFeatures {
 public:
  /// `asked` holds the sizes that were asked for, without those from curvature and proximity.
  SmallFeatures(const GeometricModel& model, const MeshOptions& options, SizeField asked)
      : model_(model), options_(options), asked_(std::move(asked)), face_limits_(small_face_limits(model)) {}

  /// What is smaller than this at a place is eliminated, where no region is spared: `small_feature`, or kSmallFeature
  /// of the size asked for; never below the tolerance of the model there, nor above .4 of the size that the mesh has
  /// there.
  double tolerance_at(const Vec3& x, double size, ModelEntity entity) const;

  /// The surface without small features; see eliminate_small_features. The tolerance is also at most kSmallOfSolid of
  /// the thickness of the solids beside a face, so that a small solid keeps its shape.
  EliminationResult eliminate(const Mesh& surface, const SizeField& sizes, const TaskRunner& runner);

  /// Regions that the elimination brought further from the model's volume, to more than .75 % of it, have a smaller
  /// tolerance from now on, and none after three such cuts. Whether there are such.
  bool spare_regions(const Mesh& surface, const EliminationResult& eliminated);

  /// Where triangles of `mesh` cross at points where something was merged (`changed`, ascending), nothing will be
  /// from now on. Whether there are such.
  bool keep_where_crossing(const Mesh& mesh, std::span<const std::uint32_t> changed,
                           std::span<const TriangleIntersection> crossings);

 private:
  void spare_points(const Mesh& surface, std::vector<double>& tolerances) const;

  const GeometricModel& model_;
  const MeshOptions& options_;
  SizeField asked_;
  std::vector<double> face_limits_;  // of the tolerance; see SmallWidth
  std::vector<KeptPlace> kept_;
  features::KnownZones known_zones_;
  struct RegionLimit {
    double share = 1;  // of the tolerance
    int cuts = 0;
  };
  std::vector<RegionLimit> region_limits_;  // empty: none has changed
};

}  // namespace tetloom
