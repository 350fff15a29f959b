#pragma once
// One complex filled: by our own means, or, as the last resort, by TetGen in its worker, in attempts from the best mesh
// to any valid one; and an honest account of failures.
#include <string>

#include "mesher/volume/complex.hpp"
#include "mesher/volume/complex_filling.hpp"
#include "mesher/volume/volume_mesher.hpp"
#include "threading/comm/shared_work.hpp"

namespace tetloom::volume {

/// What all complexes of a run are filled from and with. Refers to what must outlive it.
struct FillingPlan {
  const VolumeInput& input;
  const VolumeOptions& options;
  std::string worker;                       ///< path; empty: there is none
  const SurfaceFreedom* freedom = nullptr;  ///< null: the surface has to stay
};

/// Fills `complex` as fill_volume promises, in parts where `may_be_parted` and it is large enough. Points and triangles
/// of the parts are numbered as in the complex; there is none when no attempt succeeded. Errors: Cancelled and
/// OutOfMemory are thrown, everything else is in the result. The result depends on the plan and the complex alone.
VolumeParts fill_complex(const FillingPlan& plan, const Complex& complex, FillingProgress& progress, bool may_be_parted,
                         const TaskRunner& runner);

/// The same in parts, by all ranks, where it is large enough and the parts fit together; else there are figures alone,
/// and it is to be filled in one part. All ranks call it, in `together`.
VolumeParts fill_complex_in_parts(const FillingPlan& plan, const Complex& complex, FillingProgress& progress,
                                  const SharedWork& work);

}  // namespace tetloom::volume
