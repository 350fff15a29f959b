#pragma once
// What the library and the worker process `tetloom-tetgen` say to each other: one framed request one way, one framed
// response back, in the byte order of the machine that both run on.
//
// A frame is a header (magic, version, kind, payload length, checksum) and its payload. Everything that arrives is
// checked before it is believed: lengths against what is there, indices against the arrays that they index,
// coordinates for being finite. Thread safety: pure functions. Errors: Error(WorkerFailed) for malformed bytes.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tetloom/vec.hpp"

namespace tetloom::volume {

/// Which way a frame goes.
enum class FrameKind : std::uint32_t { Request = 1, Response = 2 };

/// What stands in front of every frame.
struct FrameHeader {
  std::uint64_t magic = kMagic;
  std::uint32_t version = kVersion;
  FrameKind kind = FrameKind::Request;
  std::uint64_t payload_size = 0;
  std::uint64_t checksum = 0;

  static constexpr std::uint64_t kMagic = 0x31746574'6d6f6f6c;  // "loomtet1"
  static constexpr std::uint32_t kVersion = 1;
  static constexpr std::uint64_t kLargestPayload = std::uint64_t{1} << 38;
};

/// One complex to fill. Points that no triangle uses become interior vertices.
struct WorkerRequest {
  std::string switches;  ///< TetGen's command line switches
  std::vector<Vec3> points;
  std::vector<std::array<std::uint32_t, 3>> tri_to_vert;
};

/// What the worker says of its work.
enum class WorkerStatus : std::uint32_t {
  Filled = 0,
  OutOfMemory = 1,
  InternalError = 2,
  SelfIntersection = 3,
  SmallFeature = 4,
  NearlyCoplanar = 5,
  BadInput = 10
};

/// Tetrahedra over the request's points followed by `new_points`. They cover the convex parts outside as well as the
/// inside, in any orientation.
struct WorkerResponse {
  WorkerStatus status = WorkerStatus::InternalError;
  std::string message;
  std::vector<Vec3> new_points;
  std::vector<std::array<std::uint32_t, 4>> tet_to_vert;
};

/// The whole frame, header included.
std::vector<std::byte> encode(const WorkerRequest& request);
std::vector<std::byte> encode(const WorkerResponse& response);

/// The header in the first bytes of a stream; nothing while fewer than sizeof(FrameHeader) bytes are there.
/// Errors: WorkerFailed when they are not a header of this version and kind.
std::optional<FrameHeader> decode_header(std::span<const std::byte> bytes, FrameKind expected);

/// The content of a whole frame. `point_count` is the number of points of the request that is being answered.
WorkerRequest decode_request(std::span<const std::byte> frame);
WorkerResponse decode_response(std::span<const std::byte> frame, std::size_t point_count);

}  // namespace tetloom::volume
