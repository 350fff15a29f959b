// The claim: 64 ranks make and adapt a mesh 45 times as fast as one, as far as computing and messages go. A prediction:
// what each rank computes and sends is measured, on ranks that are threads of this process; what a network would take
// for it is reckoned.
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "bench/support/measured_ranks.hpp"
#include "bench/support/session.hpp"
#include "tetloom/adapt.hpp"
#include "tetloom/mesh.hpp"
#include "tetloom/model.hpp"

namespace tetloom::bench {
namespace {

struct Options {
  std::string model = "spline-block";
  std::vector<double> sizes{1.4, 0.8};
  std::vector<int> ranks{1, 8, 64};
  double stretch = 1.5;
  double latency = 10, bandwidth = 1;
  bool adapts = true;
  SessionOptions session;
};

/// One line of the table.
struct Case {
  int ranks = 1;
  bool adapts = false;
  std::uint64_t tets = 0;
  RankPhases phases;
};

MeshOptions mesh_options(double size) {
  MeshOptions options;
  options.sizes.size = size;
  options.threads = 1;
  return options;
}

std::uint64_t count_tets(const PartitionedMesh& mesh, Communicator& ranks) {
  std::int64_t count = 0;
  for (const PartId part : mesh.local())
    count += static_cast<std::int64_t>(mesh.parts.at(part).mesh.block(CellKind::Tet).size());
  ranks.sum(std::span(&count, 1));
  return static_cast<std::uint64_t>(count);
}

PartitionedMesh make_parts(const GeometricModel& model, double size, Communicator& ranks) {
  MeshInPartsResult made = make_mesh_in_parts(model, mesh_options(size), ranks);
  if (made.run.status != MeshStatus::Ok) throw Error(made.run.errors.at(0));
  return std::move(*made.mesh);
}

class Bench {
 public:
  explicit Bench(const Options& options)
      : options_(options),
        session_("rank_speedup", options.session),
        document_(read_model(session_.model_path(options.model))) {}

  void run() {
    session_.print_heading("no peer");
    std::printf(
        "Prediction, not a measurement, but for tets, processor seconds and bytes: a message takes %g us, and its "
        "bytes over %g GB/s; ranks wait for the slowest in each collective call.\n\n",
        options_.latency, options_.bandwidth);
    std::printf("%-8s %12s %6s %12s %10s %10s %9s %14s\n", "step", "tets", "ranks", "processor s", "waiting s",
                "seconds", "speed-up", "most sent MB");
    for (const bool adapts : {false, true})
      for (const double size : options_.sizes)
        if (!adapts || options_.adapts) measure(size, adapts);
    session_.write_json(json_, "");
  }

 private:
  void measure(double size, bool adapts) {
    double first = 0;
    for (const int ranks : options_.ranks) {
      Case one{ranks, adapts, 0, {}};
      one.phases = measure_ranks(ranks, [&](Communicator& communicator, const std::function<void()>& start) {
        const std::uint64_t tets = adapts ? adapt_on(size, communicator, start) : mesh_on(size, communicator, start);
        if (communicator.rank() == 0) one.tets = tets;
      });
      const double seconds = predict_seconds(one.phases, {1e-6 * options_.latency, 1e9 * options_.bandwidth});
      if (first == 0) first = seconds * ranks;
      print(one, seconds, first);
    }
  }

  std::uint64_t mesh_on(double size, Communicator& ranks, const std::function<void()>& start) const {
    start();
    return count_tets(make_parts(*document_.model, size, ranks), ranks);
  }

  // To sizes that grow along z, about as many tets as there were.
  std::uint64_t adapt_on(double size, Communicator& ranks, const std::function<void()>& start) const {
    PartitionedMesh mesh = make_parts(*document_.model, size, ranks);
    const Box3 box = document_.model->bounding_box();
    const auto metric = [&](const Vec3& x) {
      const double share = (x.z - box.lo.z) / (box.hi.z - box.lo.z);
      const double h = size * std::pow(options_.stretch, 2 * share - 1) * 0.95;
      return adapt::isotropic(h);
    };
    AdaptOptions options;
    options.threads = 1;
    start();
    const AdaptInPartsResult result = adapt_mesh_in_parts(std::move(mesh), metric, options);
    if (result.run.status != AdaptStatus::Ok) throw Error(result.run.errors.at(0));
    return count_tets(*result.mesh, ranks);
  }

  void print(const Case& one, double seconds, double first) {
    const char* step = one.adapts ? "adapt" : "mesh";
    std::printf("%-8s %12llu %6d %12.2f %10.2f %10.2f %9.2f %14.2f\n", step, static_cast<unsigned long long>(one.tets),
                one.ranks, processor_seconds(one.phases), compute_seconds(one.phases), seconds, first / seconds,
                1e-6 * static_cast<double>(most_sent_bytes(one.phases)));
    std::fflush(stdout);
    json_.push_back({{"step", step},
                     {"tets", one.tets},
                     {"ranks", one.ranks},
                     {"processor_seconds", processor_seconds(one.phases)},
                     {"waiting_seconds", compute_seconds(one.phases)},
                     {"seconds", seconds},
                     {"speed_up", first / seconds},
                     {"phases", one.phases[0].size()},
                     {"most_sent_bytes", most_sent_bytes(one.phases)}});
  }

  Options options_;
  Session session_;
  ModelDocument document_;
  nlohmann::json json_ = nlohmann::json::array();
};

int run(int argc, char** argv) {
  Options options;
  CommandLine line("Speed-up of meshing and adaptation by ranks, predicted from what they compute and send",
                   "rank_speedup");
  line.add("--model", options.model, "a demo model or a CAD file");
  line.add("--sizes", options.sizes, "target edges, model length").positive();
  line.add("--ranks", options.ranks, "numbers of ranks; the first is what others are compared with").positive();
  line.add("--stretch", options.stretch, "adaptation: the largest size beside the one that was meshed with").positive();
  line.add("--latency", options.latency, "of a message, in microseconds").not_negative();
  line.add("--bandwidth", options.bandwidth, "of a rank, in GB/s").positive();
  bool meshes_alone = false;
  line.add_flag("--no-adapt", meshes_alone, "mesh alone");
  add_session_options(line, options.session);
  if (const auto status = line.parse(argc, argv)) return *status;
  options.adapts = !meshes_alone;
  if (options.session.quick) options.sizes = {20}, options.ranks = {1, 3};
  Bench(options).run();
  return 0;
}

}  // namespace
}  // namespace tetloom::bench

int main(int argc, char** argv) { return tetloom::bench::run_bench("rank_speedup", tetloom::bench::run, argc, argv); }
