// The claim: with 2 threads tetloom deals a mesh of 20 million tets to 16 parts at 3 million tets a second or more, 1.7
// times as fast as with one, within 1.5 times the memory of the mesh; parts differ by 3 % at most and cut no more than
// 1.1 times the faces that Scotch cuts; and 64 parts become 16,384. Two MPI ranks take at most 1.5 times as long as two
// threads. Each run is a process of its own.
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench/support/child_process.hpp"
#include "bench/support/command_line.hpp"
#include "bench/support/commit.hpp"
#include "bench/support/lattice_part.hpp"
#include "bench/support/machine.hpp"
#include "bench/support/temporary_folder.hpp"
#include "core/part/convert.hpp"
#include "tetloom/io.hpp"
#include "tetloom/partition.hpp"
#include "tetloom/tasks.hpp"
#include "threading/comm/collectives.hpp"
#ifdef TETLOOM_HAS_MPI
#include "tetloom/communicator.hpp"
#endif

namespace tetloom::bench {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

struct Options {
  std::string solid = "bracket";
  double tets = 20e6, peer_tets = 2e6;
  std::vector<std::string> peer_solids{"ball", "drilled-block", "bracket"};
  std::vector<int> threads{1, 2};
  std::vector<int> ranks;
  int runs = 3;
  bool quick = false, no_peer = false, only_peer = false;
  std::string json_path, trace_path;
  std::string measure;  ///< a task, when this process is one of the measured ones
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// From here on the peak of resident memory is counted anew.
void reset_peak() {
  std::ofstream file("/proc/self/clear_refs");
  file << 5;
}

/// Global ids are the vertices' own, so that the parts link up at home.
PartitionedMesh make_mesh_in_one_part(Communicator& communicator, const std::string& solid, double tets) {
  PartitionedMesh mesh(communicator, 1);
  const bool is_file = fs::exists(solid);
  run_on_first(communicator, [&] {
    mesh.parts.at(PartId(0)).mesh = is_file ? make_part(read_mesh(solid)) : make_lattice_part(solid, tets);
  });
  return mesh;
}

void split(PartitionedMesh& mesh, std::size_t part_count, const TaskRunner& runner) {
  migrate(mesh, compute_destinations(mesh, {part_count, PartitionMethod::Rcb, {}, 0.03, true}, runner), part_count,
          runner);
}

std::size_t memory_of_all(const PartitionedMesh& mesh) {
  std::size_t bytes = 0;
  for (const PartId part : mesh.local()) bytes += memory_of(mesh.parts.at(part).mesh);
  return bytes;
}

/// Cut faces and balance, from the parts as they are.
nlohmann::json describe_parts(const PartitionedMesh& mesh) {
  const PartsFigures figures = measure_parts(mesh);
  return {{"cut_faces", figures.cut_faces},
          {"imbalance", figures.element_imbalance},
          {"vertex_imbalance", figures.vertex_imbalance},
          {"neighbors", 2 * static_cast<double>(figures.edges) / static_cast<double>(mesh.part_count())},
          {"tets", figures.elements}};
}

/// `bytes` of all ranks.
double sum_bytes(Communicator& communicator, double bytes) {
  std::array<std::int64_t, 1> sum{static_cast<std::int64_t>(bytes)};
  communicator.sum(sum);
  return static_cast<double>(sum[0]);
}

/// One measured run: `from` parts become `to`. On several ranks all of them call it; the slowest one's clock counts.
nlohmann::json measure(const nlohmann::json& task, Communicator& communicator) {
  const auto from = task.at("from").get<std::size_t>(), to = task.at("to").get<std::size_t>();
  PartitionedMesh mesh = make_mesh_in_one_part(communicator, task.at("solid"), task.at("tets"));
  if (from > 1) split(mesh, from, TaskRunner(0));
  const TaskRunner runner(task.at("threads").get<int>());
  const auto mesh_bytes = static_cast<double>(memory_of_all(mesh));
  reset_peak();
  const double before = static_cast<double>(resident_bytes());
  Trace trace;
  const auto start = Clock::now();
  PerPart<Destinations> destinations =
      compute_destinations(mesh, {to, PartitionMethod::Multilevel, {}, 0.03, true}, runner);
  const double deal_seconds = seconds_since(start);
  const MigrationFigures moved = migrate(mesh, std::move(destinations), to, runner, &trace);
  std::array<double, 1> seconds{seconds_since(start)};
  communicator.max(seconds);
  const double peak = static_cast<double>(peak_resident_bytes()) - before + mesh_bytes;
  nlohmann::json result = describe_parts(mesh);
  result["seconds"] = seconds[0];
  result["deal_seconds"] = deal_seconds;
  result["bytes_sent"] = moved.bytes_sent;
  result["mesh_bytes"] = sum_bytes(communicator, mesh_bytes);
  result["peak_bytes"] = sum_bytes(communicator, peak);
  if (task.contains("trace") && communicator.rank() == 0) trace.write(task.at("trace").get<std::string>());
  if (task.value("validate", false)) result["valid"] = validate_parts(mesh, TaskRunner(0)).valid();
  return result;
}

/// Measures in this process, which may be one of several ranks; the first prints what came out.
void measure_and_print(const nlohmann::json& task, int& argc, char**& argv) {
  const auto print = [](const nlohmann::json& result) { std::printf("%s\n", result.dump().c_str()); };
  if (!task.contains("ranks")) return print(measure(task, *make_thread_communicator()));
#ifdef TETLOOM_HAS_MPI
  const MpiSession mpi(argc, argv);
  const auto communicator = make_mpi_communicator();
  const nlohmann::json result = measure(task, *communicator);
  if (communicator->rank() == 0) print(result);
#else
  static_cast<void>(argc), static_cast<void>(argv);
  throw std::runtime_error("this build has no MPI");
#endif
}

/// One way to run a case: threads of one process, or ranks with one thread each.
struct Way {
  int threads = 1;
  std::optional<int> ranks;

