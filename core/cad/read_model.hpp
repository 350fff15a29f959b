#pragma once
// Reading a geometric model from a file: STEP, IGES and BREP through OpenCASCADE, STL and OBJ as discrete models.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/block_loop.hpp"
#include "core/base/progress.hpp"
#include "core/geometry/model.hpp"

namespace tetloom {

struct ReadOptions {
  bool heal = true;      ///< repair what OpenCASCADE can repair (wires, small edges, tolerances, orientation)
  bool imprint = false;  ///< fuse touching solids so that they share faces (General Fuse)
  double feature_angle = 0.6981317007977318;  ///< radians; discrete models are cut into faces where facets turn by more
  double fill_holes = 0;                      ///< model length; of discrete models, holes at most as wide are closed
  /// Solids, numbered as the regions of the model that is read without this, to be made anew from the space that their
  /// faces enclose: for those whose boundary crosses itself. Of CAD files only.
  std::vector<ModelRegionId> rebuild = {};
};

/// One thing that was repaired, with how often.
struct HealingStep {
  std::string what;
  std::size_t count = 0;
};

struct ModelDocument {
  std::unique_ptr<GeometricModel> model;
  std::vector<HealingStep> healing;
  std::size_t rebuilt = 0;           ///< solids that ReadOptions::rebuild asked for and that were made anew
  std::vector<Diagnostic> warnings;  ///< invalid shapes that remain, open shells, entities left out …
  std::string format;                ///< "STEP", "IGES", "BREP", "STL" or "OBJ"
};

/// Reads the model in `path`; the format follows from the file's extension (.step .stp .iges .igs .brep .stl .obj,
/// any case) and must agree with its content.
/// Errors: InvalidArgument (unknown extension, options out of range), InputUnreadable, InputUnsuitable (no shape),
/// Cancelled, OutOfMemory. Thread safety: may be called from any thread; calls are serialised inside. Checks and
/// measurements run on the threads of `loop`; the model does not depend on it.
ModelDocument read_model(const std::filesystem::path& path, const ReadOptions& options = {},
                         const CancelToken* cancel = nullptr, const BlockLoop& loop = serial_loop());

}  // namespace tetloom
