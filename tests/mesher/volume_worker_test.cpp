// What happens when the worker is missing, slow, killed or talks nonsense. Fake workers are small scripts.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <thread>

#include "mesher/volume/volume_mesher.hpp"
#include "mesher/volume/worker_process.hpp"
#include "mesher/volume/worker_protocol.hpp"
#include "tests/mesher/volume_surfaces.hpp"
#include "tests/support/in_time.hpp"
#include "tests/support/sanitized.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tetloom/tasks.hpp"

using namespace tetloom;
using namespace tetloom::volume_tests;

namespace {

namespace fs = std::filesystem;

class Folder : public test::TemporaryFolder {
 public:
  std::string script(const std::string& body) const {
    const fs::path file = path() / "worker";
    std::ofstream(file) << "#!/bin/sh\n" << body << "\n";
    fs::permissions(file, fs::perms::owner_all);
    return file.string();
  }
  void write(const std::string& name, std::span<const std::byte> bytes) const {
    std::ofstream(path() / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
};

std::vector<pid_t> children() {
  std::vector<pid_t> pids;
  for (const auto& task : fs::directory_iterator("/proc/self/task")) {
    std::ifstream list(task.path() / "children");
    for (pid_t pid; list >> pid;) pids.push_back(pid);
  }
  return pids;
}

VolumeMesh fill_cube(const std::string& worker) {
  const Surface cube = cube_surface(2);
  const SizeField sizes = SizeField::uniform(0.5);
  return fill_volume(cube.input(sizes), {worker, true}, TaskRunner(2));
}

Diagnostic only_error(const std::string& worker) {
  const VolumeMesh mesh = fill_cube(worker);
  CHECK(mesh.tet_to_vert.empty());
  CHECK(children().empty());
  REQUIRE(mesh.errors.size() == 1);
  CHECK(!mesh.errors[0].entities.empty());
  CHECK(mesh.errors[0].point);
  return mesh.errors[0];
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

// Large enough to keep the worker busy for seconds; with sanitizers it is busy longer.
const Surface& big_ball() {
  static const Surface ball = ball_surface(test::kSanitized ? 6 : 7, {0, 0, 0}, 0, [](const Vec3&) { return 1.0; });
  return ball;
}

}  // namespace

TEST_CASE("a worker that does not exist is an error that says what to do") {
  const Diagnostic error = only_error("/nowhere/tetloom-tetgen");
  CHECK(error.code == ErrorCode::WorkerFailed);
  CHECK(error.message.find("/nowhere/tetloom-tetgen") != std::string::npos);
}

TEST_CASE("a worker that is nowhere to be found is an error that says how to get it") {
  const Folder folder;
  const std::string path = std::getenv("PATH");
  ::setenv("PATH", folder.path().c_str(), 1);
  try {
    volume::find_worker("");
    FAIL("a worker was found where there is none");
  } catch (const Error& missing) {
    CHECK(missing.code() == ErrorCode::WorkerFailed);
    CHECK(std::string(missing.what()).find("libtet1.5-dev") != std::string::npos);
  }
  fs::rename(folder.script("exit 0"), folder.path() / "tetloom-tetgen");
  CHECK(volume::find_worker("") == (folder.path() / "tetloom-tetgen").string());
  ::setenv("PATH", path.c_str(), 1);
}

TEST_CASE("a file that is not a program is an error") {
  const Folder folder;
  const std::string script = folder.script("");
  std::ofstream(script, std::ios::trunc) << "not a program";
  CHECK(only_error(script).code == ErrorCode::WorkerFailed);
}

TEST_CASE("a worker that ends, fails or is killed is an error that says how") {
  const Folder folder;
  CHECK(only_error(folder.script("exit 7")).message.find("exit status 7") != std::string::npos);
  CHECK(only_error(folder.script("echo 'no licence today' >&2; exit 1")).message.find("no licence today") !=
        std::string::npos);
  CHECK(only_error(folder.script("kill -9 $$")).message.find("signal 9") != std::string::npos);
  CHECK(only_error(folder.script("kill -SEGV $$")).message.find("signal 11") != std::string::npos);
  CHECK(only_error(folder.script("exec 0<&- 1>&-; sleep 60")).code == ErrorCode::WorkerFailed);
}

TEST_CASE("a worker that talks nonsense is an error") {
  const Folder folder;
  CHECK(only_error(folder.script("echo hello; sleep 1")).code == ErrorCode::WorkerFailed);
  CHECK(only_error(folder.script("head -c 100000 /dev/zero")).code == ErrorCode::WorkerFailed);

  volume::WorkerResponse response{volume::WorkerStatus::Filled, "", {}, {{0, 1, 2, 3}}};
  auto frame = volume::encode(response);
  const auto answer = [&](const std::vector<std::byte>& bytes, const std::string& then = "") {
    folder.write("answer", bytes);
    return only_error(folder.script("cat " + (folder.path() / "answer").string() + "; " + then)).message;
  };
  CHECK(answer(frame).find("not faces of the mesh") != std::string::npos);  // well-formed, but no filling of the cube
  frame[frame.size() - 1] ^= std::byte{1};
  CHECK(answer(frame).find("checksum") != std::string::npos);
  frame.pop_back();
  CHECK(answer(frame, "exit 5").find("exit status 5") != std::string::npos);
  response.tet_to_vert[0][2] = 1234567;
  CHECK(answer(volume::encode(response)).find("does not exist") != std::string::npos);
  response = {volume::WorkerStatus::Filled, "", {{0, 0, std::nan("")}}, {}};
  CHECK(answer(volume::encode(response)).find("not finite") != std::string::npos);
  volume::FrameHeader header;
  header.kind = volume::FrameKind::Response;
  header.version = 99;
  std::vector<std::byte> other_version(sizeof header);
  std::memcpy(other_version.data(), &header, sizeof header);
  CHECK(answer(other_version, "sleep 5").find("version 99") != std::string::npos);
  header.version = volume::FrameHeader::kVersion;
  header.payload_size = ~std::uint64_t{0};
  std::memcpy(other_version.data(), &header, sizeof header);
  CHECK(answer(other_version, "sleep 5").find("header") != std::string::npos);
}

TEST_CASE("requests and responses survive the way there and back, and nothing shorter does") {
  const volume::WorkerRequest request{"pYQ", {{1, 2, 3}, {4, 5, 6}, {7, 8, 1e300}}, {{0, 1, 2}}};
  const auto frame = volume::encode(request);
  const auto back = volume::decode_request(frame);
  CHECK(back.switches == request.switches);
  CHECK(back.points == request.points);
  CHECK(back.tri_to_vert == request.tri_to_vert);
  for (std::size_t length = 0; length < frame.size(); ++length) {
    CHECK_THROWS_AS(volume::decode_request(std::span(frame).first(length)), Error);
  }
}

TEST_CASE("a worker killed from outside is an error at once, and no second one is started") {
  const SizeField sizes = SizeField::uniform(0.02);
  const Surface& ball = big_ball();
  std::jthread killer([] {
    for (int i = 0; i < 2000; ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
      if (const auto pids = children(); !pids.empty()) {
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        for (const pid_t pid : pids) ::kill(pid, SIGKILL);
        return;
      }
    }
  });
  const VolumeMesh mesh = fill_volume(ball.input(sizes), {TETLOOM_WORKER, true}, TaskRunner(2));
  REQUIRE(mesh.errors.size() == 1);
  CHECK(mesh.errors[0].code == ErrorCode::WorkerFailed);
  CHECK(mesh.errors[0].message.find("signal 9") != std::string::npos);
  CHECK(mesh.tet_to_vert.empty());
  CHECK(children().empty());
}

TEST_CASE("cancelling ends a busy worker within a second and leaves no process") {
  // The worker would take minutes.
  const SizeField sizes = SizeField::uniform(test::kSanitized ? 0.016 : 0.008);
  const Surface& ball = big_ball();
  CHECK(test::in_time([&] {
    CancelToken token;
    std::chrono::steady_clock::time_point cancelled_at;
    std::jthread canceller([&] {
      for (int i = 0; i < 4000 && children().empty(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      cancelled_at = std::chrono::steady_clock::now();
      token.cancel();
    });
    const TaskRunner runner(2, Host{{}, &token});
    try {
      fill_volume(ball.input(sizes), {TETLOOM_WORKER, true}, runner);
      FAIL("the run was not cancelled");
    } catch (const Error& error) {
      CHECK(error.code() == ErrorCode::Cancelled);
    }
    canceller.join();
    CHECK(children().empty());
    return seconds_since(cancelled_at) < 1;
  }));
}

TEST_CASE("cancelling ends a worker that hangs without reading or writing") {
  const Folder folder;
  const SizeField sizes = SizeField::uniform(0.5);
  const std::string worker = folder.script("trap '' TERM INT; while :; do sleep 1; done");
  CHECK(test::in_time([&] {
    CancelToken token;
    std::jthread canceller([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      token.cancel();
    });
    const auto start = std::chrono::steady_clock::now();
    const TaskRunner runner(2, Host{{}, &token});
    CHECK_THROWS_AS(fill_volume(cube_surface(40).input(sizes), {worker, true}, runner), Error);
    return seconds_since(start) < 1.3;
  }));
}

TEST_CASE("a worker whose host goes away ends by itself") {
  // The host is a child of this test that is killed while its worker works. It allocates little and starts no thread.
  volume::WorkerRequest request{"pYMQJzO4/7", big_ball().points, big_ball().tri_to_vert};
  const auto frame = volume::encode(request);
  const TaskRunner runner(1);
  const pid_t host = ::fork();
  if (host == 0) {
    volume::run_worker(TETLOOM_WORKER, frame, runner);
    ::_exit(0);
  }
  const auto workers = [&] {
    std::vector<pid_t> pids;
    std::ifstream list("/proc/" + std::to_string(host) + "/task/" + std::to_string(host) + "/children");
    for (pid_t pid; list >> pid;) pids.push_back(pid);
    return pids;
  };
  std::vector<pid_t> pids;
  for (int i = 0; i < 4000 && (pids = workers()).empty(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  REQUIRE(!pids.empty());
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  ::kill(host, SIGKILL);
  ::waitpid(host, nullptr, 0);
  const auto is_alive = [](pid_t pid) {
    std::ifstream status("/proc/" + std::to_string(pid) + "/stat");
    std::string id, name, state;
    return bool(status >> id >> name >> state) && state != "Z";
  };
  bool alive = true;
  for (int i = 0; i < 400 && alive; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    alive = is_alive(pids[0]);
  }
  CHECK_FALSE(alive);
}