  std::string name() const {
    return ranks ? std::to_string(*ranks) + " ranks"
                 : std::to_string(threads) + (threads == 1 ? " thread" : " threads");
  }
};

class Bench {
 public:
  explicit Bench(const Options& options) : options_(options), program_(fs::read_symlink("/proc/self/exe")) {}

  void run() {
    print_heading();
    std::printf("%-14s %10s %7s %7s %4s %8s %8s %9s %7s %7s %7s %9s %7s %9s\n", "solid", "tets", "from", "to", "by",
                "s", "deal s", "M tets/s", "B/tet", "x mesh", "GB sent", "cut", "imbal%", "neighb.");
    const std::vector<std::pair<std::size_t, std::size_t>> cases =
        options_.quick ? std::vector<std::pair<std::size_t, std::size_t>>{{1, 16}, {8, 64}}
                       : std::vector<std::pair<std::size_t, std::size_t>>{{1, 16}, {64, 16384}};
    if (!options_.only_peer)
      for (const auto& [from, to] : cases) measure_case(from, to);
    if (!options_.no_peer) compare_cuts();
    if (!options_.json_path.empty()) std::ofstream(options_.json_path) << report_.dump(2) << '\n';
  }

 private:
  void print_heading() const {
    const Machine machine = describe_machine();
    std::printf(
        "partition_speed, commit %s\n%s, %d cores, %.1f GiB, %s\n%d runs each in alternation, the median "
        "counts; load before %.2f\n\n",
        kCommit, machine.processor.c_str(), machine.cores, static_cast<double>(machine.memory) / (1 << 30),
        machine.system.c_str(), options_.runs, load_average());
    std::fflush(stdout);
  }

  nlohmann::json run_apart(const nlohmann::json& task) const {
    std::vector<std::string> command{program_, "--measure", task.dump()};
    if (task.contains("ranks")) {
      const std::string ranks = std::to_string(task.at("ranks").get<int>());
      command.insert(command.begin(), {"mpirun", "--bind-to", "none", "-n", ranks});
    }
    const ChildResult child = run_child(command);
    if (child.exit_status != 0) throw std::runtime_error("a measured run failed: " + child.output);
    return nlohmann::json::parse(child.output.substr(std::min(child.output.find('{'), child.output.size())));
  }

