#pragma once
// From a geometric model to a mesh: in one piece, in parts, by one process and by several ranks.
#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tetloom/communicator.hpp"
#include "tetloom/error.hpp"
#include "tetloom/filling.hpp"
#include "tetloom/host.hpp"
#include "tetloom/ids.hpp"
#include "tetloom/layers.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/model.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/size_field.hpp"

// A model entity that is too small for a mesh.

namespace tetloom {

/// A model entity of which a mesh has nothing, because it was too small for the sizes.
struct AbsorbedEntity {
  ModelEntity entity;
  ModelEntity into;     ///< the entity on which the mesh now lies where it was
  double distance = 0;  ///< by which its points were moved, at most; model length
};

// What a host asks for, and what it gets.
//
// Contract: the library prints nothing, never ends the process and installs no signal handler. Progress and
// cancellation go through Host. The mesh depends on the model, the options and the number of parts, and on nothing
// else: not on the number of threads.

class Trace;

/// The size asked of one model entity and everything on its closure.
struct EntitySize {
  ModelEntity entity;
  double size = 0;  ///< model length, > 0
};

/// A point in space with its own size; the gradation spreads it.
struct PointSize {
  Vec3 point;
  double size = 0;  ///< model length, > 0
};

/// The sizes asked for. All lengths are in model units; the smallest of all that applies at a point wins.
struct SizeOptions {
  double size = 0;           ///< absolute target edge length; 0: use relative_size
  double relative_size = 0;  ///< share of the bounding box's diagonal; 0 with size 0: 1/40
  double min_size = 0;       ///< floor for sizes from curvature and proximity; 0: a tenth of the target size, and a
                             ///< two hundredth for curvature around wires and balls
  double curvature = 0;      ///< at least this many edges per full turn; 0: off
  double proximity = 0;      ///< at least this many edges across a gap or wall; 0: off
  double gradation = 0.3;    ///< largest growth of the size per unit of distance, > 0
  std::vector<EntitySize> entity_sizes;
  std::vector<PointSize> point_sizes;
  std::function<double(const Vec3&)> callback;  ///< size wanted at a point, or a value <= 0 for no wish; called from
                                                ///< any thread at once
};

/// The share of the size asked for below which a feature of the model is small.
inline constexpr double kSmallFeature = 0.1;

/// How a model is meshed.
struct MeshOptions {
  SizeOptions sizes;
  bool surface_only = false;
  bool keep_small_features = false;  ///< false: edges, faces, steps and spikes of the model that are too small for the
                                     ///< size are eliminated from the mesh; the model itself stays as it is
  double small_feature =
      0;  ///< what is smaller is small; model length; 0: kSmallFeature of the size asked for at a
          ///< place. At most .4 of the size there and .3 of the solid's thickness; see small_features.hpp
  bool refine_surface = true;  ///< sizes become smaller where they do not fit: where walls, faces or model edges are
                               ///< narrower than 0.4 of them (down to min_size, or a tenth of what was asked for
                               ///< at the place), where the surface mesh would cross itself, and, where no curvature
                               ///< is asked for, around wires and balls that would lose their shape: at most ten edges
                               ///< per turn; false: the sizes stay, whatever the shape of the elements
  double most_refinement = 2;  ///< by refinement at narrow places the mesh may have so many times the elements that the
                               ///< sizes ask for, or 20,000 where that is more, and wires 20,000 triangles; infinite:
                               ///< as many as it takes. What is left is in the result
  bool improve_surface = true;  ///< surface points may slide on the model and edges inside of its faces be swapped
                                ///< while the volume is filled, where poor tets get better by it; false: the volume
                                ///< keeps the surface mesh exactly
  bool stop_where_model_crosses = false;  ///< the run ends with SelfIntersection as soon as faces of one region are
                                          ///< known to cross in the model itself, for hosts that rebuild_solids then
  bool keep_going = false;           ///< solids and sheets in which something fails are left out, with those that share
                                     ///< faces with them, and the others are meshed; by default the whole run fails
  int order = 1;                     ///< 2: elements have mid nodes, on the curves and faces of the model
  double min_scaled_jacobian = 0.1;  ///< of cells of second order: their Jacobian over that of the straight cell, at
                                     ///< every place; mid nodes leave the model where it would be less. 0 to .9
  LayerOptions layers;               ///< boundary layers, which regions have on the walls named there
  QualityGoals goals;                ///< of the tets
  LatticeKind lattice = LatticeKind::Bcc;  ///< that fills the inside of volumes
  int threads = 0;                         ///< 0: all cores that the process may use
  int parts = 0;  ///< of make_mesh_in_parts: the result is dealt to so many; 0: those in which it was made
  std::uint64_t max_memory = 0;  ///< bytes; refuse what is estimated to need more; 0: what the machine has free
  std::string volume_worker;     ///< path of tetloom-tetgen; empty: beside the executable, then in PATH
  bool worker_only = false;      ///< fill volumes by TetGen alone, to compare
  double tets_per_part = 0;      ///< volumes are filled in parts of so many tets; infinite: in one; 0: as many as suit
  Trace* trace = nullptr;        ///< takes what the tasks of the volume did; may be null
};

enum class MeshStatus { Ok, Failed, Cancelled };

/// Wall time of the stages of a run.
struct StageSeconds {
  double size_field = 0, surface = 0, layers = 0, volume = 0, second_order = 0;
};

/// A mid node that is classified on an edge or face of the model without lying on it.
struct OffModelNode {
  ModelEntity entity;
  double distance = 0;  ///< from its place on the entity; infinite where none was found
  Vec3 point;
};

/// What became of the mid nodes of a mesh of second order.
struct SecondOrderFigures {
  std::size_t mid_nodes = 0;
  std::size_t curved = 0;          ///< on curves and faces of the model, beside the middle of their edges
  std::size_t moved = 0;           ///< inside of regions, away from the middle: for validity, or as a wall below is
  double min_scaled_jacobian = 1;  ///< a lower bound over all cells; 1 where all are straight
  std::size_t invalid = 0;         ///< cells whose Jacobian is not proven positive; always 0
  std::vector<OffModelNode> off_model;
  double seconds = 0;
};

/// Where the sizes asked for did not fit; a warning of code SizeReduced tells faces and a place.
struct SurfaceRefinement {
  std::size_t crossings = 0;      ///< of triangles, in all rounds but the last
  std::size_t narrow_places = 0;  ///< triangles at walls, faces or edges that are too narrow, in all rounds
  std::size_t left = 0;           ///< triangles at narrow places for which `most_refinement` did not suffice
  int rounds = 0;                 ///< of meshing the surface anew
  double smallest_size = 0;       ///< model length; 0: nothing was refined
};

/// What became of a run. When `status` is not Ok, `mesh` holds what was finished: the surface mesh when the volume
/// failed or was cancelled, nothing when the surface did; with `keep_going` everything but what `errors` name, which
/// `is_partial` says.
struct MeshResult {
  MeshStatus status = MeshStatus::Failed;
  bool is_partial = false;
  bool stopped_early = false;  ///< because of MeshOptions::stop_where_model_crosses
  Mesh mesh;
  SizeField sizes = SizeField::uniform(1);
  std::vector<Diagnostic> errors;
  std::vector<Diagnostic> warnings;
  StageSeconds seconds;
  SurfaceRefinement refinement;
  std::vector<AbsorbedEntity> absorbed;  ///< model entities that were too small for the mesh, ascending
  double model_volume = 0;               ///< sum over the regions, but those left out; model length³
  FillingFigures filling;                ///< how the volume came to be filled
  LayerFigures layers;                   ///< with MeshOptions::layers
  SecondOrderFigures second_order;       ///< with MeshOptions::order 2
};

/// The regions whose own boundary crosses itself, as the errors of a result say, ascending: rebuild_solids may help.
std::vector<ModelRegionId> regions_that_cross(const MeshResult& result, const ModelTopology& topology);

/// Meshes a model. Regions are filled with tetrahedra, above boundary layers where those are asked for; a model without
/// regions gives a surface mesh.
/// Errors: throws Error(InvalidArgument) for options out of range. Everything that happens later is in the result.
/// Thread safety: may be called from any thread, several calls at once.
MeshResult make_mesh(const GeometricModel& model, const MeshOptions& options, const Host& host = {});

// From a geometric model to a mesh in one piece, by several ranks.

/// As make_mesh, by the ranks of `communicator` together. The first rank has the mesh that make_mesh makes, element for
/// element; the meshes of the others are the surface alone, as it was before the volume was filled. All else in the
/// result is the same on all ranks, but for `second_order` and warnings of volumes with it, which the first rank has. A
/// collective call, for which all ranks give the same. Errors and thread safety: as make_mesh; one call for each
/// communicator.
MeshResult make_mesh_on_ranks(const GeometricModel& model, const MeshOptions& options, Communicator& communicator,
                              const Host& host = {});

// From a geometric model to a mesh in parts, which is nowhere put together.

/// The mesh in parts, or why there is none.
struct MeshInPartsResult {
  MeshResult run;  ///< as of make_mesh, but its mesh is the surface alone, as it was before the volume was filled
  std::optional<PartitionedMesh> mesh;  ///< when the run's status is Ok
  double partition_seconds = 0;         ///< of dealing the mesh to parts
};

/// The mesh that make_mesh makes, in parts: `options.parts` of them, or, where that is 0, those in which volumes were
/// filled, which are complexes (regions connected through faces) and the parts of large ones. Global ids of vertices
/// are their numbers in make_mesh's mesh, but for sheets and wires, which have no part in it. A stack of boundary
/// layers lies in one part.
///
/// Errors: InvalidArgument is thrown, for options out of range, for surface_only and order 2. In the result:
/// what make_mesh says, and InputUnsuitable, before any work is done, for a model without regions and for one with
/// faces or edges that bound none. Thread safety: one call for each communicator.
MeshInPartsResult make_mesh_in_parts(const GeometricModel& model, const MeshOptions& options,
                                     Communicator& communicator, const Host& host = {});

}  // namespace tetloom
