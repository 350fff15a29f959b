#pragma once
// Other volume meshers, run beside tetloom on the same model and size.
#include <filesystem>
#include <string>

#include "bench/support/volume_run.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom::bench {

/// What all peers need: the task, the sizes that edges are judged by, and where to write.
struct PeerTask {
  VolumeTask task;
  SizeField sizes;
  std::filesystem::path folder;
};

/// Gmsh with HXT: `gmsh MODEL -3 -algo hxt -nt T -bin -clmin H -clmax H`; a varying size is its MathEval field. The
/// seconds are those that gmsh reports for its 3D stage.
VolumeSample measure_hxt(const PeerTask& peer);

/// `tetgen -pYq1.4m` on tetloom's surface of the same size, which `surface` (.smesh) holds. The seconds are its whole
/// running time without writing.
VolumeSample measure_tetgen(const PeerTask& peer, const std::filesystem::path& surface);

/// Netgen, in batch mode, one size everywhere. The seconds are those that it reports for its whole meshing, surface and
/// all, as it does not tell its stages apart.
VolumeSample measure_netgen(const PeerTask& peer);

/// Whether netgen is installed and finds its own libraries.
bool is_netgen_usable();

}  // namespace tetloom::bench