  void measure_case(std::size_t from, std::size_t to) {
    std::vector<Way> ways;
    for (const int threads : options_.threads) ways.push_back({threads, {}});
    for (const int ranks : options_.ranks) ways.push_back({1, ranks});
    std::vector<std::vector<nlohmann::json>> results(ways.size());
    for (int run = 0; run < options_.runs; ++run) {
      for (std::size_t i = 0; i < results.size(); ++i) {
        nlohmann::json task{{"solid", options_.solid},
                            {"tets", options_.tets},
                            {"from", from},
                            {"to", to},
                            {"threads", ways[i].threads}};
        if (ways[i].ranks) task["ranks"] = *ways[i].ranks;
        if (run == 0) task["validate"] = true;
        if (!options_.trace_path.empty()) task["trace"] = options_.trace_path;
        results[i].push_back(run_apart(task));
        if (run == 0 && !results[i][0].at("valid").get<bool>()) throw std::runtime_error("the parts are not valid");
      }
    }
    std::vector<double> seconds;
    for (std::size_t i = 0; i < results.size(); ++i) {
      std::sort(results[i].begin(), results[i].end(), [](const auto& a, const auto& b) {
        return a.at("seconds").template get<double>() < b.at("seconds").template get<double>();
      });
      const nlohmann::json& median = results[i][results[i].size() / 2];
      print_line(from, to, ways[i], median);
      report_.push_back({{"from", from}, {"to", to}, {"threads", ways[i].threads}, {"median", median}});
      if (ways[i].ranks) report_.back()["ranks"] = *ways[i].ranks;
      seconds.push_back(median.at("seconds"));
    }
    compare(ways, seconds);
    std::fflush(stdout);
  }

  /// Threads with the first number of them, ranks with as many threads.
  static void compare(const std::vector<Way>& ways, const std::vector<double>& seconds) {
    for (std::size_t i = 1; i < ways.size(); ++i) {
      if (!ways[i].ranks) {
        std::printf("%s are %.2f times as fast as %s (asked of 2 from 1 to 16 parts: 1.70)\n", ways[i].name().c_str(),
                    seconds[0] / seconds[i], ways[0].name().c_str());
        continue;
      }
      for (std::size_t j = 0; j < i; ++j)
        if (!ways[j].ranks && ways[j].threads == *ways[i].ranks)
          std::printf("%s take %.2f times as long as %s (asked of 2 from 1 to 16 parts: 1.50 at most)\n",
                      ways[i].name().c_str(), seconds[i] / seconds[j], ways[j].name().c_str());
    }
  }

  void print_line(std::size_t from, std::size_t to, const Way& way, const nlohmann::json& r) const {
    const double tets = r.at("tets"), seconds = r.at("seconds"), peak = r.at("peak_bytes");
    std::printf("%-14s %10.0f %7zu %7zu %s%3d %8.2f %8.2f %9.2f %7.1f %7.2f %7.2f %9d %7.2f %9.1f\n",
                options_.solid.c_str(), tets, from, to, way.ranks ? "r" : "t", way.ranks.value_or(way.threads), seconds,
                r.at("deal_seconds").get<double>(), 1e-6 * tets / seconds, peak / tets,
                peak / r.at("mesh_bytes").get<double>(), 1e-9 * r.at("bytes_sent").get<double>(),
                r.at("cut_faces").get<int>(), 100 * r.at("imbalance").get<double>(), r.at("neighbors").get<double>());
  }

