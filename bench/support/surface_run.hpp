#pragma once
// One measured surface mesh, of tetloom or of a peer, in a process of its own.
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tetloom/mesh_data.hpp"

namespace tetloom::bench {

struct SurfaceTask {
  std::filesystem::path model;
  double size = 0;  ///< target edge length
  int threads = 1;
};

struct SurfaceSample {
  double seconds = 0;      ///< wall time of the surface stage alone, the file read before
  double cpu_seconds = 0;  ///< processor time of the stage, all threads
  std::uint64_t triangles = 0;
  std::uint64_t peak_bytes = 0;     ///< of the whole process
  std::uint64_t stage_bytes = 0;    ///< of these, what the stage added; 0 where unknown
  double intersection_seconds = 0;  ///< the self-intersection test; 0 where there is none
  std::uint64_t intersections = 0;  ///< pairs of triangles that cross
  double quality = 0;               ///< mean of 4√3·A/Σl²
  double min_angle_deg = 0;
  double edge_ratio = 0;  ///< mean of edge length / size
  double in_band = 0;     ///< share of edges with length / size in [0.707, 1.414]
  std::string digest;     ///< equal digests: equal meshes
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SurfaceSample, seconds, cpu_seconds, triangles, peak_bytes, stage_bytes,
                                   intersection_seconds, intersections, quality, min_angle_deg, edge_ratio, in_band,
                                   digest)

/// Fills in what can be seen from the mesh itself.
void judge_mesh(const Mesh& mesh, double size, SurfaceSample& sample);

/// Reads and meshes in this very process; for a process started for nothing else, so that its peak memory and processor
/// time are those of the task. Throws Error, also for a face that fails.
SurfaceSample measure_here(const SurfaceTask& task);

/// The same in a process of its own: `program --measure`. Throws std::runtime_error with what it said when it fails.
SurfaceSample measure_apart(const std::string& program, const SurfaceTask& task);

}  // namespace tetloom::bench
