#pragma once
// The one family of errors: what went wrong, on which model entities, and where.
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "tetloom/ids.hpp"
#include "tetloom/vec.hpp"

namespace tetloom {

/// Why a call failed. The names written to reports are those of `to_string` and are stable.
enum class ErrorCode {
  InvalidArgument,   ///< an option is out of range or contradicts another
  InputUnreadable,   ///< the file is missing, empty, truncated, of another format
  InputUnsuitable,   ///< the file was read but holds nothing that can be meshed
  EdgeFailed,        ///< a model edge could not be discretised
  FaceFailed,        ///< a model face could not be meshed
  SizeReduced,       ///< a warning: a size asked for does not fit somewhere and was made smaller
  SelfIntersection,  ///< the surface mesh crosses itself
  OpenShell,         ///< a region's boundary has a hole
  VolumeFailed,      ///< a region could not be filled
  VolumeDiffers,     ///< a warning: a region's mesh has another volume than the model says
  RegionInsideOut,   ///< a warning: the boundary of a region is oriented inwards
  RegionsOverlap,    ///< a warning: regions that share no face lie in each other
  WorkerFailed,      ///< a worker process crashed, was killed or could not be started
  Cancelled,         ///< the host asked to stop
  OutOfMemory,       ///< an allocation failed or an estimate says that it would
  OutputFailed,      ///< a file could not be written (permission, full disk)
  Internal           ///< a broken invariant of tetloom itself
};

std::string_view to_string(ErrorCode code);

/// A model entity as a person sees it.
struct NamedEntity {
  ModelEntity entity;
  std::string name;  ///< from the CAD file; empty where it has none
};

/// An error or a warning with its place.
struct Diagnostic {
  ErrorCode code = ErrorCode::Internal;
  std::string message;                  ///< one sentence for a person, without a trailing newline
  std::vector<NamedEntity> entities;    ///< the model entities concerned, most important first
  std::optional<Vec3> point;            ///< a point in model space at or near the trouble
  std::vector<std::uint64_t> elements;  ///< ids of offending mesh elements, where there is a mesh
};

/// Thrown at module boundaries for bad input and failed operations. Never thrown for a normal refusal.
class Error : public std::runtime_error {
 public:
  explicit Error(Diagnostic diagnostic);
  Error(ErrorCode code, const std::string& message);
  const Diagnostic& diagnostic() const noexcept { return diagnostic_; }
  ErrorCode code() const noexcept { return diagnostic_.code; }

 private:
  Diagnostic diagnostic_;
};

/// "face 17 'flange'", for messages.
std::string describe(const NamedEntity& entity);

}  // namespace tetloom
