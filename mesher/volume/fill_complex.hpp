#pragma once
// One complex filled: by our own means, or, as the last resort, by TetGen in its worker, in attempts from the best mesh
// to any valid one; and an honest account of failures.
#include <string>

#include "mesher/volume/complex.hpp"
#include "mesher/volume/filling.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::volume {

/// How a complex is filled; the same for all complexes of a run.
struct ComplexOptions {
  std::string worker;                       ///< path; empty: there is none
  bool worker_only = false;                 ///< no attempt by our own means
  const SurfaceFreedom* freedom = nullptr;  ///< null: the surface has to stay
  QualityGoals goals = {};
  LatticeKind lattice = LatticeKind::Bcc;
  double tets_per_part = 0;  ///< as VolumeOptions
  Trace* trace = nullptr;
};

/// Fills `complex` as fill_volume promises, in parts where `may_be_parted` and it is large enough. Points and triangles
/// of the parts are numbered as in the complex; there is none when no attempt succeeded. Errors: Cancelled and
/// OutOfMemory are thrown, everything else is in the result. The result depends on the input and the worker alone.
VolumeParts fill_complex(const VolumeInput& input, const Complex& complex, const ComplexOptions& options,
                         FillingProgress& progress, bool may_be_parted, const TaskRunner& runner);

/// The same in parts, by all ranks, where it is large enough and the parts fit together; else there are figures alone,
/// and it is to be filled in one part. A collective call.
VolumeParts fill_complex_in_parts(const VolumeInput& input, const Complex& complex, const ComplexOptions& options,
                                  FillingProgress& progress, Communicator& communicator, const TaskRunner& runner);

}  // namespace tetloom::volume