  /// Cuts of the same meshes by Scotch, in this process, and by mpmetis where it is installed.
  void compare_cuts() {
    std::printf("\n%-14s %10s %9s %9s %7s %9s %7s\n", "solid", "tets", "tetloom", "Scotch", "ratio", "mpmetis",
                "ratio");
    for (const std::string& solid : options_.peer_solids) {
      const auto communicator = make_thread_communicator();
      const PartitionedMesh mesh = make_mesh_in_one_part(*communicator, solid, options_.peer_tets);
      const PartMesh& part = mesh.parts.at(PartId(0)).mesh;
      const double own = cut_of(mesh, PartitionMethod::Multilevel), scotch = cut_of(mesh, PartitionMethod::Scotch);
      const double metis = cut_of_metis(part);
      std::printf("%-14s %10zu %9.0f %9.0f %7.3f %9.0f %7.3f\n", fs::path(solid).stem().string().substr(0, 14).c_str(),
                  part.cell_count(), own, scotch, own / scotch, metis, metis > 0 ? own / metis : 0);
      std::fflush(stdout);
      report_.push_back({{"solid", solid}, {"cut", own}, {"cut_scotch", scotch}, {"cut_mpmetis", metis}});
    }
  }

  static double cut_of(const PartitionedMesh& mesh, PartitionMethod method) {
    const PartMesh& part = mesh.parts.at(PartId(0)).mesh;
    PerPart<Destinations> destinations = compute_destinations(mesh, {16, method, {}, 0.03, true}, TaskRunner(0));
    const Destinations& targets = destinations.at(PartId(0));
    const auto& neighbors = part.block(CellKind::Tet).to_neighbor;
    std::size_t cut = 0;
    for (std::size_t i = 0; i < neighbors.size(); ++i)
      cut += neighbors[i].valid() && targets[neighbors[i].cell()] != targets[i / 4] ? 1 : 0;
    return static_cast<double>(cut / 2);
  }

  /// 0 where it is not installed.
  static double cut_of_metis(const PartMesh& part) {
    if (!is_installed("mpmetis")) return 0;
    const TemporaryFolder folder;
    const std::string file = folder.path() / "mesh";
    {
      std::ofstream out(file);
      const auto& verts = part.block(CellKind::Tet).to_vert;
      out << verts.size() / 4 << '\n';
      for (std::size_t i = 0; i < verts.size(); ++i) out << verts[i] + 1 << (i % 4 == 3 ? '\n' : ' ');
    }
    const ChildResult child = run_child({"mpmetis", "-gtype=dual", "-ncommon=3", file, "16"});
    const std::size_t at = child.output.find("Edgecut:");
    return at == std::string::npos ? 0 : std::stod(child.output.substr(at + 8));
  }

  Options options_;
  std::string program_;
  nlohmann::json report_ = nlohmann::json::array();
};

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) {
  using namespace tetloom::bench;
  Options options;
  CommandLine line("Measures how fast, how small and how well a mesh is dealt to parts.");
  line.add("--solid", options.solid, "ball, drilled-block or bracket");
  line.add("--tets", options.tets, "about how many tets").positive();
  line.add("--peer-tets", options.peer_tets, "about how many tets where cuts are compared with others'").positive();
  line.add("--peer-solids", options.peer_solids, "solids or mesh files where cuts are compared");
  line.add_flag("--only-peer", options.only_peer, "compare cuts, and measure no speed");
  line.add("--threads", options.threads, "numbers of threads");
  line.add("--ranks", options.ranks, "numbers of MPI ranks with one thread each, started by mpirun, beside threads");
  line.add("--runs", options.runs, "of each case").positive();
  line.add("--json", options.json_path, "where to write all figures");
  line.add("--trace", options.trace_path, "where to write the tasks of the last run, for a trace viewer");
  line.add_flag("--no-peer", options.no_peer, "do not compare cuts");
  line.add_flag("--quick", options.quick, "a small case once, to see that the bench runs");
  line.add("--measure", options.measure, "").hidden();
  if (const auto status = line.parse(argc, argv)) return *status;
  if (options.quick) {
    options.tets = options.peer_tets = 50e3;
    options.runs = 1;
  }
  try {
    if (!options.measure.empty()) {
      measure_and_print(nlohmann::json::parse(options.measure), argc, argv);
    } else {
      Bench(options).run();
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "partition_speed: %s\n", error.what());
    return 1;
  }
}
