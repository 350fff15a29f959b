#pragma once
// One complex filled: by our own means, or, as the last resort, by TetGen in its worker, in attempts from the best mesh
// to any valid one; and an honest account of failures.
#include <optional>
#include <string>
#include <vector>

#include "mesher/volume/complex.hpp"
#include "mesher/volume/complex_filling.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "mesher/volume/volume_parts.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

/// What became of one complex.
struct FilledComplex {
  std::optional<Filling> filling;  ///< nothing when no attempt succeeded, or when there are parts
  std::vector<VolumePart> parts;   ///< where they are kept; points and triangles numbered as in the complex
  std::uint64_t new_points = 0;    ///< of all parts
  std::size_t part_count = 0;      ///< on all ranks
  std::vector<std::array<std::uint32_t, 3>>
      tri_to_vert;  ///< the complex's triangles as they have become; empty: as before
  std::vector<Diagnostic> errors, warnings;
  FillingFigures figures;
};

/// How a complex is filled; the same for all complexes of a run.
struct ComplexOptions {
  std::string worker;                       ///< path; empty: there is none
  bool worker_only = false;                 ///< no attempt by our own means
  const SurfaceFreedom* freedom = nullptr;  ///< null: the surface has to stay
  QualityGoals goals = {};
  LatticeKind lattice = LatticeKind::Bcc;
  double tets_per_part = 0;  ///< as VolumeOptions
  Trace* trace = nullptr;
  Communicator* communicator = nullptr;  ///< see fill_complex_in_parts
  bool keep_parts = false;  ///< what is filled in parts, of which there are then two at least, stays in them
};

/// Fills `complex` as fill_volume promises; a filling's first points are the complex's, where they have become. Errors:
/// Cancelled and OutOfMemory are thrown, everything else is in the result. The result depends on the input and the
/// worker alone.
FilledComplex fill_complex(const VolumeInput& input, const Complex& complex, const ComplexOptions& options,
                           FillingProgress& progress, const TaskRunner& runner);

/// Fills `complex` in parts on all ranks of the options' communicator, where it is large enough and the parts fit
/// together; else there are figures alone, and it is to be filled in one part. A collective call.
FilledComplex fill_complex_in_parts(const VolumeInput& input, const Complex& complex, const ComplexOptions& options,
                                    FillingProgress& progress, const TaskRunner& runner);

}  // namespace tetloom::volume
