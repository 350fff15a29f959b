// tetloom-tetgen: fills one closed surface with tetrahedra by TetGen, as a process of its own.
//
// It reads one request from descriptor 0, writes one response to the same descriptor and ends. TetGen prints, asserts
// and is not thread-safe; here none of that can hurt the program that asked. It ends at once when that program goes
// away.
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <tetgen.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <new>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "mesher/volume/worker_protocol.hpp"
#include "tetloom/error.hpp"

namespace {

using namespace tetloom;
using namespace tetloom::volume;

// Moves the channel away from the standard streams and gives those to nobody, so that what TetGen prints is lost.
int take_channel() {
  const int channel = ::fcntl(0, F_DUPFD_CLOEXEC, 10);
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  if (channel < 0 || nowhere < 0) return -1;
  ::dup2(nowhere, 0);
  ::dup2(nowhere, 1);
  return channel;
}

std::vector<std::byte> read_request(int channel) {
  std::vector<std::byte> bytes;
  std::array<std::byte, 1 << 16> block;
  for (;;) {
    const auto header = decode_header(bytes, FrameKind::Request);
    if (header && bytes.size() >= sizeof *header + header->payload_size) return bytes;
    const ssize_t got = ::read(channel, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw Error(ErrorCode::WorkerFailed, "the request ends early");
    bytes.insert(bytes.end(), block.begin(), block.begin() + got);
  }
}

bool write_response(int channel, const WorkerResponse& response) {
  const std::vector<std::byte> bytes = encode(response);
  for (std::size_t at = 0; at < bytes.size();) {
    const ssize_t sent = ::send(channel, bytes.data() + at, bytes.size() - at, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += static_cast<std::size_t>(sent);
  }
  return true;
}

// Nobody waits for the result once the other end is closed.
void end_with_host(int channel) {
  std::thread([channel] {
    for (;;) {
      pollfd entry{channel, POLLRDHUP, 0};
      if (::poll(&entry, 1, -1) > 0) ::_exit(3);
    }
  }).detach();
}

void fill_input(const WorkerRequest& request, tetgenio& input) {
  input.firstnumber = 0;
  input.numberofpoints = static_cast<int>(request.points.size());
  input.pointlist = new REAL[request.points.size() * 3];
  std::memcpy(input.pointlist, request.points.data(), request.points.size() * sizeof(Vec3));
  const std::size_t count = request.tri_to_vert.size();
  input.numberoffacets = static_cast<int>(count);
  input.facetlist = new tetgenio::facet[count];
  input.facetmarkerlist = new int[count];
  for (std::size_t i = 0; i < count; ++i) {
    tetgenio::facet& facet = input.facetlist[i];
    tetgenio::init(&facet);
    facet.numberofpolygons = 1;
    facet.polygonlist = new tetgenio::polygon[1];
    facet.polygonlist[0].numberofvertices = 3;
    facet.polygonlist[0].vertexlist = new int[3];
    std::copy(request.tri_to_vert[i].begin(), request.tri_to_vert[i].end(), facet.polygonlist[0].vertexlist);
    input.facetmarkerlist[i] = static_cast<int>(i) + 1;
  }
}

WorkerResponse filled_response(const tetgenio& output, std::size_t given_points) {
  WorkerResponse response;
  const auto point_count = static_cast<std::size_t>(std::max(output.numberofpoints, 0));
  if (point_count < given_points || output.numberofcorners != 4) {
    response.message = "TetGen lost points";
    return response;
  }
  response.status = WorkerStatus::Filled;
  response.new_points.reserve(point_count - given_points);
  for (std::size_t i = given_points; i < point_count; ++i) {
    const REAL* point = output.pointlist + 3 * i;
    response.new_points.push_back({point[0], point[1], point[2]});
  }
  response.tet_to_vert.resize(static_cast<std::size_t>(output.numberoftetrahedra));
  const int* corner = output.tetrahedronlist;
  for (auto& tet : response.tet_to_vert) {
    for (std::uint32_t& vertex : tet) vertex = static_cast<std::uint32_t>(*corner++);
  }
  return response;
}

WorkerResponse refusal(int code) {
  switch (code) {
    case 1: return {WorkerStatus::OutOfMemory, "TetGen ran out of memory", {}, {}};
    case 3: return {WorkerStatus::SelfIntersection, "TetGen found that the surface crosses itself", {}, {}};
    case 4: return {WorkerStatus::SmallFeature, "TetGen found a feature too small for its tolerance", {}, {}};
    case 5: return {WorkerStatus::NearlyCoplanar, "TetGen found two facets that nearly coincide", {}, {}};
    case 10: return {WorkerStatus::BadInput, "TetGen refused its input", {}, {}};
    default: return {WorkerStatus::InternalError, "TetGen met an internal error", {}, {}};
  }
}

WorkerResponse run_tetgen(const WorkerRequest& request) {
  try {
    tetgenio input, output;
    fill_input(request, input);
    tetgenbehavior behavior;
    std::string switches = request.switches;
    if (!behavior.parse_commandline(switches.data())) return refusal(10);
    tetrahedralize(&behavior, &input, &output);
    return filled_response(output, request.points.size());
  } catch (int code) {
    return refusal(code);
  } catch (const std::bad_alloc&) {
    return refusal(1);
  }
}

}  // namespace

int main() {
  const int channel = take_channel();
  if (channel < 0) return 2;
  try {
    const WorkerRequest request = decode_request(read_request(channel));
    end_with_host(channel);
    const bool written = write_response(channel, run_tetgen(request));
    // Freeing TetGen's pools takes time that somebody may be waiting for.
    ::_exit(written ? 0 : 3);
  } catch (const std::exception& error) {
    const std::string text = std::string(error.what()) + "\n";
    [[maybe_unused]] const ssize_t ignored = ::write(2, text.data(), text.size());
    return 2;
  }
}
