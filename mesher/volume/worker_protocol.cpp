#include "mesher/volume/worker_protocol.hpp"

#include <algorithm>
#include <bit>
#include <cstring>
#include <type_traits>

#include "tetloom/error.hpp"

namespace tetloom::volume {

namespace {

[[noreturn]] void refuse(const std::string& why) {
  throw Error(ErrorCode::WorkerFailed, "malformed message between the library and its volume worker: " + why);
}

// Multiply-and-rotate over 64-bit words: finds truncation and corruption, not malice.
std::uint64_t checksum(std::span<const std::byte> bytes) {
  std::uint64_t sum = 0x9e3779b97f4a7c15u ^ bytes.size();
  for (std::size_t at = 0; at < bytes.size(); at += sizeof(std::uint64_t)) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + at, std::min(sizeof word, bytes.size() - at));
    sum = std::rotl((sum ^ word) * 0xff51afd7ed558ccdu, 29);
  }
  return sum;
}

class Writer {
 public:
  explicit Writer(std::size_t payload_size) { bytes_.reserve(sizeof(FrameHeader) + payload_size); }

  template <class T>
  void value(const T& item) {
    append(std::as_bytes(std::span(&item, 1)));
  }
  template <class Range>
  void list(const Range& items) {
    static_assert(std::is_trivially_copyable_v<typename Range::value_type>);
    value(static_cast<std::uint64_t>(items.size()));
    append(std::as_bytes(std::span(items)));
  }
  std::vector<std::byte> finish(FrameKind kind) {
    FrameHeader header;
    const std::span<const std::byte> payload = std::span(bytes_).subspan(sizeof header);
    header.kind = kind;
    header.payload_size = payload.size();
    header.checksum = checksum(payload);
    std::memcpy(bytes_.data(), &header, sizeof header);
    return std::move(bytes_);
  }

 private:
  void append(std::span<const std::byte> more) { bytes_.insert(bytes_.end(), more.begin(), more.end()); }
  std::vector<std::byte> bytes_ = std::vector<std::byte>(sizeof(FrameHeader));
};

class Reader {
 public:
  explicit Reader(std::span<const std::byte> payload) : rest_(payload) {}

  template <class T>
  T value() {
    if (rest_.size() < sizeof(T)) refuse("it ends early");
    T item;
    std::memcpy(&item, rest_.data(), sizeof item);
    rest_ = rest_.subspan(sizeof item);
    return item;
  }
  template <class Range>
  Range list() {
    using Item = typename Range::value_type;
    const auto count = value<std::uint64_t>();
    if (count > rest_.size() / sizeof(Item)) refuse("a list is longer than the message");
    Range items(count, Item{});
    if (count > 0) std::memcpy(items.data(), rest_.data(), count * sizeof(Item));
    rest_ = rest_.subspan(count * sizeof(Item));
    return items;
  }
  void finish() const {
    if (!rest_.empty()) refuse("it has bytes left over");
  }

 private:
  std::span<const std::byte> rest_;
};

std::span<const std::byte> checked_payload(std::span<const std::byte> frame, FrameKind kind) {
  const auto header = decode_header(frame, kind);
  if (!header || frame.size() - sizeof *header != header->payload_size) refuse("its length is wrong");
  const auto payload = frame.subspan(sizeof *header);
  if (checksum(payload) != header->checksum) refuse("its checksum is wrong");
  return payload;
}

void check_finite(std::span<const Vec3> points) {
  if (!std::all_of(points.begin(), points.end(), is_finite)) refuse("a coordinate is not finite");
}

template <std::size_t N>
void check_indices(std::span<const std::array<std::uint32_t, N>> elements, std::size_t point_count) {
  for (const auto& element : elements) {
    for (const std::uint32_t vertex : element) {
      if (vertex >= point_count) refuse("an element refers to a point that does not exist");
    }
  }
}

}  // namespace

std::vector<std::byte> encode(const WorkerRequest& request) {
  Writer writer(request.points.size() * sizeof(Vec3) + request.tri_to_vert.size() * 12 + 1024);
  writer.list(request.switches);
  writer.list(request.points);
  writer.list(request.tri_to_vert);
  return writer.finish(FrameKind::Request);
}

std::vector<std::byte> encode(const WorkerResponse& response) {
  Writer writer(response.new_points.size() * sizeof(Vec3) + response.tet_to_vert.size() * 16 + 1024);
  writer.value(response.status);
  writer.list(response.message);
  writer.list(response.new_points);
  writer.list(response.tet_to_vert);
  return writer.finish(FrameKind::Response);
}

std::optional<FrameHeader> decode_header(std::span<const std::byte> bytes, FrameKind expected) {
  FrameHeader header;
  if (bytes.size() < sizeof header) return std::nullopt;
  std::memcpy(&header, bytes.data(), sizeof header);
  if (header.magic != FrameHeader::kMagic) refuse("it does not begin as one");
  if (header.version != FrameHeader::kVersion) {
    refuse("version " + std::to_string(header.version) + " where " + std::to_string(FrameHeader::kVersion) +
           " is spoken: the worker is of another release");
  }
  if (header.kind != expected || header.payload_size > FrameHeader::kLargestPayload) refuse("its header is wrong");
  return header;
}

WorkerRequest decode_request(std::span<const std::byte> frame) {
  Reader reader(checked_payload(frame, FrameKind::Request));
  WorkerRequest request;
  request.switches = reader.list<std::string>();
  request.points = reader.list<std::vector<Vec3>>();
  request.tri_to_vert = reader.list<std::vector<std::array<std::uint32_t, 3>>>();
  reader.finish();
  check_finite(request.points);
  check_indices<3>(request.tri_to_vert, request.points.size());
  return request;
}

WorkerResponse decode_response(std::span<const std::byte> frame, std::size_t point_count) {
  Reader reader(checked_payload(frame, FrameKind::Response));
  WorkerResponse response;
  response.status = reader.value<WorkerStatus>();
  response.message = reader.list<std::string>();
  response.new_points = reader.list<std::vector<Vec3>>();
  response.tet_to_vert = reader.list<std::vector<std::array<std::uint32_t, 4>>>();
  reader.finish();
  check_finite(response.new_points);
  check_indices<4>(response.tet_to_vert, point_count + response.new_points.size());
  return response;
}

}  // namespace tetloom::volume
