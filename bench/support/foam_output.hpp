#pragma once
// What OpenFOAM's programs say of meshes.
#include <cstdint>
#include <string>

namespace tetloom::bench {

/// What checkMesh finds.
struct FoamCheck {
  bool is_fine = true;        ///< it complains of nothing but aspect ratios, which layers have to have
  std::string complaint;      ///< the first line that it marks as an error otherwise
  double non_orthogonal = 0;  ///< share of faces above 70 degrees
  double skewness = 0;        ///< the largest
};

/// Takes it from what checkMesh has printed.
FoamCheck read_check_mesh(const std::string& output);

/// What snappyHexMesh makes.
struct SnappySample {
  double seconds = 0;                        ///< of the whole run, its background mesh as well
  std::uint64_t cells = 0, layer_cells = 0;  ///< in the end; those added for layers
  double layers = 0, thickness = 0;          ///< mean number, and share of the thickness, as it says itself
  std::string failure = {};                  ///< what it said where it made no mesh
};

/// Takes cells and layers from what snappyHexMesh has printed. Throws std::runtime_error where they are missing.
void read_snappy(const std::string& output, SnappySample& sample);

}  // namespace tetloom::bench
