#pragma once
// The interface behind which a volume is filled: a closed triangulated surface with regions on its sides goes in,
// tetrahedra come out. It needs no CAD, only the surface.
#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/sizing/memory_check.hpp"
#include "mesher/tets/optimizer.hpp"
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/model.hpp"
#include "tetloom/size_field.hpp"
#include "tetloom/vec.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom {

/// A surface that bounds regions. Triangles are counter-clockwise seen from the tip of their normal.
struct VolumeInput {
  std::span<const Vec3> points;
  std::span<const std::array<std::uint32_t, 3>> tri_to_vert;
  std::span<const FaceSides> tri_to_sides;            ///< one per triangle; invalid id: outside of every region
  std::span<const std::uint32_t> tri_to_face;         ///< model face index, for error messages
  const GeometricModel* model = nullptr;              ///< for names in error messages; may be null
  const SizeField* sizes = nullptr;                   ///< never null
  std::span<const ModelEntity> point_to_entity = {};  ///< one per point, or empty: then no point may slide
  std::span<const std::array<std::uint32_t, 2>> edge_to_vert = {};  ///< pieces of model edges: they stay edges
};

/// How volumes are filled.
struct VolumeOptions {
  std::string worker;        ///< path of tetloom-tetgen; empty: beside the executable, then in PATH, or none
  bool worker_only = false;  ///< fill by TetGen alone, to compare
  /// Whether points may slide within their model face, and edges inside of a model face be swapped, where that makes
  /// poor tets better. Without a model, only edges between triangles in one plane are.
  bool improve_surface = false;
  std::uint64_t max_memory = 0;  ///< bytes; refuse what is estimated to need more; 0: what the machine has free
  QualityGoals goals = {};
  LatticeKind lattice = LatticeKind::Bcc;  ///< of the inside
  double tets_per_part = 0;  ///< complexes are filled in parts of so many estimated tets; infinite: in one; 0: a number
                             ///< of parts that follows from the work, see parts::count_parts
  Trace* trace = nullptr;    ///< takes what the parts' tasks did; may be null
};

/// The tetrahedra that fill_volume will make, within about a tenth for uniform sizes: the size field over the box of
/// the surface, times the share of the box that the regions take; and the memory for them. Pre: as fill_volume.
MeshEstimate estimate_filling(const VolumeInput& input);

/// Fills every region of `input`: each triangle that bounds a filled region is a face of the result. The given surface
/// is kept exactly, unless the options allow to improve it: then it is the surface with the places of points and the
/// triangles that the parts have. Regions that share no triangle are filled independently and in parallel, also where
/// they touch, each complex of them in one part or several. The result does not depend on how many threads or ranks do
/// it, but for which rank has which part. Guaranteed for the result, checked after the fact: all tetrahedra have
/// positive volume in exact arithmetic, each lies in the region that all triangles around it name, and every side of a
/// triangle that names a region has its tetrahedron. Pre: indices valid, spans of equal length. Coordinates must be
/// finite and no larger than 1e45, the surface no smaller than 1e-40. All ranks call it and give the same; errors are
/// the same on all of them. Errors: InvalidArgument (broken pre-conditions), Cancelled, OutOfMemory (also when the
/// estimate does not fit) are thrown. In the result: OpenShell for a region whose boundary does not close,
/// SelfIntersection, VolumeFailed and WorkerFailed for what cannot be filled. Thread safety: one call for each
/// communicator.
VolumeParts fill_volume(const VolumeInput& input, const VolumeOptions& options, const SharedWork& work);

}  // namespace tetloom
