#include "apps/tetloom/exit_status.hpp"

namespace tetloom::app {

ExitStatus exit_status(ErrorCode code) {
  switch (code) {
    case ErrorCode::InvalidArgument: return ExitStatus::WrongUsage;
    case ErrorCode::InputUnreadable:
    case ErrorCode::InputUnsuitable: return ExitStatus::BadInput;
    case ErrorCode::EdgeFailed:
    case ErrorCode::FaceFailed:
    case ErrorCode::SizeReduced:
    case ErrorCode::SelfIntersection:
    case ErrorCode::OpenShell:
    case ErrorCode::VolumeFailed:
    case ErrorCode::VolumeDiffers:
    case ErrorCode::RegionInsideOut:
    case ErrorCode::RegionsOverlap:
    case ErrorCode::WorkerFailed:
    case ErrorCode::Internal: return ExitStatus::NotMeshed;
    case ErrorCode::Cancelled: return ExitStatus::Cancelled;
    case ErrorCode::OutOfMemory:
    case ErrorCode::OutputFailed: return ExitStatus::OutOfResources;
  }
  return ExitStatus::NotMeshed;
}

std::string_view report_status(ExitStatus status) {
  switch (status) {
    case ExitStatus::Done: return "ok";
    case ExitStatus::Cancelled: return "cancelled";
    default: return "failed";
  }
}

}  // namespace tetloom::app
