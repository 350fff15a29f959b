#pragma once
// Splits of edges that several parts have, as one of these parts sees them. All of them take the same edges: an edge is
// split where no part that has it refuses, and no two edges of a tet are split at once, so that the parts can do it
// after each other or at the same time.
#include <span>
#include <vector>

#include "adapt/kernel/cavity_mesh.hpp"

namespace tetloom::adapt {

/// Which edges between parts are split, and what their tets may become.
struct SideSplitOptions {
  double longest = HUGE_VAL;    ///< edges that are longer are split; none where infinite
  double floor = 0.1;           ///< mean ratio, as in PassOptions
  double most_tets = HUGE_VAL;  ///< a part that has as many refuses
  bool follows_model = false;   ///< edges on surfaces are refused: what is made there would lie beside the model
};

/// An edge of a side, longer than it should be.
struct SideEdge {
  std::array<std::uint32_t, 2> names;  ///< of its ends, ascending; all parts use the same
  std::array<std::uint32_t, 2> ends;   ///< the same vertices in this part
  std::uint32_t tet = kNone;           ///< that has it
  float length = 0;
  bool refused = false;
  PackedEntity entity;  ///< what this part knows of: of all parts that of the lowest dimension is right
};

/// A vertex to be.
struct SideSpot {
  Vec3 place;
  Tensor metric;
  BackgroundTet hint = kNoTet;
};

/// Of one part. `names`: of its vertices; those of shared ones order all edges in all parts alike.
/// Pre: the part has been started, and every face that it shares is open and has frozen vertices.
class SideSplits {
 public:
  SideSplits(CavityMesh& mesh, std::span<const std::uint32_t> names, const MetricStage& source,
             const SideSplitOptions& options)
      : mesh_(mesh), names_(names), source_(source), options_(options) {}

  /// All edges of sides that are longer than they should be, by their names. Refused are also those that are not the
  /// longest in each of their tets.
  std::vector<SideEdge> find();
  /// What the new vertex of an edge will be, the same in all parts, whatever else is split.
  SideSpot spot(const SideEdge& edge) const;
  /// Splits an edge at a new, frozen vertex.
  void split(const SideEdge& edge, PackedEntity entity, const SideSpot& spot);

 private:
  std::vector<SideEdge> long_edges() const;
  bool is_longest(const SideEdge& edge, std::span<const SideEdge> edges) const;
  bool can_split(const SideEdge& edge);

  CavityMesh& mesh_;
  std::span<const std::uint32_t> names_;
  const MetricStage& source_;
  SideSplitOptions options_;
  Cavity cavity_;
  MadeQualities made_;
};

}  // namespace tetloom::adapt
