#pragma once
// All samples of one model, size and number of threads, and how they are shown.
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "bench/support/surface_run.hpp"

namespace tetloom::bench {

/// The runs of one mesher on one task, in the order in which they ran.
struct Series {
  std::vector<SurfaceSample> samples;

  bool empty() const { return samples.empty(); }
  /// The sample of median wall time. Pre: not empty.
  const SurfaceSample& median() const;
  double triangles_per_second() const;
};

struct SurfaceCase {
  std::string model_name;
  std::size_t model_faces = 0;
  SurfaceTask task;
  Series tetloom, gmsh;  ///< gmsh: empty where it does not run
};

/// One line per mesher and case: speed first, then what it was bought with.
void print_table(std::span<const SurfaceCase> cases);

/// The two claims, one line each for every model and size that they speak of: tetloom's speed beside gmsh's with 2
/// threads, and its own from 1 to 2 threads.
void print_claims(std::span<const SurfaceCase> cases);

nlohmann::json to_json(const SurfaceCase& surface_case);

}  // namespace tetloom::bench
