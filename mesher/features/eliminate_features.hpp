#pragma once
// Small model features eliminated from a surface mesh by local modification with reclassification, after Dey, Shephard
// & Georges, "Elimination of the adverse effects of small model features by the local modification of automatically
// generated meshes" (1997), and Shephard, Beall & O'Bara (1998).
#include <optional>
#include <span>
#include <vector>

#include "mesher/features/known_zones.hpp"
#include "mesher/surface/kept_facets.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom {

/// What is small at each point of a surface mesh.
struct FeatureElimination {
  std::span<const double> tolerances;  ///< one per point of the mesh: what is smaller goes; model length
  std::span<const double> sizes;       ///< one per point: the edge length wanted there
  std::span<const KeptPlace> kept;     ///< balls in which nothing is eliminated
};

/// The surface mesh without small features, and what was done.
struct EliminationResult {
  std::optional<Mesh> mesh;              ///< none where nothing was to be done
  std::vector<AbsorbedEntity> absorbed;  ///< ascending by entity
  std::size_t collapses = 0, snaps = 0;
  std::vector<std::uint32_t> changed;  ///< points of the new mesh at which something was merged, ascending
};

/// Merges vertices of a surface mesh that are nearer to each other, or to an edge opposite to them, than the tolerance
/// there: a short model edge becomes a vertex, a sliver face a curve, a narrow spike goes. Then edges and triangles
/// beside merged vertices are brought nearer to the size by further merges and swaps, within the tolerance.
///
/// Kept are the topology of the surface (and so solids, holes and voids), model vertices and edges but for what is
/// merged with others, and a distance of at most the tolerance between the old and the new surface. Refused is what
/// would lay two triangles at a vertex upon each other (see shape_check.hpp), so thin walls and the rims of thin plates
/// stay. Merged vertices belong to the entity of lower dimension; an absorbed edge's pieces belong to the edge that
/// they fell upon.
///
/// What is done beside a small feature depends on the surface up to four edges from it, its zone. Zones are changed in
/// parallel, and those that `known` has are not changed anew; it has those of this call afterwards.
///
/// The mesh may have any topology, but no cells. Points that are used no more are left out; others keep their order.
/// The result depends on the mesh alone. Pre: arrays of tolerances and sizes as long as the points. Complexity: linear,
/// plus O(k log k) for k changes in a zone. Errors: Cancelled.
EliminationResult eliminate_small_features(const Mesh& mesh, const FeatureElimination& how, const TaskRunner& runner,
                                           features::KnownZones* known = nullptr);

}  // namespace tetloom
