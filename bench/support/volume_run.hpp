#pragma once
// One measured volume mesh, of tetloom or of a peer, in a process of its own.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "bench/support/wave_size.hpp"
#include "tetloom/mesh_data.hpp"
#include "tetloom/size_field.hpp"

namespace tetloom::bench {

struct VolumeTask {
  std::filesystem::path model;
  double size = 0;      ///< target edge length, the smallest where it varies
  double gradient = 0;  ///< of the size; 0: one size everywhere
  double start = 0;     ///< of the wave, see WaveSize
  int threads = 1;
  std::string surface_path =
      {};  ///< not empty: no volume, but the surface for TetGen in this .smesh and .mtr beside it

  WaveSize wave() const { return {size, gradient, start}; }
};
void to_json(nlohmann::json& json, const VolumeTask& task);
void from_json(const nlohmann::json& json, VolumeTask& task);

/// Seconds of the stages of tetloom's filling.
struct FillingSeconds {
  double points = 0, core = 0, delaunay = 0, recovery = 0, join = 0, optimize = 0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(FillingSeconds, points, core, delaunay, recovery, join, optimize)

struct VolumeSample {
  double seconds = 0;  ///< wall time of the 3D stage
  double size_seconds = 0, surface_seconds = 0;
  std::uint64_t peak_bytes = 0;  ///< of the whole process
  std::uint64_t tets = 0, points = 0, below_15 = 0;
  double density = 0;  ///< tets per size³
  double ratio_mean = 0, ratio_p1 = 0, ratio_min = 0;
  double min_dihedral_deg = 0;
  double below_20 = 0;    ///< share of tets with a dihedral angle below 20 degrees
  double in_band = 0;     ///< share of edges with length / size in [0.707, 1.414]
  double edge_ratio = 0;  ///< mean of edge length / size
  std::uint64_t forced = 0, core_tets = 0, missing_triangles = 0, recovery_points = 0, worker_complexes = 0;
  FillingSeconds filling;
  std::string digest;  ///< equal digests: equal meshes
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(VolumeSample, seconds, size_seconds, surface_seconds, peak_bytes, tets, points,
                                   below_15, density, ratio_mean, ratio_p1, ratio_min, min_dihedral_deg, below_20,
                                   in_band, edge_ratio, forced, core_tets, missing_triangles, recovery_points,
                                   worker_complexes, filling, digest)

/// The size field of a task, the one that all meshers' edges are judged by.
SizeField make_sizes(const VolumeTask& task);

/// Fills in what can be seen from the mesh itself. A mesh whose tets are all turned the other way is turned first.
void judge_volume(Mesh& mesh, const SizeField& sizes, VolumeSample& sample);

/// Reads and meshes in this very process; for a process started for nothing else, so that its peak memory is that of
/// the task. Throws Error, also for a region that is not filled.
VolumeSample measure_volume_here(const VolumeTask& task);

/// The same in a process of its own: `program --measure`. Throws std::runtime_error with what it said when it fails.
VolumeSample measure_volume_apart(const std::string& program, const VolumeTask& task);

/// The smallest size, of three digits, with which a model gets about this many tets. A varying size takes two
/// runs of `program` to find.
double find_volume_size(const std::string& program, VolumeTask task, double tets);

/// Half a wave lies about the middle of the model.
double find_wave_start(const std::filesystem::path& model);

}  // namespace tetloom::bench
