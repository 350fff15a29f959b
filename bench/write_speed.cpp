// The claim: a mesh of 5 million tets is written at 300 MB/s and more in binary formats, at 100 MB/s and more in text.
// What is read is read back, with its speed. One process, formats in turn, each file removed before the next; the
// median of the runs counts.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "bench/support/command_line.hpp"
#include "bench/support/commit.hpp"
#include "bench/support/lattice_part.hpp"
#include "bench/support/machine.hpp"
#include "bench/support/temporary_folder.hpp"
#include "core/part/convert.hpp"
#include "tetloom/check.hpp"
#include "tetloom/io.hpp"
#include "tetloom/tasks.hpp"

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string solid = "bracket", folder, json_path;
  double tets = 5e6;
  int threads = 0, runs = 3;
  std::vector<std::string> formats;
  bool quick = false;
};

struct FileFormat {
  std::string name, file;
  bool is_text = false;
  WriteOptions options;
};

const std::vector<FileFormat> kFormats{{"vtu", "mesh.vtu", false, {}},
                                       {"msh", "mesh.msh", false, {}},
                                       {"msh2", "mesh2.msh", false, {.msh_2_2 = true, .text = false}},
                                       {"meshb", "mesh.meshb", false, {}},
                                       {"med", "mesh.med", false, {}},
                                       {"cgns", "mesh.cgns", false, {}},
                                       {"vtkhdf", "mesh.vtkhdf", false, {}},
                                       {"exo", "mesh.exo", false, {}},
                                       {"lb8.ugrid", "mesh.lb8.ugrid", false, {}},
                                       {"msh2-text", "mesh3.msh", true, {.msh_2_2 = true, .text = true}},
                                       {"mesh", "mesh.mesh", true, {}},
                                       {"inp", "mesh.inp", true, {}},
                                       {"bdf", "mesh.bdf", true, {}},
                                       {"su2", "mesh.su2", true, {}},
                                       {"ugrid", "mesh.ugrid", true, {}},
                                       {"polyMesh", "polyMesh", true, {}}};

/// Wall time and processor time of all threads.
struct Times {
  double wall = 0, cpu = 0;
};

double cpu_seconds() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& time) {
    return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
  };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

template <class Work>
Times time_of(const Work& work) {
  const auto start = Clock::now();
  const double cpu = cpu_seconds();
  work();
  return {std::chrono::duration<double>(Clock::now() - start).count(), cpu_seconds() - cpu};
}

Times median(std::vector<Times> times) {
  const auto middle = [&](double Times::*member) {
    std::ranges::sort(times, {}, member);
    return times[times.size() / 2].*member;
  };
  return {middle(&Times::wall), middle(&Times::cpu)};
}

std::uint64_t size_of(const fs::path& path) {
  if (!fs::is_directory(path)) return fs::file_size(path);
  std::uint64_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(path))
    if (entry.is_regular_file()) bytes += entry.file_size();
  return bytes;
}

class Bench {
 public:
  explicit Bench(const Options& options)
      : options_(options), runner_(options.threads), mesh_(make_mesh(make_lattice_part(options.solid, options.tets))) {}

  void run() {
    const Machine machine = describe_machine();
    std::printf("write_speed, commit %s\n%s, %d threads, load %.1f, folder %s\n%zu tets, %zu points\n\n", kCommit,
                machine.processor.c_str(), runner_.threads(), load_average(), folder().c_str(),
                mesh_.tet_to_vert.size(), mesh_.points.size());
    std::printf("%-10s %6s %8s %9s %8s %9s %9s\n", "format", "", "MB", "write s", "cpu s", "MB/s", "read MB/s");
    for (const FileFormat& format : kFormats)
      if (options_.formats.empty() || std::ranges::count(options_.formats, format.name) > 0) measure(format);
    if (!options_.json_path.empty())
      std::ofstream(options_.json_path) << nlohmann::json{
          {"commit", kCommit},
          {"date", today()},
          {"processor", machine.processor},
          {"threads", runner_.threads()},
          {"tets", mesh_.tet_to_vert.size()},
          {"formats", report_}}.dump(2);
  }

 private:
  fs::path folder() const { return options_.folder.empty() ? own_.path() : fs::path(options_.folder); }

  void measure(const FileFormat& format) {
    const fs::path path = folder() / format.file;
    const bool is_read = is_mesh_extension(path);
    std::vector<Times> writes, reads;
    double megabytes = 0;
    for (int run = 0; run < options_.runs; ++run) {
      fs::remove_all(path);
      writes.push_back(time_of([&] { write_mesh(mesh_, path, format.options, nullptr, runner_); }));
      megabytes = 1e-6 * static_cast<double>(size_of(path));
      if (is_read) reads.push_back(time_of([&] { read_back(path); }));
    }
    fs::remove_all(path);
    const Times write = median(writes);
    nlohmann::json figures{
        {"format", format.name},       {"text", format.is_text},         {"MB", megabytes},
        {"write_seconds", write.wall}, {"write_cpu_seconds", write.cpu}, {"write_MB_per_s", megabytes / write.wall}};
    std::printf("%-10s %6s %8.0f %9.2f %8.2f %9.0f ", format.name.c_str(), format.is_text ? "text" : "binary",
                megabytes, write.wall, write.cpu, megabytes / write.wall);
    if (is_read) figures["read_MB_per_s"] = megabytes / median(reads).wall;
    is_read ? std::printf("%9.0f\n", megabytes / median(reads).wall) : std::printf("%9s\n", "-");
    std::fflush(stdout);
    report_.push_back(std::move(figures));
  }

  void read_back(const fs::path& path) const {
    if (read_mesh(path).tet_to_vert.size() != mesh_.tet_to_vert.size())
      throw std::runtime_error("'" + path.string() + "' came back with another number of tets");
  }

  Options options_;
  TaskRunner runner_;
  Mesh mesh_;
  TemporaryFolder own_;
  nlohmann::json report_ = nlohmann::json::array();
};

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) {
  using namespace tetloom::bench;
  Options options;
  CommandLine line("Measures how fast a mesh is written and read in each format.");
  line.add("--solid", options.solid, "ball, drilled-block or bracket");
  line.add("--tets", options.tets, "about how many").positive();
  line.add("--threads", options.threads, "0: all cores");
  line.add("--runs", options.runs, "of each format").positive();
  line.add("--formats", options.formats, "only these, by the names of the table");
  line.add("--folder", options.folder, "where the files go; default: a temporary folder");
  line.add("--json", options.json_path, "where to write all figures");
  line.add_flag("--quick", options.quick, "a small mesh once, to see that the bench runs");
  if (const auto status = line.parse(argc, argv)) return *status;
  if (options.quick) options.tets = 20e3, options.runs = 1;
  try {
    Bench(options).run();
  } catch (const std::exception& error) {
    std::fprintf(stderr, "write_speed: %s\n", error.what());
    return 1;
  }
}
