#include "tetloom/error.hpp"

#include <array>
#include <utility>

namespace tetloom {

std::string_view to_string(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument: return "invalid_argument";
    case ErrorCode::InputUnreadable: return "input_unreadable";
    case ErrorCode::InputUnsuitable: return "input_unsuitable";
    case ErrorCode::EdgeFailed: return "edge_failed";
    case ErrorCode::FaceFailed: return "face_failed";
    case ErrorCode::SizeReduced: return "size_reduced";
    case ErrorCode::SelfIntersection: return "self_intersection";
    case ErrorCode::OpenShell: return "open_shell";
    case ErrorCode::VolumeFailed: return "volume_failed";
    case ErrorCode::VolumeDiffers: return "volume_differs";
    case ErrorCode::RegionInsideOut: return "region_inside_out";
    case ErrorCode::RegionsOverlap: return "regions_overlap";
    case ErrorCode::WorkerFailed: return "worker_failed";
    case ErrorCode::Cancelled: return "cancelled";
    case ErrorCode::OutOfMemory: return "out_of_memory";
    case ErrorCode::OutputFailed: return "output_failed";
    case ErrorCode::Internal: return "internal";
  }
  return "internal";
}

Error::Error(Diagnostic diagnostic) : std::runtime_error(diagnostic.message), diagnostic_(std::move(diagnostic)) {}

Error::Error(ErrorCode code, const std::string& message) : Error(Diagnostic{code, message, {}, {}, {}}) {}

std::string describe(const NamedEntity& entity) {
  static constexpr std::array<const char*, 5> kinds{"vertex", "edge", "face", "region", "entity"};
  std::string text = kinds[entity.entity.dim > 3 ? 4 : entity.entity.dim];
  text += ' ' + std::to_string(entity.entity.tag());
  if (!entity.name.empty()) text += " '" + entity.name + "'";
  return text;
}

}  // namespace tetloom
